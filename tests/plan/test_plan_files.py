"""Plan files: written whole, read strictly, mistakes named by file, line and key."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gm_ompl.errors import PlanError
from gm_ompl.planfile import files as plan_files
from gm_ompl.planfile.files import dumps, key_path, locate
from gm_ompl.planfile.model import Plan, SegmentRecord, Statistics

Tamper = Callable[[dict[str, Any]], object]


def test_saving_and_loading_is_the_identity(plan: Plan, tmp_path: Path) -> None:
    """A plan saved and loaded is the same plan, to the last bit of every number."""
    file = tmp_path / "plan.json"
    plan.save(file)
    again = Plan.load(str(file))
    assert again == plan
    assert json.dumps(again.to_dict()) == json.dumps(plan.to_dict())


def test_the_file_has_the_documented_keys(document: dict[str, Any], plan: Plan) -> None:
    """What is written holds exactly the keys and values of the format."""
    assert plan.to_dict() == {**document, "hand": None}


@settings(max_examples=50, deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_survive(z: float) -> None:
    """Every finite number comes back from a file's text as it went in."""
    text = json.dumps(SegmentRecord(modes=(), f_com=(), z=z).model_dump(mode="json"))
    assert SegmentRecord.model_validate_json(text).z == z


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=30),
    lambda inner: st.lists(inner, max_size=8) | st.dictionaries(st.text(max_size=9), inner),
    max_leaves=40,
).filter(lambda value: "Infinity" not in json.dumps(value))


@settings(max_examples=100, deadline=None)
@given(json_values)
def test_layout_keeps_the_content(value: Any) -> None:
    """The file's layout (short lists on one line) is still the same JSON."""
    assert json.loads(dumps(value)) == value


def test_plans_are_frozen(plan: Plan) -> None:
    """A plan's values cannot be replaced."""
    with pytest.raises(ValueError, match="frozen"):
        plan.cost = 1.0


def test_a_plan_keeps_its_own_scenario(document: dict[str, Any]) -> None:
    """Changing the scenario that a plan was made from does not change the plan."""
    scenario = {"fingers": {"radius": [1.0]}}
    plan = Plan.model_validate_json(json.dumps(document)).model_dump(by_alias=True)
    made = Plan.model_validate({**plan, "scenario": scenario})
    scenario["fingers"]["radius"].append(2.0)
    assert made.scenario == {"fingers": {"radius": [1.0]}}


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_no_nan_can_be_made(number: float) -> None:
    """Neither NaN nor Infinity gets into a plan's values, extra statistics included."""
    with pytest.raises(ValueError, match="finite"):
        SegmentRecord(modes=(), f_com=(), z=number)
    with pytest.raises(ValueError, match=r"finite|JSON compliant"):
        Statistics.model_validate(
            {"time_s": 0, "expanded": 0, "mode_decisions": 0, "history": (), "extra": number}
        )


MISTAKES: list[tuple[Tamper, str, tuple[str, ...]]] = [
    (lambda d: d.pop("seed"), "seed", ("missing",)),
    (lambda d: d.update(format="gm-ompl-plan/3"), "format", ("gm-ompl-plan/2",)),
    (lambda d: d.pop("format"), "format", ("gm-ompl-plan/2",)),
    (
        lambda d: d.update(format="gm-ompl-plan/1"),
        "format",
        ("gm-ompl-plan/1", "older format", "gm-ompl-plan/2", "plan again"),
    ),
    (lambda d: d["steps"][0].pop("arc"), "steps[0].arc", ("missing",)),
    (lambda d: d["steps"][0].update(arc={"slide": [1, 0, 0]}), "steps[0].arc", ("translation",)),
    (lambda d: d["steps"][0].update(arc=[1, 0, 0]), "steps[0].arc", ("straight",)),
    (
        lambda d: d["steps"][0].update(arc={"translation": [1, 0]}),
        "steps[0].arc.translation",
        (),
    ),
    (
        lambda d: d["steps"][0]["arc"].update(angle=1.0),
        "steps[0].arc.angle",
        ("unknown key",),
    ),
    (
        lambda d: d["steps"][0].update(
            arc={"rotation": {"point": [0, 0, 0], "axis": [0, 0, 0], "angle": 1.0}}
        ),
        "steps[0].arc.rotation.axis",
        ("zeros",),
    ),
    (
        lambda d: d["steps"][0]["pose_to"].update(quaternion=[0, 0, 0, 0]),
        "steps[0].pose_to.quaternion",
        ("zeros",),
    ),
    (lambda d: d["steps"][1].pop("way"), "steps[1].way", ("missing",)),
    (lambda d: d.update(status="done"), "status", ('"done"', "'solved'", "'infeasible'")),
    (lambda d: d.update(optimal=1), "optimal", ("true or false",)),
    (lambda d: d.update(cost="101.5"), "cost", ('"101.5"', "a number")),
    (lambda d: d.update(cost=True), "cost", ("a number",)),
    (lambda d: d.update(regrasps=1.0), "regrasps", ("whole number",)),
    (lambda d: d.update(regrasps=-1), "regrasps", ("at least 0",)),
    (lambda d: d.update(extra=1), "extra", ("unknown key", "remove")),
    (lambda d: d.update(sede=d.pop("seed")), "sede", ("did you mean 'seed'?",)),
    (lambda d: d.update(scenario=[]), "scenario", ("an object",)),
    (lambda d: d.update(steps={}), "steps", ("a list",)),
    (lambda d: d["steps"].append(3), "steps[2]", ("an object",)),
    (lambda d: d["steps"][0].pop("kind"), "steps[0]", ("kind", "'regrasp'")),
    (lambda d: d["steps"][0].update(kind="hop"), "steps[0]", ("hop", "'displacement'")),
    (lambda d: d["steps"][0].pop("from"), "steps[0].from", ("missing",)),
    (lambda d: d["steps"][0].update(from_=d["steps"][0].pop("from")), "steps[0].from_", ("unkn",)),
    (lambda d: d["steps"][0].update(to=[]), "steps[0].to", ("at least 1",)),
    (lambda d: d["steps"][0]["pose_to"].update(position=[0, 1]), "steps[0].pose_to.position", ()),
    (lambda d: d["steps"][0]["segments"][1].pop("z"), "steps[0].segments[1].z", ("missing",)),
    (lambda d: d["steps"][0]["segments"][0].pop("f_com"), "steps[0].segments[0].f_com", ()),
    (lambda d: d["steps"][0]["segments"][0].update(y=1), "steps[0].segments[0].y", ("unknown",)),
    (
        lambda d: d["steps"][0]["segments"][0].update(modes=["position", "pos"]),
        "steps[0].segments[0].modes[1]",
        ('"pos"', "'position' or 'force'"),
    ),
    (lambda d: d["steps"][1].update(finger=-1), "steps[1].finger", ("at least 0",)),
    (lambda d: d["steps"][1]["to"].update(face=3), "steps[1].to.face", ("3", "a string")),
    (lambda d: d["steps"][1]["to"].update(cell=[1, 2.5]), "steps[1].to.cell[1]", ("2.5",)),
    (lambda d: d["statistics"].pop("history"), "statistics.history", ("missing",)),
    (lambda d: d["steps"][0].update(cost=float("nan")), "steps[0].cost", ("finite",)),
    (lambda d: d["scenario"].update(x=float("inf")), "scenario.x", ("finite",)),
]


@pytest.mark.parametrize(("tamper", "key", "words"), MISTAKES)
def test_mistakes_are_named(
    document: dict[str, Any], tmp_path: Path, tamper: Tamper, key: str, words: tuple[str, ...]
) -> None:
    """A file that is no plan is refused with file, line, key, value and remedy."""
    tamper(document)
    file = tmp_path / "broken.json"
    file.write_text(json.dumps(document, indent=1), encoding="utf-8")
    with pytest.raises(PlanError) as caught:
        Plan.load(file)
    message = str(caught.value)
    assert message.startswith(f"{file}:")
    assert f": {key}" in message
    for word in words:
        assert word in message, message


def test_the_line_is_the_value_s_line(document: dict[str, Any], tmp_path: Path) -> None:
    """The line in a message is where the wrong value stands."""
    document["steps"][1]["z"] = "high"
    file = tmp_path / "broken.json"
    file.write_text(json.dumps(document, indent=1), encoding="utf-8")
    lines = file.read_text(encoding="utf-8").splitlines()
    want = next(number for number, line in enumerate(lines, 1) if '"z": "high"' in line)
    with pytest.raises(PlanError, match=rf":{want}: steps\[1\]\.z: "):
        Plan.load(file)


def test_every_mistake_is_named_at_once(document: dict[str, Any], tmp_path: Path) -> None:
    """Several mistakes give several lines, and a long list is cut."""
    document.update(status="done", cost="1")
    file = tmp_path / "broken.json"
    file.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(PlanError) as caught:
        Plan.load(file)
    assert len(str(caught.value).splitlines()) == 2
    document["steps"] = [3] * 500
    file.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(PlanError, match="and 482 more mistakes"):
        Plan.load(file)


NOT_PLANS = {
    "empty": (b"", "empty"),
    "cut off": (b'{"format": "gm-ompl-plan/2", ', ":1:30: not valid JSON"),
    "a list": (b"[]", "one JSON object"),
    "other JSON": (b'{"a": 1}', "format"),
    "binary": (b"\x89PNG\xff\x00", "is not UTF-8 text"),
    "key twice": (b'{"format": "gm-ompl-plan/2", "a": 1, "a": 2}', "twice"),
    "deep": (b"[" * 200_000, "nested too deeply"),
    "long number": (b'{"seed": ' + b"9" * 10_000 + b"}", "too long a number"),
    "infinite": (b'{"format": "gm-ompl-plan/2", "cost": 1e999}', "cost: inf: must be a finite"),
}


@pytest.mark.parametrize("name", NOT_PLANS)
def test_what_is_no_plan_is_refused(tmp_path: Path, name: str) -> None:
    """Files that are not even JSON objects of this format end with a plain message."""
    content, word = NOT_PLANS[name]
    file = tmp_path / "other.json"
    file.write_bytes(content)
    with pytest.raises(PlanError, match=word):
        Plan.load(file)


def test_unreadable_paths_are_refused(tmp_path: Path) -> None:
    """A path that is missing, or a folder, is a PlanError."""
    for path, words in ((tmp_path / "missing.json", "no such file"), (tmp_path, "is a folder")):
        with pytest.raises(PlanError, match=words):
            Plan.load(path)


def test_a_huge_file_is_not_read(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file above the limit is refused before its content is read."""
    file = tmp_path / "plan.json"
    plan.save(file)
    monkeypatch.setattr(plan_files, "KIND", dataclasses.replace(plan_files.KIND, most=100))
    with pytest.raises(PlanError, match="at most 100 bytes"):
        Plan.load(file)


def test_saving_is_whole_or_not_at_all(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where writing fails, the old file stays and nothing else is left behind."""
    file = tmp_path / "plan.json"
    file.write_text("old", encoding="utf-8")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(PlanError, match="No space left on device"):
        plan.save(file)
    assert file.read_text(encoding="utf-8") == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["plan.json"]


def test_saving_where_there_is_no_folder(plan: Plan, tmp_path: Path) -> None:
    """A folder that does not exist is a PlanError."""
    with pytest.raises(PlanError, match="cannot write"):
        plan.save(tmp_path / "nowhere" / "plan.json")


def test_the_shipped_schema_is_current() -> None:
    """``plan.schema.json`` is what the types say: what ``Plan.schema_of_files()`` returns."""
    text = (files("gm_ompl.planfile") / "plan.schema.json").read_text(encoding="utf-8")
    assert json.loads(text) == Plan.schema_of_files()


def test_the_schema_requires_every_key() -> None:
    """The schema requires every top-level key but a hand's, which came later; no others."""
    schema = Plan.schema_of_files()
    assert {*schema["required"], "hand"} == set(schema["properties"]) == set(Plan.model_fields)
    assert schema["additionalProperties"] is False


def test_locate_finds_values() -> None:
    """``locate`` points at the value, whatever the spacing."""
    text = '{ "a" : [1, {"b\\"": [ ], "c":"x"} ] ,"d":{} }'
    assert text[locate(text, ("a", 1, "c")) :].startswith('"x"')
    assert text[locate(text, ("d",)) :].startswith("{} }")
    assert text[locate(text, ("a", 7)) :].startswith("[1,")
    assert key_path(("a", 1, "c")) == "a[1].c"
