"""Where output goes: pipes whose reader leaves, full disks, devices; no library's words."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from gm_ompl.app.main import app
from gm_ompl.errors import InputError
from gm_ompl.simulation.video import Film
from gm_ompl.study.store import JournalLock, Store, writing_journal

SMALL = ["paper/slide", "--set", "lattice.segments=3", "--set", "fingers.placements.grid=[2, 2]"]

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="no /dev/full on this system")

NO_SPACE = "No space left on device"

COMMAND = [sys.executable, "-P", "-m", "gm_ompl"]


def run(
    *arguments: str | Path, stdout: int | IO[str] = subprocess.PIPE
) -> subprocess.CompletedProcess[str]:
    """Run the command in a process of its own."""
    result: subprocess.CompletedProcess[str] = subprocess.run(
        [*COMMAND, *map(str, arguments)],
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
        timeout=120,
        check=False,
    )
    return result


def invoke(*arguments: str | Path) -> Result:
    """Run the command in this process."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@contextmanager
def full_disk(most_bytes: int = 512) -> Iterator[None]:
    """Let no file of this process or a child become larger, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("plans") / "plan.json"
    assert invoke("plan", *SMALL, "-o", path).exit_code == 0
    return path


@pytest.mark.parametrize(
    ("arguments", "code"),
    [(["--help"], 0), (["list"], 0), (["check", "wrong.json"], 5)],
    ids=["help", "list", "refuted"],
)
def test_a_reader_that_leaves_changes_nothing(
    arguments: list[str], code: int, plan_file: Path, tmp_path: Path
) -> None:
    """Into a closed pipe: the verb's own exit code, and not a word about it."""
    if code:
        wrong = json.loads(plan_file.read_text())
        arguments = ["check", str(tmp_path / "wrong.json")]
        (tmp_path / "wrong.json").write_text(json.dumps({**wrong, "cost": 2.0 * wrong["cost"]}))
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as pipe:
        result = run(*arguments, stdout=pipe)
    assert result.returncode == code
    assert "Error" not in result.stderr and "rror:" not in result.stderr


@needs_full
@pytest.mark.parametrize("arguments", [["--help"], ["plan"]])
def test_a_full_standard_output_ends_with_2(arguments: list[str], tmp_path: Path) -> None:
    """stdout on a full device: one line on stderr that says so, 2; the plan is still written."""
    path = tmp_path / "plan.json"
    whole = [*arguments, *SMALL, "-o", str(path)] if arguments == ["plan"] else arguments
    with FULL.open("w") as device:
        result = run(*whole, stdout=device)
    assert result.returncode == 2
    lines = [line for line in result.stderr.splitlines() if line.startswith("gm-ompl:")]
    assert lines == [f"gm-ompl: cannot write the standard output: {NO_SPACE}"]
    assert "Traceback" not in result.stderr
    assert path.exists() == (arguments == ["plan"])


@needs_full
@pytest.mark.parametrize("option", ["-o", "--html", "--trace"])
def test_a_full_device_ends_with_2(option: str) -> None:
    """``-o /dev/full`` and its like: one line that names it, exit code 2."""
    result = invoke("plan", *SMALL, option, FULL)
    assert result.exit_code == 2
    assert result.stderr.splitlines()[-1] == f"gm-ompl: cannot write /dev/full: {NO_SPACE}"


@pytest.mark.parametrize(
    ("verb", "options"),
    [
        ("plan", ["-o", "out.json"]),
        ("plan", ["--html", "out.html"]),
        ("plan", ["--trace", "out.jsonl"]),
        ("export", ["-o", "out.csv"]),
        ("plot", ["-o", "out.pdf"]),
        ("plot", ["-o", "out.png"]),
        ("plot", ["-o", "out.svg"]),
        ("view", ["--html", "out.html"]),
    ],
)
def test_a_disk_that_fills_leaves_the_old_file(
    verb: str, options: list[str], plan_file: Path, tmp_path: Path
) -> None:
    """Where no more can be written: exit code 2, one line with the name, the old file untouched."""
    out = tmp_path / options[-1]
    out.write_text("old")
    subject = SMALL if verb == "plan" else [str(plan_file)]
    with full_disk():
        result = invoke(verb, *subject, *options[:-1], out)
    refused(result.exit_code, result.stderr, out)


@pytest.mark.parametrize("name", ["film.mp4", "film.gif"])
def test_a_film_that_does_not_fit_leaves_the_old_file(name: str, tmp_path: Path) -> None:
    """What holds for other files holds for films, which other programs write."""
    pytest.importorskip("imageio_ffmpeg")
    out = tmp_path / name
    out.write_text("old")
    pictures = np.random.default_rng(0).integers(0, 255, (48, 64, 3), dtype=np.uint8)
    camera = nullcontext(lambda: pictures)
    player: Any = SimpleNamespace(
        timeline=SimpleNamespace(position=np.zeros((1, 3))), units=SimpleNamespace(length=1.0),
        physics=SimpleNamespace(camera=lambda *_: camera),
    )  # fmt: skip

    def record() -> None:
        with Film(out) as film:
            for instant in range(0, 200, 50):
                film(player, instant)

    with full_disk(), pytest.raises(InputError) as error:
        record()
    refused(2, str(error.value), out)
    record()
    assert out.stat().st_size > 512


def refused(code: int, message: str, out: Path) -> None:
    """Check that a file was refused in a line, and that nothing else changed in its folder."""
    assert code == 2, message
    assert f"cannot write {out}: " in message.splitlines()[-1]
    assert out.read_text() == "old"
    assert [path.name for path in out.parent.iterdir()] == [out.name]


def test_a_store_of_runs_on_a_full_disk_is_bad_input(tmp_path: Path) -> None:
    """compare's and tune's store, SQLite's, is named where it cannot grow."""
    with full_disk(), pytest.raises(InputError, match=r"runs\.sqlite: "):
        Store(tmp_path / "runs.sqlite")


def test_a_journal_on_a_full_disk_is_bad_input_and_no_lock_stays(tmp_path: Path) -> None:
    """tune's journal is named where it cannot grow; a killed process leaves no lock."""
    optuna, path = pytest.importorskip("optuna"), tmp_path / "journal.log"
    (tmp_path / "journal.log.lock").write_text("")  # left by a killed call
    backend = optuna.storages.journal.JournalFileBackend(str(path), JournalLock(path))
    with (
        full_disk(),
        pytest.raises(InputError, match=r"cannot write .*journal\.log: "),
        writing_journal(path),
    ):
        backend.append_logs([{"text": "x" * 1000}])
    backend.append_logs([{"text": "after"}])


@pytest.mark.parametrize("name", ["-", "/dev/stdout"])
def test_the_plan_goes_down_a_pipe(name: str) -> None:
    """``-o /dev/stdout`` and ``-o -`` give the plan file alone; the summary is on stderr."""
    extra = ["--json"] if name == "-" else []
    result = invoke("plan", *SMALL, "-o", name, *extra)
    assert result.exit_code == 0
    assert json.loads(result.stdout)["status"] == "solved"
    assert ("solved by astar" in result.stderr) == (not extra)


def test_the_standard_output_in_a_file_is_not_replaced(plan_file: Path, tmp_path: Path) -> None:
    """``-o /dev/stdout >> log`` adds to the log what is written, as a shell's user expects."""
    log = tmp_path / "log"
    log.write_text("before\n")
    with log.open("a") as stream:
        assert run("export", plan_file, "-o", "/dev/stdout", stdout=stream).returncode == 0
    first, rest = log.read_text().split("\n", 1)
    assert first == "before"
    assert rest.startswith("# gm-ompl export")


def test_a_pipe_with_a_name_is_written_to(tmp_path: Path, plan_file: Path) -> None:
    """A fifo as ``-o`` gives its reader the file, and is a fifo still."""
    fifo, heard = tmp_path / "out.csv", list[str]()
    os.mkfifo(fifo)
    reader = threading.Thread(target=lambda: heard.append(fifo.read_text()), daemon=True)
    reader.start()
    assert invoke("export", plan_file, "-o", fifo).exit_code == 0
    reader.join(30)
    assert heard and heard[0].startswith("# gm-ompl export")
    assert fifo.is_fifo()


def test_the_null_device_takes_all(plan_file: Path) -> None:
    """``-o /dev/null`` is no error, and the device is one still."""
    assert invoke("plan", *SMALL, "-o", os.devnull).exit_code == 0
    assert invoke("export", plan_file, "-o", os.devnull).exit_code == 0
    assert Path(os.devnull).is_char_device()


def test_no_library_warns_on_the_terminal() -> None:
    """Neither warnings nor logs of libraries reach stderr, nor do those of child processes."""
    code = (
        "import gm_ompl.app.main as m, logging, subprocess, sys, warnings\n"
        "def verb():\n"
        "    warnings.simplefilter('always')\n"
        "    warnings.warn('from a library')\n"
        "    logging.getLogger('trimesh').warning('from its log')\n"
        "    child = 'import warnings; warnings.warn(\"from a child\")'\n"
        "    subprocess.run([sys.executable, '-c', child], check=True)\n"
        "m.app.command('warn')(verb)\n"
        "sys.argv = ['gm-ompl', 'warn']\n"
        "m.run()\n"
    )
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONWARNINGS"}
    result = subprocess.run(
        [sys.executable, "-P", "-c", code], capture_output=True, text=True, check=False,
        env=environment, timeout=60,
    )  # fmt: skip
    assert (result.returncode, result.stderr) == (0, "")


def test_an_unstable_simulation_is_silent(tmp_path: Path) -> None:
    """MuJoCo's warnings are neither printed nor written into the folder one happens to be in."""
    pytest.importorskip("mujoco")
    code = """
from gm_ompl.simulation.physics import load
mujoco = load()
body = "<body><joint type='hinge'/><geom size='1'/></body>"
model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
data = mujoco.MjData(model)
data.qvel[0] = 1e300
mujoco.mj_step(model, data)
assert sum(warning.number for warning in data.warning) == 1
"""
    result = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True,
        check=False, timeout=120,
    )  # fmt: skip
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
    assert list(tmp_path.iterdir()) == []
