"""Exit codes, and the one place where exceptions become messages."""

from __future__ import annotations

import enum
import errno
import functools
import json
import sys
import traceback
from collections.abc import Callable
from typing import Any

from gm_ompl.errors import InputError, LimitError


class Exit(enum.IntEnum):
    """What the process's exit code says."""

    OK = 0  # solved, or holds
    BUG = 1
    BAD_INPUT = 2
    INFEASIBLE = 3  # proven on the scenario's lattice
    BUDGET = 4  # spent without a plan
    REFUTED = 5  # check found that the plan does not hold
    INTERRUPTED = 130  # what shells report for Ctrl-C


EXIT_OF_STATUS = {
    "solved": Exit.OK,
    "infeasible": Exit.INFEASIBLE,
    "budget": Exit.BUDGET,
    "interrupted": Exit.INTERRUPTED,
}

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""What the system says where no more can be written."""

TRACEBACK_VARIABLE = "GM_OMPL_TRACEBACK"


class Switches:
    """Set by the options that stand before the verb."""

    show_traceback = False


def guarded(command: Callable[..., Exit]) -> Callable[..., None]:
    """Turn a command that returns its exit code into one that ends the process with it.

    With ``--json`` an error, too, is one JSON object on stdout.
    """

    @functools.wraps(command)
    def wrapper(*args: Any, **kwargs: Any) -> None:
        try:
            code = command(*args, **kwargs)
            sys.stdout.flush()
        except KeyboardInterrupt:
            code = _fail(Exit.INTERRUPTED, "interrupted", kwargs)
        except LimitError as error:
            code = _fail(Exit.BUDGET, str(error), kwargs)
        except InputError as error:
            code = _fail(Exit.BAD_INPUT, str(error), kwargs)
        except OSError as error:
            full = error.errno in _FULL
            message = f"cannot write {error.filename or 'a file'}: {error.strerror}"
            code = _fail(
                Exit.BAD_INPUT if full else Exit.BUG,
                message if full else _describe_bug(error),
                kwargs,
            )
        except Exception as error:
            code = _fail(Exit.BUG, _describe_bug(error), kwargs)
        raise SystemExit(int(code))

    return wrapper


def _fail(code: Exit, message: str, kwargs: dict[str, Any]) -> Exit:
    if Switches.show_traceback:
        traceback.print_exc()
    sys.stderr.write(f"gm-ompl: {message}\n")
    if kwargs.get("as_json"):
        sys.stdout.write(json.dumps({"error": message, "exit_code": int(code)}) + "\n")
    return code


def _describe_bug(error: Exception) -> str:
    text = " ".join(str(error).split())
    hint = f"gm-ompl --traceback ..., or {TRACEBACK_VARIABLE}=1, shows where"
    return f"internal error: {type(error).__name__}: {text} ({hint})"
