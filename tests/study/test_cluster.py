"""Runs on a dask cluster: the same results, whatever is lost on the way."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

import gm_ompl
from gm_ompl.errors import InputError
from gm_ompl.forks import RunLimits
from gm_ompl.study.cluster import DaskExecutor, make_executor, secured
from gm_ompl.study.compare import compare, make_tasks
from gm_ompl.study.store import RunRecord, Store
from gm_ompl.study.task import Task
from gm_ompl.study.workers import LocalExecutor

SMALL = ("lattice.segments=3", "fingers.placements.grid=[2, 2]")


def small_tasks(seeds: int) -> tuple[Task, ...]:
    scenario = gm_ompl.load("paper/slide", SMALL)
    return make_tasks([scenario], ("RRT", "HybridRRT"), seeds, RunLimits(max_iterations=50))


class Cluster:
    """A scheduler and two workers on this machine; a supervisor that starts lost ones again."""

    def __init__(self) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.over = threading.Event()
        scheduler = ["dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port)]
        worker = ["dask_worker", f"tcp://127.0.0.1:{self.port}", "--nthreads", "1", "--no-nanny",
                  "--host", "127.0.0.1"]  # fmt: skip
        self.commands = [scheduler, worker, worker]
        self.running = [self._start(command) for command in self.commands]
        self.supervisor = threading.Thread(target=self._supervise)
        self.supervisor.start()

    def _start(self, command: list[str]) -> subprocess.Popen[bytes]:
        module, *arguments = command
        return subprocess.Popen(
            [sys.executable, "-P", "-m", f"distributed.cli.{module}", *arguments, "--no-dashboard"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "5s"},
        )  # fmt: skip

    def _supervise(self) -> None:
        while not self.over.wait(0.2):
            for place, process in enumerate(self.running):
                if process.poll() is not None:
                    self.running[place] = self._start(self.commands[place])

    def kill(self, place: int) -> None:
        self.running[place].send_signal(signal.SIGKILL)

    def close(self) -> None:
        self.over.set()
        self.supervisor.join()
        for process in reversed(self.running):
            process.kill()
            process.wait()


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    with closing(Cluster()) as made:
        yield made


def connected(cluster: Cluster) -> DaskExecutor:
    for _ in range(20):
        try:
            return DaskExecutor(f"127.0.0.1:{cluster.port}")
        except InputError:  # it is still starting
            time.sleep(0.5)
    raise AssertionError("the scheduler does not start")


def found(records: tuple[RunRecord, ...]) -> list[tuple[object, ...]]:
    return [
        (r.key, r.status, r.cost, r.regrasps, r.least_z, r.mode_decisions, r.iterations)
        for r in records
    ]


@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_comparison_survives_the_loss_of_a_worker_and_of_the_scheduler(
    cluster: Cluster, tmp_path: Path
) -> None:
    """One worker is killed midway, the scheduler once; all runs are there, once, as made here."""
    tasks, told = small_tasks(12), []

    class Disturbed:
        def __init__(self, executor: DaskExecutor) -> None:
            self.executor = executor

        def run(self, left: tuple[Task, ...]) -> Iterator[tuple[Task, dict[str, object]]]:
            for task, outcome in self.executor.run(left):
                told.append(task.key())
                if len(told) == 5:
                    cluster.kill(1)
                if len(told) == 14:
                    cluster.kill(0)
                yield task, outcome

        def close(self) -> None:
            self.executor.close()

    with Store(tmp_path / "c.sqlite") as store, closing(Disturbed(connected(cluster))) as executor:
        records = compare(tasks, store, executor)  # type: ignore[arg-type]
        assert len(store.all()) == len(tasks)
    assert sorted(told) == sorted(task.key() for task in tasks)
    with Store(tmp_path / "l.sqlite") as store, closing(LocalExecutor()) as local:
        assert found(compare(tasks, store, local)) == found(records)


def test_an_address_is_spoken_to_openly_on_this_machine_alone() -> None:
    """Over a network only with certificates; what is no address is refused."""
    assert secured("127.0.0.1:8786", tls=False) == "tcp://127.0.0.1:8786"
    assert secured("localhost:8786", tls=True) == "tls://localhost:8786"
    assert secured("node7:8786", tls=True) == "tls://node7:8786"
    for address in ("node7:8786", "10.0.0.7:8786", "tcp://node7:8786"):
        with pytest.raises(InputError, match="ssh -L 8786"):
            secured(address, tls=False)
    with pytest.raises(InputError, match="certificates"):
        secured("tls://node7:8786", tls=False)
    for address in ("node7", "http://node7:80", ":8786", "node7:port"):
        with pytest.raises(InputError, match="HOST:PORT"):
            secured(address, tls=False)


def test_executors_are_named() -> None:
    """What is neither here nor a cluster is refused, and so is a cluster that is not there."""
    for wrong in ("cloud", "dask://", "dask://127.0.0.1:1"):
        with pytest.raises(InputError, match="--executor"):
            make_executor(wrong)
