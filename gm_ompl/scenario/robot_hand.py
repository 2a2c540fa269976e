"""From the key ``hand`` to a ``HandSpec`` that fits the scenario."""

from __future__ import annotations

import os
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np

from gm_ompl.errors import HandError
from gm_ompl.geometry.pose import Pose
from gm_ompl.hand.spec import HandSpec, Tip
from gm_ompl.problem import Problem
from gm_ompl.scenario.hand_model import RobotModel
from gm_ompl.scenario.messages import Notes
from gm_ompl.scenario.model import ScenarioModel
from gm_ompl.scenario.motions import turned

if TYPE_CHECKING:
    from gm_ompl.hand.model import HandModel


def with_found_files(model: ScenarioModel, notes: Notes) -> ScenarioModel:
    """Return ``model`` with the hand's file, and all that it needs, inside: plans lie anywhere."""
    hand, folder = model.hand, notes.document.folder
    if hand is None or hand.file is None or hand.files or folder is None:
        return model
    from gm_ompl.hand.packing import packed

    def found(name: str) -> FilePath:
        # Not Path.expanduser: it raises where a name stands for nobody's home.
        return (folder / os.path.expanduser(name)).absolute()

    path, packages = found(hand.file), {name: found(at) for name, at in hand.packages.items()}
    try:
        files = packed(path, packages)
        change: dict[str, object] = {"file": next(iter(files)), "files": files, "packages": {}}
    except HandError:  # whoever makes the hand finds it again, and says so
        packages_there = {name: str(at) for name, at in packages.items()}
        change = {"file": str(path), "packages": packages_there}
    return model.model_copy(update={"hand": hand.model_copy(update=change)})


def make_hand(hand: RobotModel | None, fingers: int, notes: Notes) -> HandSpec | None:
    """Return the hand, or None where there is none or after noting what is wrong with it."""
    if hand is None:
        return None
    from gm_ompl.hand.build import Wanted, hand_spec  # few scenarios have a robot's hand
    from gm_ompl.hand.packing import unpacked

    tips = None
    if hand.tips is not None:
        tips = tuple(Tip(tip.link, np.array(tip.offset)) for tip in hand.tips)
    try:
        folder = unpacked(hand.files) if hand.files else FilePath()
    except HandError as error:
        notes.add(("hand", *error.key), str(error))
        return None
    wanted = Wanted(
        model=hand.model,
        file=None if hand.file is None else folder / hand.file,
        packages={name: FilePath(where) for name, where in hand.packages.items()},
        tips=tips,
        base=Pose(turned(hand.base.rotation, 0.0), np.array(hand.base.position)),
        home=hand.home,
        limits={name: (low, high) for name, (low, high) in hand.limits.items()},
        torque=hand.torque,
        speed=hand.speed,
    )
    try:
        return hand_spec(wanted, fingers)
    except HandError as error:
        notes.add(("hand", *error.key), str(error))
        return None


def check_hand(problem: Problem, notes: Notes) -> None:
    """Note where the hand stands in something, or cannot begin."""
    hand = problem.hand
    if hand is None:
        return
    from gm_ompl.hand.model import HandModel

    environment, start = problem.environment, problem.motion.pose(problem.start)
    bodies = [obstacle.body for obstacle in environment.obstacles]
    model = HandModel(hand, problem.body, bodies, environment.floor)
    model.place(hand.home, start)
    fixed = model.fixed_hit()
    if fixed is not None:
        notes.add(("hand", "base"), f"there {fixed[0]} stands in {fixed[1]}; move the base")
        return
    hit = model.hit(np.zeros(problem.fingers.count))
    if hit is not None:
        deep = f"{1000 * hit.depth:.3g} mm deep"
        text = f"there {hit.names[0]} is in {hit.names[1]}, {deep}; move the base or the home"
        notes.add(("hand", "home"), text)
        return
    _check_start(problem, model, start, notes)


def _check_start(problem: Problem, model: HandModel, start: Pose, notes: Notes) -> None:
    """Note a finger that reaches no placement at the start, or not the one it is given."""
    from gm_ompl.hand.reach import HandReach

    fingers = problem.fingers
    centres = [fingers.placements.centres(r) for r in fingers.radius.tolist()]
    reach = HandReach(model, centres, fingers.radius, problem.body.diagonal)
    for i, given in enumerate(fingers.start):
        rows = range(len(fingers.placements)) if given is None else (given,)
        if all(reach.configuration(start, i, row) is None for row in rows):
            where = "any placement" if given is None else "its placement"
            text = f"finger {i} does not reach {where} at the start; move the base or the object"
            notes.add(("hand", "base") if given is None else ("fingers", "start", i), text)
