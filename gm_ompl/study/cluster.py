"""Runs on a dask cluster: the only import of dask and distributed.

A dask worker keeps a server of its own (``workers.LocalExecutor``), so that runs there are forked
from a warm process, limited and told apart from crashes just as they are here. Which runs are done
is known here alone: what a lost worker or scheduler had in hand is sent again.
"""

from __future__ import annotations

import atexit
import concurrent.futures
import ipaddress
import logging
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from types import ModuleType
from typing import Any, final

from gm_ompl.errors import GmOmplError, InputError, MissingExtraError
from gm_ompl.study.task import Task, code_version
from gm_ompl.study.workers import ATTEMPTS, Executor, LocalExecutor, Outcome

LOCAL, DASK = "local", "dask://"
"""What users write for an executor; the second goes before an address."""

RECONNECT_S = 120.0  # how long a lost scheduler is waited for [s]
CONNECT_S = 10.0  # how long one attempt to connect takes at most [s]

LOST = (OSError, TimeoutError, concurrent.futures.CancelledError)
"""How a lost scheduler shows itself; distributed's own closed connections are OSErrors."""

_here = threading.local()  # on a worker, per thread, its executor


def remote_run(tree: dict[str, Any], code: str) -> Outcome:
    """Make one run; on a worker.

    Args:
        tree: the task, as ``Task.to_dict`` writes it.
        code: the version of the code that asks.

    Returns:
        The outcome, or ``{"code": version}`` where this worker's code is another.
    """
    if code != code_version():
        return {"code": code_version()}
    if not hasattr(_here, "executor"):
        _here.executor = LocalExecutor(workers=1)
        atexit.register(_here.executor.close)
    executor: LocalExecutor = _here.executor
    ((_, outcome),) = executor.run([Task.from_dict(tree)])
    return outcome


@final
class DaskExecutor:
    """Runs on the workers of a dask cluster.

    A worker that dies loses the run in hand, which is sent to another; when the scheduler is lost,
    it is waited for, and what has not come back is sent again.

    Args:
        address: of the scheduler, HOST:PORT, tcp://HOST:PORT or tls://HOST:PORT.

    Raises:
        InputError: there is no scheduler, or it would be spoken to in the open over a network.
        MissingExtraError: dask.distributed is not installed.
    """

    def __init__(self, address: str) -> None:
        self._dask = _distributed()
        security = self._dask.Security()
        tls = (security.tls_ca_file, security.tls_client_cert, security.tls_client_key)
        self.address = secured(address, all(tls))
        try:
            self._client = self._connect()
        except OSError as error:
            raise InputError(f"--executor dask://{address}: no scheduler there: {error}") from None

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[Task, Outcome]]:
        """Yield each task with its outcome, as they finish.

        Raises:
            GmOmplError: the scheduler stays away, a worker has other code, or runs keep being lost.
        """
        left = dict(enumerate(tasks))
        losses = dict.fromkeys(left, 0)
        while left:
            try:
                for number, outcome in self._results(left, losses):
                    yield left.pop(number), outcome
            except LOST:
                self._reconnect()

    def _results(
        self, left: dict[int, Task], losses: dict[int, int]
    ) -> Iterator[tuple[int, Outcome]]:
        """Send what is left and yield what comes back; what a worker lost is only counted."""
        code = code_version()
        sent = {
            self._client.submit(remote_run, task.to_dict(), code, pure=False, retries=0): number
            for number, task in left.items()
        }
        try:
            for future in self._dask.as_completed(list(sent), loop=self._client.loop):
                number = sent[future]
                if future.status == "finished":
                    yield number, _checked(future.result(timeout=CONNECT_S), code)
                elif future.status == "error":
                    losses[number] += 1
                    if losses[number] >= ATTEMPTS:
                        raise GmOmplError(
                            f"a run failed on the cluster again and again: {future.exception()!r}"
                        )
                else:  # lost, cancelled: the scheduler has forgotten it
                    raise OSError("the scheduler was lost")
        finally:
            with suppress(*LOST):  # a scheduler that is gone has nothing to forget
                self._client.cancel([future for future in sent if not future.done()], force=True)

    def _connect(self) -> Any:
        return self._dask.Client(
            self.address, timeout=CONNECT_S, set_as_default=False, name="gm-ompl"
        )

    def _reconnect(self) -> None:
        """Wait for a scheduler at the same address."""
        self.close()
        end = time.monotonic() + RECONNECT_S
        while True:
            try:
                self._client = self._connect()
                return
            except OSError as error:
                if time.monotonic() > end:
                    raise GmOmplError(f"{self.address}: the scheduler was lost: {error}") from None
                time.sleep(1.0)

    def close(self) -> None:
        """Leave the cluster; it stays up."""
        with suppress(*LOST):
            self._client.close(timeout=CONNECT_S)


def _checked(outcome: Outcome, code: str) -> Outcome:
    if "code" in outcome:
        raise GmOmplError(
            f"a worker has version {outcome['code']} of the code that plans, here it is {code}; "
            "install the same on all machines"
        )
    return outcome


def secured(address: str, tls: bool) -> str:
    """Return the address with its protocol.

    Args:
        address: with or without protocol.
        tls: whether dask's configuration names certificates.

    Raises:
        InputError: it is no address, or would be spoken to without TLS outside this machine.
    """
    scheme, _, place = address.rpartition("://")
    host, _, port = place.rpartition(":")
    if scheme not in ("", "tcp", "tls") or not host or not port.isdecimal():
        raise InputError(f"--executor dask://{address}: must be dask://HOST:PORT")
    scheme = scheme or ("tls" if tls else "tcp")
    if scheme == "tls" and not tls:
        raise InputError(
            f"--executor dask://{address}: dask's configuration names no certificates; set "
            "distributed.comm.tls.ca-file and distributed.comm.tls.client.cert and .key"
        )
    if scheme == "tcp" and not _loopback(host):
        raise InputError(
            f"--executor dask://{address}: without TLS only this machine is spoken to (whoever "
            "reaches a scheduler runs code on it); configure TLS for dask, or open a tunnel: "
            f"ssh -L {port}:localhost:{port} {host}"
        )
    return f"{scheme}://{place}"


def _loopback(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def _distributed() -> ModuleType:
    try:
        import distributed
    except ImportError:
        raise MissingExtraError("dask.distributed", "cluster") from None
    # What its log says of lost connections is said here.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    module: ModuleType = distributed
    return module


def make_executor(where: str) -> Executor:
    """Return the executor called ``where``.

    Raises:
        InputError: it is neither ``local`` nor ``dask://ADDRESS``, or there is no cluster there.
        MissingExtraError: dask.distributed is not installed.
    """
    if where == LOCAL:
        return LocalExecutor()
    if where.startswith(DASK) and len(where) > len(DASK):
        return DaskExecutor(where.removeprefix(DASK))
    raise InputError(f"--executor {where}: must be {LOCAL} or {DASK}HOST:PORT")
