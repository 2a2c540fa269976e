"""Reachable placements: exact where a way is found, complete up to the stated clearance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gm_ompl
from gm_ompl.app.planning import summary
from gm_ompl.feasibility.reach import Answer
from gm_ompl.feasibility.ways import way_out, way_through_air
from gm_ompl.geometry.air import Solid, edge_distances
from gm_ompl.geometry.solids import hull
from gm_ompl.plain.air import Air, Freedom, clear_of
from tests.cluttered import cluttered, judged, sampled_out, way_is_clear, wider


def reach_case(seed: int, samples: int, placements: int) -> dict[str, int]:
    """Hold one random scene's answers against the reference's sweep and a sampling planner."""
    rng = np.random.default_rng([7, seed])
    judge, pose = judged(cluttered(rng))
    problem, reach = judge.problem, judge.reach
    table, seen = problem.fingers.placements, {"outside": 0, "pockets": 0, "undecided": 0}
    free = np.flatnonzero(judge.node(pose).free[0])
    for row in rng.permutation(free)[:placements].tolist():
        found = reach._answer(pose, 0, (), row)
        if found is Answer.UNDECIDED:
            seen["undecided"] += 1
            continue
        plain = Air(problem, pose, 0, ())
        if found is Answer.YES:
            seen["outside"] += 1
            space = reach.space(pose, 0, ())
            out = way_out(space, reach.stubs(space, 0, row))
            assert out is not None
            whole = np.concatenate([reach.centre(0, row)[None], out])
            met = way_is_clear(plain, pose.apply(whole), (int(table.piece[row]), -1))
            assert not met, f"placement {row}: its way out meets {met}"
        else:
            seen["pockets"] += 1
            wide = Air(wider(problem), pose, 0, ())
            assert not sampled_out(wide, row, rng, samples), f"placement {row} has a wide way out"
    return seen


def test_pockets_are_pockets_and_ways_are_ways() -> None:
    """No placement with a way for a wider fingertip is a pocket; every way found is swept clear."""
    seen = [reach_case(seed, 400, 3) for seed in (0, 2, 3, 4, 6, 8, 9)]
    assert sum(case["outside"] for case in seen) >= 3
    assert sum(case["pockets"] for case in seen) >= 3


def test_the_reference_agrees() -> None:
    """Its plain flood answers as the planner's does, others in place or not."""
    told = set()
    for seed in (2, 3):
        rng = np.random.default_rng([10, seed])
        judge, pose = judged(cluttered(rng))
        free = np.flatnonzero(judge.node(pose).free[0])
        for row, other in rng.permutation(free)[:4].reshape(-1, 2).tolist():
            if not judge.apart((row, other)):
                continue
            for staying in ((), ((1, other),)):
                mine = judge.reach.outside(pose, 0, staying, row)
                plain = Air(judge.problem, pose, 0, staying).freedom(row)
                assert mine == (plain is Freedom.FREE), (seed, row, staying)
                told.add(mine)
    assert told == {True, False}


def test_ways_between_placements_are_clear() -> None:
    """A way begins and ends where the fingertip touches; the reference finds nothing in it."""
    ways = 0
    for seed in (2, 3, 4, 6, 7, 11):
        rng = np.random.default_rng([9, seed])
        judge, pose = judged(cluttered(rng))
        table, free = judge.problem.fingers.placements, np.flatnonzero(judge.node(pose).free[0])
        if len(free) < 3:
            continue
        a, b, stays = rng.permutation(free)[:3].tolist()
        if not (judge.apart((a, stays)) and judge.apart((b, stays))):
            continue
        staying = ((1, stays),)
        joined = judge.reach.joined(pose, 0, staying, a, b)
        way = way_through_air(judge.reach, pose, 0, staying, a, b)
        if joined:
            assert way is not None
            ends = pose.apply(judge.centres(0)[[a, b]])
            np.testing.assert_allclose(way[[0, -1]], ends, atol=1e-12)
            plain = Air(judge.problem, pose, 0, staying)
            assert not way_is_clear(plain, way, (int(table.piece[a]), int(table.piece[b])))
            ways += 1
    assert ways >= 5


def _turned(tree: dict[str, Any], yaw: float, by: np.ndarray) -> dict[str, Any]:
    """Return the scene turned about the world's z axis and moved in the plane."""
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])

    def at(point: np.ndarray) -> np.ndarray:
        return np.array([*(turn @ point[:2] + by), point[2]])

    def corners(box: dict[str, Any]) -> list[list[float]]:
        low, high = np.array(box["min"]), np.array(box["max"])
        return [
            at(np.where(pick, high, low)).tolist()
            for pick in np.ndindex(2, 2, 2)
        ]  # fmt: skip

    obstacles = {
        name: {"hull": corners(obstacle["box"])}
        for name, obstacle in tree["environment"]["obstacles"].items()
    }
    start = at(np.array(tree["motion"]["start"]["position"])).tolist()
    motion: dict[str, Any] = {"start": {"position": start, "yaw": f"{yaw} rad"}}
    motion |= {"path": [{"slide": {"by": [*(turn @ [0.001, 0.0]).tolist(), 0]}}]}
    return {**tree, "environment": {"obstacles": obstacles}, "motion": motion}


def moved_case(seed: int) -> list[bool]:
    """Hold one random scene's answers against those where it stands elsewhere, turned."""
    rng, masks = np.random.default_rng([5, seed]), []
    tree = cluttered(np.random.default_rng([10, seed]))
    other = _turned(tree, float(rng.uniform(0, 6)), rng.uniform(-5, 5, size=2))
    for scene in (tree, other):
        judge, pose = judged(scene)
        free = np.flatnonzero(judge.node(pose).free[0])
        masks.append([(row, judge.reach.outside(pose, 0, (), row)) for row in free.tolist()])
    assert masks[0] == masks[1]
    return [outside for _, outside in masks[0]]


def test_where_the_scene_stands_does_not_matter() -> None:
    """Moved and turned about the vertical, each placement is reachable as before."""
    told = [outside for seed in (2, 3, 5) for outside in moved_case(seed)]
    assert set(told) == {True, False}


def test_stretches_are_swept_exactly() -> None:
    """Distances of segments, and what keeps clear of a hull, are those of a fine sampling."""
    rng = np.random.default_rng(3)
    a, b, c, d = rng.normal(size=(4, 40, 3))
    t = np.linspace(0.0, 1.0, 200)[:, None]
    near = edge_distances(a, b, c, d - c)
    for k in range(0, 40, 7):
        p, q = a[k] + t * (b[k] - a[k]), c[k] + t * (d[k] - c[k])
        least = np.linalg.norm(p[:, None] - q[None], axis=2).min()
        assert near[k, k] <= least + 1e-12 and near[k, k] >= least - 0.02
    piece = hull(rng.normal(size=(12, 3)))
    least = 0.4
    judge, _ = judged(cluttered(rng))
    air = judge.reach._air(judge.problem.motion.pose(judge.problem.start), 0, ())
    ends = 3.0 * rng.normal(size=(2, 300, 3))
    mine = air._clear_of(Solid.of(piece, least), ends[0], ends[1])
    plain = clear_of(piece, ends[0], ends[1], least)
    assert (mine == plain).all() and 20 < mine.sum() < 280


PEG = {
    "object": {"shape": {"box": [2, 2, 2]}, "mass": 0.1},
    "friction": {"environment": 0.4, "finger": 0.8},
    "fingers": {
        "count": 3, "radius": 0.3, "max_normal_force": 5,
        "placements": {"grid": [1, 1], "faces": ["+x", "-x", "+y"]},
    },
    "motion": {"start": {"position": [0, 0, 1]}, "path": [{"slide": {"by": [0, 0, 3]}}]},
    "lattice": {"segments": 6},
    "mechanics": {"z_min": 0.01},
    "cost": {"regrasp": 1, "stability": 0.001},
}  # fmt: skip


def hole(wide: float, mouth: float) -> dict[str, Any]:
    """Return walls around the peg that leave a gap this wide, and a lid that leaves a mouth."""
    walls = {}
    for name, gap, low, high in (("wall", wide, 0, 2), ("lid", mouth, 2, 2.5)):
        g = 1 + gap
        walls[f"{name} west"] = {"min": [-3, -3, low], "max": [-g, 3, high]}
        walls[f"{name} east"] = {"min": [g, -3, low], "max": [3, 3, high]}
        walls[f"{name} south"] = {"min": [-g, -3, low], "max": [g, -g, high]}
        walls[f"{name} north"] = {"min": [-g, g, low], "max": [g, 3, high]}
    return {"obstacles": {name: {"box": box} for name, box in walls.items()}}


def peg(wide: float, mouth: float, **fingers: Any) -> gm_ompl.Scenario:
    """Return a peg that is lifted out of a hole."""
    tree = {**PEG, "environment": hole(wide, mouth)}
    return gm_ompl.load({**tree, "fingers": {**PEG["fingers"], **fingers}})  # type: ignore[dict-item]


def nudged(wide: float, mouth: float, **fingers: Any) -> gm_ompl.Scenario:
    """Return the peg lifted by so little that it stays in the hole."""
    path = [{"slide": {"by": [0, 0, 0.2]}}]
    return peg(wide, mouth, **fingers).with_({"motion.path": path, "lattice.segments": 1})


@pytest.mark.filterwarnings("ignore::gm_ompl.ScenarioWarning")
def test_a_pocket_in_a_hole_is_refused_by_that_word() -> None:
    """Where fingertips fit beside the peg, but not through the hole's mouth: plan and explain."""
    assert gm_ompl.plan(peg(0.7, 0.7)).status == "solved"
    closed = nudged(0.7, 0.3)
    found = gm_ompl.plan(closed)
    assert (found.status, found.lower_bound) == ("infeasible", None)
    assert found.statistics.model_extra is not None and found.statistics.model_extra["pockets"] > 0
    assert "pocket" in "\n".join(summary(found, closed.problem))
    told = gm_ompl.explain(
        closed, placements=[("+x", (0, 0)), ("-x", (0, 0)), ("+y", (0, 0))], time_limit=0
    )
    assert "in a pocket" in told.verdict
    assert told.placements is not None and told.placements.forward is not None
    assert "finger 0 at +x:[0, 0] is in a pocket" in told.placements.forward.blocked_by[0]


@pytest.mark.filterwarnings("ignore::gm_ompl.ScenarioWarning")
def test_check_refuses_a_first_touch_in_a_pocket() -> None:
    """A plan found without transit does not hold where fingers must come to their placements."""
    plan = gm_ompl.plan(nudged(0.7, 0.3, transit=False))
    assert plan.status == "solved" and gm_ompl.check(plan).holds
    asked = {**plan.scenario, "fingers": {**plan.scenario["fingers"], "transit": True}}
    report = gm_ompl.check(plan.model_copy(update={"scenario": asked}))
    assert [v.topic for v in report.violations] == ["first touches"]
    assert "pocket" in report.violations[0].message
    given = [{"face": p.face, "cell": list(p.cell or ())} for p in plan.steps[0].placements]
    standing = {**asked, "fingers": {**asked["fingers"], "start": given}}
    assert gm_ompl.check(plan.model_copy(update={"scenario": standing})).holds


@pytest.mark.filterwarnings("ignore::gm_ompl.ScenarioWarning")
def test_leaving_at_the_end_is_asked_only_if_wanted() -> None:
    """A peg is let down into a pocket; with ``fingers.leave`` that is no plan."""
    given = [{"face": face, "cell": [0, 0]} for face in ("+x", "-x", "+y")]
    tree = peg(0.7, 0.7, start=given).resolved()
    # A lid over the whole hole is far above; the peg slides under it.
    tree["environment"]["obstacles"] = {
        **hole(0.7, 0.7)["obstacles"],
        "roof": {"box": {"min": [-3, -3, 4.6], "max": [3, 3, 5]}},
    }
    tree["motion"]["path"] = [{"slide": {"by": [0, 0, 0.5]}}]
    tree["lattice"]["segments"] = 1
    assert gm_ompl.plan(tree).status == "solved"
    tree["fingers"]["leave"] = True
    assert gm_ompl.plan(tree).status == "solved"
    tree["environment"]["obstacles"]["roof"]["box"]["min"][2] = 2.6
    found = {leave: _status(tree, leave) for leave in (False, True)}
    assert found == {False: "solved", True: "infeasible"}


def _status(tree: dict[str, Any], leave: bool) -> str:
    return gm_ompl.plan({**tree, "fingers": {**tree["fingers"], "leave": leave}}).status
