"""What a forked process does: one run, told through a pipe, and the end."""

from __future__ import annotations

import json
import math
import os
import resource
from typing import Any, NoReturn

from gm_ompl.errors import GmOmplError
from gm_ompl.study.endings import hard_time_limit
from gm_ompl.study.run import carry_out
from gm_ompl.study.task import Task
from gm_ompl.study.warm import compiled_versions, pack


def run_and_exit(task: Task, pipe: int) -> NoReturn:
    """Carry the task out, tell the result through ``pipe``, and end this process.

    Told is what a record keeps, and under ``compiled`` what had to be loaded on the way.
    """
    code = 1
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for standard in (0, 1, 2):  # what a library prints must not get between the answers
            os.dup2(nowhere, standard)
        limit = hard_time_limit(task.limits)
        if limit < math.inf:  # a second net, for a run that outlives the server
            seconds = math.ceil(limit) + 1
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        with open(pipe, "wb") as stream:
            stream.write(json.dumps(_told(task)).encode())
        code = 0
    finally:
        os._exit(code)  # no clean-up of what belongs to the server


def _told(task: Task) -> dict[str, Any]:
    before = compiled_versions()
    try:
        told = carry_out(task)
    except GmOmplError as error:
        told = {"status": "refused", "message": str(error)}
    except Exception as error:
        told = {"status": "error", "message": f"{type(error).__name__}: {error}"}
    return {**told, "compiled": pack(compiled_versions() - before)}
