"""What is no file of the right kind is refused by every verb that would read it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import gm_ompl
from gm_ompl import reading
from gm_ompl.app.main import app
from gm_ompl.planfile import files as plan_files

SMALL = ["lattice.segments=3", "fingers.placements.grid=[2, 2]"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a plan, a scenario, a trace, and files that are none."""
    place = tmp_path_factory.mktemp("files")
    scenario = gm_ompl.load("paper/slide", SMALL)
    gm_ompl.plan(scenario).save(place / "plan.json")
    (place / "scenario.json").write_text(json.dumps(scenario.resolved()))
    text = "format: gm-ompl-scenario/1\n# a comment\nname: x\n"
    (place / "scenario.yaml").write_text(text)
    (place / "trace.jsonl").write_text('{"format": "gm-ompl-trace/1", "planner": "astar"}\n')
    (place / "folder").mkdir()
    (place / "binary").write_bytes(b"\x7fELF\x02\x01\xff\xfe\x00\x00")
    (place / "wide").write_bytes(text.encode("utf-16"))
    (place / "latin").write_bytes(b'{"name": "K\xe4fig"}')
    with (place / "huge").open("wb") as stream:
        stream.truncate(2**40)
    os.mkfifo(place / "fifo")
    return place


READERS = (
    ("check", "{}"), ("view", "{}", "--html", "out.html"), ("plot", "{}", "-o", "out.pdf"),
    ("export", "{}", "-o", "out.csv"), ("execute", "{}"),
    ("plot", "plan.json", "--show", "search", "--trace", "{}", "-o", "out.pdf"),
    ("plan", "{}"), ("explain", "{}"), ("compare", "{}", "--planners", "astar", "-o", "out"),
    ("tune", "{}", "--hold-out", "{}", "--planner", "HybridRRT", "--trials", "1", "-o", "o.json"),
    ("bench", "--scenario", "{}"), ("plan", "paper/slide", "--params", "{}"),
)  # fmt: skip
"""Command lines in which {} is read; "out" is written."""

NO_FILES = {
    "folder": "is a folder", "/dev/zero": "is not an ordinary file", "fifo": "not an ordinary file",
    "huge": "bytes; a", "binary": "byte 6 is not UTF-8", "latin": "byte 11 is not UTF-8",
    "wide": "UTF-16", "missing.yaml": "no such file",
}  # fmt: skip


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: f"{reader[0]}-{len(reader)}")
@pytest.mark.parametrize("name", NO_FILES)
def test_what_is_no_file_of_text_is_refused_by_every_verb(
    reader: tuple[str, ...], name: str, folder: Path, tmp_path: Path
) -> None:
    """Folders, devices, pipes, huge and binary files: exit code 2, the file's name, at once."""
    given = str(folder / name)
    command = [given if part == "{}" else part for part in reader]
    command = [str(folder / part) if part == "plan.json" else part for part in command]
    command = [str(tmp_path / part) if part.startswith("o") else part for part in command]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 2, result.stderr
    assert given in result.stderr
    assert NO_FILES[name] in result.stderr
    assert list(tmp_path.iterdir()) == []


WRONG_KIND = {
    "plan.json": ("is a plan, not a", "gm-ompl check"),
    "scenario.json": ("is a scenario, not a", "gm-ompl plan FILE"),
    "scenario.yaml": ("is a scenario, not a", "gm-ompl plan FILE"),
    "trace.jsonl": ("is a trace, not a", "--show search"),
}


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: f"{reader[0]}-{len(reader)}")
@pytest.mark.parametrize("name", WRONG_KIND)
def test_a_file_of_another_kind_says_what_it_is(
    reader: tuple[str, ...], name: str, folder: Path, tmp_path: Path
) -> None:
    """A plan given as a scenario, a scenario as parameters, ...: its kind, and what takes it."""
    wanted = "trace" if "--trace" in reader else "scenario"
    wanted = "plan" if reader[0] in ("check", "view", "export", "execute") else wanted
    wanted = "plan" if reader[:2] == ("plot", "{}") else wanted
    if "--params" not in reader and name.startswith(wanted):
        return  # that is its kind
    command = [str(folder / name) if part == "{}" else part for part in reader]
    command = [str(folder / part) if part == "plan.json" else part for part in command]
    command = [str(tmp_path / part) if part.startswith("o") else part for part in command]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 2, result.stderr
    for words in WRONG_KIND[name]:
        assert words in result.stderr


def test_the_kind_is_told_wherever_the_key_stands(folder: Path, tmp_path: Path) -> None:
    """``format`` need not be the first key."""
    plan = json.loads((folder / "plan.json").read_text())
    plan["format"] = plan.pop("format")
    file = tmp_path / "turned.json"
    file.write_text(json.dumps(plan))
    result = CliRunner().invoke(app, ["plan", str(file)])
    assert (result.exit_code, "is a plan, not a scenario" in result.stderr) == (2, True)
    assert CliRunner().invoke(app, ["check", str(file)]).exit_code == 0


def test_a_shipped_name_is_no_plan() -> None:
    """``check paper/slide`` says how a plan of it is made."""
    result = CliRunner().invoke(app, ["check", "paper/slide"])
    assert result.exit_code == 2
    assert "gm-ompl plan paper/slide -o PLAN.json" in result.stderr


def test_a_byte_order_mark_is_fine(folder: Path, tmp_path: Path) -> None:
    """Some editors write one, in front of a plan, too."""
    file = tmp_path / "marked.json"
    file.write_bytes(b"\xef\xbb\xbf" + (folder / "plan.json").read_bytes())
    assert CliRunner().invoke(app, ["check", str(file)]).exit_code == 0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"format": "gm-ompl-plan/2", "a": %s}' % ("[" * 900 + "]" * 900), "nested too deeply"),
        ('{"format": "gm-ompl-plan/2", "seed": %s}' % ("9" * 5000), "too long a number"),
        ('{"format": "gm-ompl-plan/2", "planner": "\\ud800"}', "half of a surrogate pair"),
        ('{"format": "gm-ompl-plan/2", "\\ud800": 1}', "half of a surrogate pair"),
        ('{"format": "gm-ompl-plan/7"}', '"gm-ompl-plan/2"'),
        ('{"format": "gm-ompl-plan/2", "steps": [%s1]}' % ("1, " * 90_000), "more mistakes"),
    ],
    ids=("deep", "long number", "half a value", "half a key", "version", "many mistakes"),
)
def test_hostile_plans_are_refused(text: str, words: str, tmp_path: Path) -> None:
    """Exit code 2 and a few lines, whatever stands in the file."""
    file = tmp_path / "plan.json"
    file.write_text(text)
    for verb in (["check", str(file)], ["view", str(file), "--html", str(tmp_path / "x.html")]):
        result = CliRunner().invoke(app, verb)
        assert result.exit_code == 2
        assert words in result.stderr
        assert len(result.stderr.splitlines()) <= plan_files.MAX_SHOWN + 1


def test_a_scenario_of_very_many_mistakes_is_refused_in_few_lines(tmp_path: Path) -> None:
    """No terminal is flooded."""
    file = tmp_path / "keys.yaml"
    file.write_text("".join(f"key{k}: 1\n" for k in range(500)))
    result = CliRunner().invoke(app, ["plan", str(file)])
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) < 50
    assert "more mistakes" in result.stderr


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="has no /dev/zero")
def test_an_endless_file_takes_no_memory() -> None:
    """``check /dev/zero`` ends at once, within 2 GB of address space."""
    limited = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31));"
        "from gm_ompl.reading import Kind, read_text; from pathlib import Path;"
        "from gm_ompl.errors import InputError\n"
        "try: read_text(Path('/dev/zero'), Kind('plan', 'JSON', 2**25))\n"
        "except InputError: sys.exit(2)"
    )
    assert subprocess.run([sys.executable, "-P", "-c", limited], timeout=60).returncode == 2


def test_a_file_that_hides_its_size_is_read_up_to_the_limit() -> None:
    """Files in /proc say 0 bytes; a file may grow meanwhile."""
    hidden = Path("/proc/self/maps")
    if not hidden.exists():
        pytest.skip("has no /proc")
    with pytest.raises(gm_ompl.errors.InputError, match="at most 100 bytes"):
        reading.read_text(hidden, reading.Kind("plan", "JSON", 100))
