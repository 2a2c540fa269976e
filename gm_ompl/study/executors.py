"""Executors by what users write: ``local``, or ``dask://ADDRESS``."""

from __future__ import annotations

from gm_ompl.errors import InputError
from gm_ompl.study.workers import Executor, LocalExecutor

LOCAL, DASK = "local", "dask://"


def make_executor(where: str) -> Executor:
    """Return the executor called ``where``.

    Raises:
        InputError: it is neither ``local`` nor ``dask://ADDRESS``, or there is no cluster there.
        MissingExtraError: dask.distributed is not installed.
    """
    if where == LOCAL:
        return LocalExecutor()
    if where.startswith(DASK) and len(where) > len(DASK):
        from gm_ompl.study.cluster import DaskExecutor

        return DaskExecutor(where.removeprefix(DASK))
    raise InputError(f"--executor {where}: must be {LOCAL} or {DASK}HOST:PORT")
