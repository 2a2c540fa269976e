"""Names and files: shipped scenarios, random ones, and files that are none."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from gm_ompl.errors import ScenarioError
from gm_ompl.scenario.load import MAX_BYTES, load, random_names, read, shipped
from gm_ompl.scenario.model import ExpectModel


def test_the_papers_scenarios_ship() -> None:
    """The paper's five are there; each scenario has source, description and what to expect.

    Of free motion exact search may not end; then nothing is expected.
    """
    assert {f"paper/{n}" for n in ("slide", "push", "tumble", "regrasp", "cork")} <= set(shipped())
    for name in shipped():
        scenario = load(name)
        assert scenario.name == name
        assert scenario.model.source
        assert scenario.model.description
        unknown = scenario.model.expect == ExpectModel() and not scenario.problem.motion.dimension
        assert unknown or scenario.model.expect.status is not None
        assert unknown or scenario.model.expect.regrasps is not None


@pytest.mark.parametrize(
    ("name", "size", "goal", "limit"),
    [
        ("slide", [5, 10, 5], [15, 0, 2.5], 10),
        ("push", [5, 10, 5], [15, 0, 2.5], 5),
        ("tumble", [5, 5, 10], [7.5, 0, 2.5], 10),
        ("regrasp", [5, 5, 10], [7.5, 0, 2.5], 10),
    ],
)
def test_the_papers_numbers(name: str, size: list[float], goal: list[float], limit: float) -> None:
    """Sec. 5: mass 1, radius 1, g 9.8, frictions 0.5 and 0.7, s 6, z_min 0.5, 30 segments, ..."""
    problem = load(f"paper/{name}").problem
    assert (problem.body.vertices.max(axis=0) * 2).tolist() == size
    assert problem.motion.pose([1.0]).position == pytest.approx(goal)
    assert problem.fingers.max_normal_force.tolist() == [limit, limit]
    assert problem.fingers.radius.tolist() == [1, 1]
    assert problem.fingers.friction.tolist() == [0.7, 0.7]
    assert (problem.mass, problem.environment.friction) == (1, 0.5)
    settings = problem.mechanics
    assert (settings.gravity, settings.cone_edges, settings.z_min) == (9.8, 6, 0.5)
    assert (problem.cost.regrasp, problem.cost.stability) == (100, 0.01)
    assert problem.cost.samples_per_arc == 3
    assert problem.fingers.groups() == ((0, 1),)
    pairs = len(problem.fingers.placements) * (len(problem.fingers.placements) - 1) // 2
    assert pairs * problem.lattice.size == 1_335_201  # the paper's own count


def test_missing_names_suggest() -> None:
    """A misspelt shipped name, family or file name suggests the right one."""
    for name, hint in (
        ("paper/slid", "did you mean 'paper/slide'?"),
        ("paper/slid.yaml", "did you mean 'paper/slide'?"),
        ("random/tumbel/3", "did you mean 'tumble'?"),
        ("random/tumble/x", "for example random/tumble/17"),
        ("random/tumble/-1", "for example random/tumble/17"),
        ("random/tumble", "for example random/tumble/17"),
        ("random/tumble/" + "9" * 30, "for example random/tumble/17"),
        ("qqqqqqqq", "shipped: fingers/three, free/around"),
        ("no\0name", "no such scenario or file"),
    ):
        with pytest.raises(ScenarioError) as caught:
            load(name)
        assert hint in str(caught.value)
        assert str(caught.value).isprintable()


def test_a_file_wins_where_it_is_named_as_one(tmp_path: Path, texts: dict[str, str]) -> None:
    """Paths, names with a YAML or JSON ending, and names of existing files are read as files."""
    for file_name in ("a.yaml", "b.yml", "c.json", "plain"):
        file = tmp_path / file_name
        file.write_text(texts["path"], encoding="utf-8")
        assert load(str(file)).name == "test/tumble"
        assert load(file).name == "test/tumble"


def test_a_byte_order_mark_is_fine(tmp_path: Path, texts: dict[str, str]) -> None:
    """Some editors write one."""
    file = tmp_path / "bom.yaml"
    file.write_bytes(b"\xef\xbb\xbf" + texts["path"].encode())
    assert load(file).name == "test/tumble"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (b"# only a comment\n", "the file is empty"),
        (b"[1, 2]", "expected a mapping"),
        (b"just words", "expected a mapping"),
        (b"\x7fELF\x02\x01\xff\xfe", "not UTF-8 text"),
        (b"a: \x00", "not valid YAML text"),
        (b"a: 1\n---\nb: 2\n", "another document"),
        (b"%YAML 9.9\n---\na: 1", "not valid YAML"),
    ],
)
def test_files_that_are_no_scenario(tmp_path: Path, content: bytes, message: str) -> None:
    """Empty, binary and other YAML files are refused with their name."""
    file = tmp_path / "thing.yaml"
    file.write_bytes(content)
    with pytest.raises(ScenarioError, match=message) as caught:
        load(file)
    assert str(caught.value).startswith(str(file))


def test_folders_devices_missing_and_huge_files(tmp_path: Path) -> None:
    """None of them is read."""
    fifo, huge = tmp_path / "fifo.yaml", tmp_path / "huge.yaml"
    os.mkfifo(fifo)
    with huge.open("wb") as stream:
        stream.truncate(MAX_BYTES + 1)
    for path, message in (
        (tmp_path, "is a folder"),
        (fifo, "not an ordinary file"),
        (huge, "at most 8 MiB"),
        (tmp_path / "none.yaml", "no such file"),
        (huge / "below.yaml", "cannot be read|no such file"),
        (tmp_path / ("x" * 5000 + ".yaml"), "cannot be read"),
    ):
        with pytest.raises(ScenarioError, match=message):
            load(path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_unreadable_files(tmp_path: Path, texts: dict[str, str]) -> None:
    """A file without read permission is refused with the system's reason."""
    file = tmp_path / "secret.yaml"
    file.write_text(texts["path"], encoding="utf-8")
    file.chmod(0)
    with pytest.raises(ScenarioError, match="cannot be read"):
        load(file)


def test_listing_needs_no_validation() -> None:
    """Reading every shipped text gives its name and description without building shapes."""
    for name in shipped():
        tree = read(name).tree
        assert isinstance(tree, dict)
        assert tree["name"] == name
    assert "random/small/SEED" in random_names()
