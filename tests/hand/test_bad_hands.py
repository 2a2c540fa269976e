"""Hands that cannot be used: each ends with one clear message and a remedy."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gm_ompl.errors import ScenarioError
from gm_ompl.scenario.document import dump
from gm_ompl.scenario.load import load

Tree = dict[str, Any]

LINK = (
    '<link name="{0}"><inertial><mass value="{1}"/><inertia ixx="{2}" ixy="0" ixz="0" '
    'iyy="{2}" iyz="0" izz="{2}"/></inertial>{3}</link>'
)
JOINT = (
    '<joint name="{0}" type="{1}"><parent link="base"/><child link="tip"/>'
    '<origin xyz="0 0 0.2"/><axis xyz="0 1 0"/>{2}</joint>'
)
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def urdf(
    kind: str = "revolute", limit: str = LIMIT, mass: float = 0.1, inertia: float = 1e-4,
    shape: str = "", joint: bool = True,
) -> str:  # fmt: skip
    """A finger of one hinge."""
    links = LINK.format("base", 1, 1e-3, "") + LINK.format("tip", mass, inertia, shape)
    made = JOINT.format("hinge", kind, limit) if joint else JOINT.format("hinge", "fixed", "")
    return f'<?xml version="1.0"?><robot name="finger">{links}{made}</robot>'


OWN = {
    "file": "hand.urdf",
    "tips": [{"link": "tip"}],
    "home": {"hinge": "0 deg"},
    "torque": 1,
    "speed": 1,
}
MESH = '<collision><geometry><mesh filename="{0}"/></geometry></collision>'


def own(text: str, **more: Any) -> Callable[[Tree, Path], None]:
    """A hand of one's own: its file's text, and keys beside it (None takes one away)."""

    def change(tree: Tree, folder: Path) -> None:
        (folder / "hand.urdf").write_text(text, encoding="utf-8")
        hand = {**OWN, **more}
        tree["hand"] = {key: value for key, value in hand.items() if value is not None}
        tree["fingers"]["count"] = 1

    return change


def keys(**more: Any) -> Callable[[Tree, Path], None]:
    """The TriFinger with keys beside it."""
    return lambda tree, _: tree["hand"].update(more)


def only(**hand: Any) -> Callable[[Tree, Path], None]:
    """Another hand altogether."""
    return lambda tree, _: tree.update(hand=hand)


def wall(tree: Tree, _: Path) -> None:
    box = {"min": [-0.3, 0.05, 0.1], "max": [0.3, 0.3, 0.4]}
    tree["environment"] = {"obstacles": {"wall": {"box": box}}}


def behind(tree: Tree, _: Path) -> None:
    tree["fingers"]["start"] = ["any", {"face": "-x", "cell": [0, 0]}, "any"]


def far(tree: Tree, _: Path) -> None:
    tree["hand"]["base"] = {"position": [1, 0, 0]}


def count(tree: Tree, _: Path) -> None:
    tree["fingers"]["count"] = 2


TIPS = [{"link": f"finger_tip_link_{angle}"} for angle in (0, 120, 240)]
JOINTS = "finger_base_to_upper_joint_0"
STRAIGHT = ("finger_upper_to_middle_joint_0", "finger_middle_to_lower_joint_0")

BAD: dict[str, tuple[Callable[[Tree, Path], None], str, str]] = {
    "no hand of that name": (only(model="trifingr"), "hand.model", "did you mean 'trifinger'"),
    "neither model nor file": (only(), "hand", "must have model"),
    "both": (keys(file="hand.urdf"), "hand", "not both"),
    "unknown key": (keys(torqe=1), "hand.torqe", "did you mean 'torque'"),
    "model no text": (only(model=3), "hand.model", "must be text"),
    "file not there": (only(file="nowhere.urdf"), "hand.file", "no such file"),
    "file of nobody": (only(file="~nobody-of-that-name/a.urdf"), "hand.file", "no such file"),
    "file no XML": (own("no XML"), "hand.file", "must be a URDF or MJCF"),
    "file empty": (own(""), "hand.file", "must be a URDF or MJCF"),
    "another XML": (own("<svg/>"), "hand.file", "must be a URDF (<robot>)"),
    "mesh missing": (own(urdf(shape=MESH.format("tip.stl"))), "hand.file", "tip.stl is not there"),
    "package missing": (
        own(urdf(shape=MESH.format("package://no_hand/tip.stl"))), "hand.file", "hand.packages",
    ),
    "package's folder wrong": (
        own(urdf(shape=MESH.format("package://no_hand/tip.stl")), packages={"no_hand": "here"}),
        "hand.file", "is not there",
    ),
    "negative inertia": (own(urdf(inertia=-1.0)), "hand.file", "MuJoCo cannot use it"),
    "no mass": (own(urdf(mass=0.0, inertia=0.0)), "hand.file", "MuJoCo cannot use it"),
    "no joint moves": (own(urdf(joint=False)), "hand.file", "needs hinges"),
    "a slide": (own(urdf("prismatic")), "hand.file", "only hinges"),
    "no limits": (own(urdf("continuous", "")), "hand.limits", "add hinge: [-90 deg, 90 deg]"),
    "no tips": (own(urdf(), tips=None), "hand.tips", "add it"),
    "tips empty": (own(urdf(), tips=[]), "hand.tips", "at least 1"),
    "unknown link": (own(urdf(), tips=[{"link": "tp"}]), "hand.tips.0.link", "did you mean 'tip'"),
    "offset too short": (
        own(urdf(), tips=[{"link": "tip", "offset": [0, 0]}]), "hand.tips.0.offset", "at least 3",
    ),
    "one link twice": (keys(tips=[TIPS[0], TIPS[1], TIPS[1]]), "hand.tips.2.link", "given twice"),
    "too few tips": (keys(tips=TIPS[:2]), "hand.tips", "fingers.count is 3"),
    "too few fingers": (count, "hand.model", "must be the same"),
    "no home": (own(urdf(), home=None), "hand.home", "add hinge: 0 deg"),
    "home of an unknown joint": (
        keys(home={JOINTS[:-1] + "1": "0 deg"}), "hand.home", "did you mean",
    ),
    "home without a unit": (keys(home={JOINTS: 0.1}), "hand.home", "with its unit"),
    "home beyond its limits": (keys(home={JOINTS: "90 deg"}), "hand.home", "outside its limits"),
    "home in the floor": (
        keys(home=dict.fromkeys(STRAIGHT, "0 deg")),
        "hand.home", "move the base or the home",
    ),
    "limits wider": (keys(limits={JOINTS: ["-90 deg", "90 deg"]}), "hand.limits", "narrower"),
    "limits turned round": (keys(limits={JOINTS: ["1 rad", "0 rad"]}), "hand.limits", "increasing"),
    "limits of an unknown joint": (
        keys(limits={"thumb": ["0 rad", "1 rad"]}), "hand.limits.thumb", "no such joint",
    ),
    "no torque": (own(urdf(), torque=None), "hand.torque", "add it"),
    "torque 0": (keys(torque=0), "hand.torque", "must be > 0"),
    "torques too few": (keys(torque=[1, 1]), "hand.torque", "has 9 joints"),
    "no speed": (own(urdf(), speed=None), "hand.speed", "add it"),
    "base in the wall": (wall, "hand", "move the base"),
    "base far away": (far, "hand.base", "does not reach any placement at the start"),
    "base without a rotation": (keys(base={"rotation": {}}), "hand.base.rotation", "must be one"),
    "unreachable start": (behind, "fingers.start.1", "does not reach its placement"),
}  # fmt: skip


@pytest.mark.parametrize("kind", BAD)
def test_bad_hands_are_refused(kind: str, tree: Tree, tmp_path: Path) -> None:
    """One line with file, line and key, and what would be right."""
    change, key, remedy = BAD[kind]
    change(tree, tmp_path)
    file = tmp_path / "bad.yaml"
    file.write_text(dump(tree), encoding="utf-8")
    with pytest.raises(ScenarioError) as caught:
        load(str(file))
    lines = [line for line in caught.value.problems if key in line and remedy in line]
    assert lines, caught.value.problems
    assert lines[0].startswith(f"{file}:")
