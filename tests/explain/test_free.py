"""Free motion explained: what is said must be what the lattice, the judge and the planner find."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

import gm_ompl
from gm_ompl.app.explaining import lines
from gm_ompl.app.main import app
from gm_ompl.diagnosis.values import Explanation
from gm_ompl.errors import InputError
from gm_ompl.motion.free import FreeMotion
from gm_ompl.planfile.words import chain
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load

ROLL = "random/free/2"
"""A box is rolled over twice: 50 poses."""


def missed() -> gm_ompl.Scenario:
    """The same with a goal that no pose of the lattice meets."""
    tree = load(ROLL).resolved()
    tree["motion"]["goal"] = {
        "position": [10.1, 0.0, tree["motion"]["start"]["position"][2]],
        "rotation": tree["motion"]["goal"]["rotation"],
    }
    return load({**tree, "expect": {}})


@pytest.fixture(scope="module")
def of_missed() -> Explanation:
    return gm_ompl.explain(missed(), samples=3, time_limit=20)


def everything(problem: Problem) -> dict[int, list[int]]:
    """All nodes, each with the heads of its arcs, breadth first."""
    graph = problem.object_graph
    found, queue = dict[int, list[int]](), [graph.start]
    while queue:
        node = queue.pop()
        if node not in found:
            found[node] = [arc.head for arc in graph.arcs_from(node)]
            queue += found[node]
    return found


def test_all_that_is_in_reach_is_seen(of_missed: Explanation) -> None:
    """Poses, arcs and the nearest to the goal are those of the whole lattice; deeds add up."""
    problem = missed().problem
    every = everything(problem)
    alone = of_missed.explored[0]
    assert alone.whole and not alone.arrived and not alone.fingers
    assert alone.nodes == len(every) == sum(alone.contacts.values())
    assert alone.arcs == sum(map(len, every.values())) == sum(d.arcs for d in alone.deeds)
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    poses = [problem.object_graph.pose(node) for node in every]
    turned = [pose for pose in poses if motion.goal.rotation_error(pose) < 1e-6]
    least = min(map(motion.goal.position_error, turned))
    assert alone.nearest.distance == pytest.approx(least, rel=1e-9)
    assert {line.deed for line in alone.deeds} == {"slides along x", "tumbles about y"}


def test_a_goal_that_is_missed_is_told_from_one_that_is_out_of_hand(of_missed: Explanation) -> None:
    """All of the lattice was seen: no force is tried; a wider goal is, and has a plan."""
    assert "nowhere on the lattice is the object in the goal" in of_missed.verdict
    (within,) = [r for r in of_missed.remedies if r.change.startswith("motion.goal.within")]
    assert within.helps
    tree = missed().resolved()
    tree["motion"]["goal"].pop("within")
    assert gm_ompl.plan(load(tree, [within.change])).status == "solved"
    assert not any("friction" in r.change or "force" in r.change for r in of_missed.remedies)
    json.dumps(of_missed.to_dict(), allow_nan=False)
    assert len(lines(of_missed)) < 40


def test_what_fingers_reach_is_part_of_what_the_object_reaches() -> None:
    """An arc that some set holds is an arc; where all sets are seen, the plan's goal is reached."""
    found = gm_ompl.explain(ROLL, samples=100, time_limit=30)
    assert found.verdict == "there is a plan on the lattice"
    alone, held = found.explored
    assert held.fingers and held.arrived and alone.arrived
    assert held.nodes <= alone.nodes and held.arcs <= alone.arcs
    for line in held.deeds:
        assert line.holding + sum(line.findings.values()) == line.arcs
    assert {survey.where for survey in found.surveys} == {"start", "goal"}
    holding = found.surveys[0].holding
    assert 0 < holding == sum(row.holding for row in found.surveys[0].faces)


def test_placements_hold_where_a_plan_keeps_them() -> None:
    """A set holds exactly where the planner, starting with it, need not regrasp."""
    table = load(ROLL).problem.fingers.placements
    rng = np.random.default_rng(0)
    answers = set()
    for _ in range(4):
        rows = sorted(rng.choice(len(table), 2, replace=False).tolist())
        places = [
            {"face": table.labels[int(table.face[row])], "cell": table.cell[row].tolist()}
            for row in rows
        ]
        changes = [f"fingers.start={json.dumps(places)}", f"fingers.goal={json.dumps(places)}"]
        line = gm_ompl.explain(ROLL, placements=rows).placements
        assert line is not None and line.holds == (line.forward is None)
        try:
            plan = gm_ompl.plan(gm_ompl.load(ROLL, [*changes, "cost.regrasp=1e6"]))
        except gm_ompl.ScenarioError:  # fingertips on top of each other
            assert not line.holds
            continue
        assert line.holds == (plan.status == "solved" and plan.regrasps == 0), rows
        answers.add(line.holds)
    assert answers == {True, False}


def test_coordinates_are_refused() -> None:
    """Free motion has none; the message says what to ask, the command ends with 2."""
    with pytest.raises(InputError, match=r"gm_ompl\.judge"):
        gm_ompl.explain(ROLL, 0.5)
    assert CliRunner().invoke(app, ["explain", ROLL, "--at", "0.5"]).exit_code == 2


def test_the_command_tells_it_in_words_or_as_one_object() -> None:
    """Without searches: what the object does, and the same numbers with --json."""
    arguments = ["explain", ROLL, "--time-limit", "0", "--samples", "2"]
    text = CliRunner().invoke(app, arguments)
    assert text.exit_code == 0
    assert "tumbles about y" in text.stdout and "the object by itself: 50 poses" in text.stdout
    tree = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout)
    assert tree["explored"][0]["nodes"] == 50
    assert tree["explored"][0]["nearest"]["place"]["words"].startswith("[")


def test_a_chain_in_words_is_what_the_plan_does() -> None:
    """Every displacement belongs to one link; their angles add up to how the object is turned."""
    plan = gm_ompl.plan(ROLL)
    links = chain(plan, load(ROLL).problem)
    moving = [k for k, step in enumerate(plan.steps) if step.kind == "displacement"]
    told = [k for link in links for k in range(link.steps[0], link.steps[1] + 1) if k in moving]
    assert told == moving
    angles = [float(link.words.split()[1]) for link in links if link.words.startswith("tumbles")]
    assert sum(angles) == pytest.approx(180.0)
    assert all("about +y over its +x edge" in x.words for x in links if x.words[0] == "t")
    assert math.isclose(plan.steps[-1].pose_to.position[2], 3.4)  # type: ignore[union-attr]
