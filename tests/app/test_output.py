"""Where output goes: pipes whose reader leaves, full disks, devices; no library's word on stderr."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import threading
from pathlib import Path

import pytest

SMALL = ["paper/slide", "--set", "lattice.segments=3", "--set", "fingers.placements.grid=[2, 2]"]

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="no /dev/full on this system")

NO_SPACE = "No space left on device"

COMMAND = [sys.executable, "-P", "-m", "gm_ompl"]


def run(
    *arguments: str | Path, stdout: object = subprocess.PIPE, most_bytes: int | None = None
) -> subprocess.CompletedProcess[str]:
    """Run the command; with ``most_bytes`` no file may become larger, as on a full disk."""

    def limit() -> None:
        assert most_bytes is not None
        resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

    return subprocess.run(
        [*COMMAND, *map(str, arguments)], stdout=stdout, stderr=subprocess.PIPE, text=True,
        timeout=120, check=False, preexec_fn=None if most_bytes is None else limit,
    )  # type: ignore[call-overload,no-any-return]  # fmt: skip


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("plans") / "plan.json"
    assert run("plan", *SMALL, "-o", path).returncode == 0
    return path


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["--help"], 0),
        (["list"], 0),
        (["plan", *SMALL], 0),
        (["plan", *SMALL, "--set", "mechanics.z_min=1000"], 3),
    ],
    ids=["help", "list", "plan", "infeasible"],
)
def test_a_reader_that_leaves_changes_nothing(arguments: list[str], code: int) -> None:
    """Into a closed pipe: the verb's own exit code, and not a word about it."""
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as pipe:
        result = run(*arguments, stdout=pipe)
    assert result.returncode == code
    assert "Error" not in result.stderr and "rror:" not in result.stderr


@needs_full
@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["list", "--json"], ["plan"]])
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
    result = run("plan", *SMALL, option, FULL)
    assert result.returncode == 2
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
        ("execute", ["--probe", "0", "--video", "out.mp4"]),
        ("execute", ["--probe", "0", "--video", "out.gif"]),
    ],
)
def test_a_disk_that_fills_leaves_the_old_file(
    verb: str, options: list[str], plan_file: Path, tmp_path: Path
) -> None:
    """Where no more can be written: exit code 2, one line with the name, the old file untouched."""
    out = tmp_path / options[-1]
    out.write_text("old")
    named = [*options[:-1], str(out)]
    subject = SMALL if verb == "plan" else [str(plan_file)]
    result = run(verb, *subject, *named, most_bytes=512)
    if "cannot render" in result.stderr:
        pytest.skip(result.stderr)
    assert result.returncode == 2, result.stderr
    assert "Traceback" not in result.stderr
    assert f"cannot write {out}: " in result.stderr.splitlines()[-1]
    assert out.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == [out.name]


def test_compare_on_a_full_disk_ends_with_2(tmp_path: Path) -> None:
    """The store of runs, SQLite's, is named where it cannot grow."""
    result = run("compare", "paper/slide", "--planners", "astar", "-o", tmp_path, most_bytes=512)
    assert result.returncode == 2, result.stderr
    assert f"gm-ompl: {tmp_path / 'runs.sqlite'}: " in result.stderr


@pytest.mark.parametrize("name", ["-", "/dev/stdout"])
def test_the_plan_goes_down_a_pipe(name: str) -> None:
    """``-o /dev/stdout`` and ``-o -`` give the plan file alone; the summary is on stderr."""
    for extra in ([], ["--json"]):
        result = run("plan", *SMALL, "-o", name, *extra)
        assert result.returncode == 0
        assert json.loads(result.stdout)["status"] == "solved"
    assert "solved by astar" in run("plan", *SMALL, "-o", name).stderr


def test_the_standard_output_in_a_file_is_not_replaced(tmp_path: Path) -> None:
    """``-o /dev/stdout >> log`` adds to the log what is written, as a shell's user expects."""
    log = tmp_path / "log"
    log.write_text("before\n")
    with log.open("a") as stream:
        assert run("plan", *SMALL, "-o", "/dev/stdout", stdout=stream).returncode == 0
    first, rest = log.read_text().split("\n", 1)
    assert first == "before"
    assert json.loads(rest)["status"] == "solved"


def test_a_pipe_with_a_name_is_written_to(tmp_path: Path, plan_file: Path) -> None:
    """A fifo as ``-o`` gives its reader the file, and is a fifo still; so does a trace."""
    fifo, heard = tmp_path / "out.csv", list[str]()
    os.mkfifo(fifo)
    reader = threading.Thread(target=lambda: heard.append(fifo.read_text()), daemon=True)
    reader.start()
    assert run("export", plan_file, "-o", fifo).returncode == 0
    reader.join(30)
    assert heard and heard[0].startswith("t")
    assert fifo.is_fifo()


def test_the_null_device_takes_all(plan_file: Path) -> None:
    """``-o /dev/null`` is no error, and the device is one still."""
    assert run("plan", *SMALL, "-o", os.devnull).returncode == 0
    assert run("export", plan_file, "-o", os.devnull).returncode == 0
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
