from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.contact.decision import ControlMode, ModeDecision, Outcome
from gm_ompl.contact.state import Instant
from gm_ompl.motion.object_graph import way_along
from gm_ompl.plain.judge import ReferenceJudge, Ruling
from gm_ompl.problem import Problem
from gm_ompl.reference.modes import Modes, decide_modes

MakeProblem = Callable[..., Problem]


def place(problem: Problem, label: str, cell: tuple[int, int] = (0, 0)) -> int:
    found = problem.fingers.placements.find(label, cell)
    assert found is not None
    return found


def test_fingertips_may_touch_but_not_penetrate(problem: MakeProblem) -> None:
    """Radius equal to the placement's height touches the floor and is valid; larger is not."""
    for radius, valid in ((2.5, True), (2.5 + 1e-6, False)):
        p = problem(radius=(radius,), f_max=(10.0,))
        assert ReferenceJudge(p).node_valid(p.motion.pose((0.0,)), (place(p, "-x"),)) is valid


def test_two_fingertips_keep_apart(problem: MakeProblem) -> None:
    """Neighbouring placements 5 apart hold fingertips of radius 2.5, not more; never one cell."""
    for radius, valid in ((2.5, True), (2.51, False)):
        p = problem(radius=(radius, radius), grid=(2, 1), faces=["-x"])
        a, b = place(p, "-x", (0, 0)), place(p, "-x", (1, 0))
        judge = ReferenceJudge(p)
        assert judge.node_valid(p.motion.pose((0.0,)), (a, b)) is valid
        assert not judge.node_valid(p.motion.pose((0.0,)), (a, a))


def test_a_wall_blocks_placements_and_the_object(problem: MakeProblem) -> None:
    """A wall 1.5 behind the box leaves no room for a fingertip of radius 1 there; one ahead
    stops the box itself.
    """  # noqa: D205
    p = problem(
        walls=[([-9, -9, 0], [-4, 9, 9]), ([4.5, -9, 0], [9, 9, 9])], f_max=(10.0,), by=(3, 0, 0)
    )
    judge = ReferenceJudge(p)
    assert not judge.node_valid(p.motion.pose((0.0,)), (place(p, "-x"),))
    assert judge.node_valid(p.motion.pose((0.2,)), (place(p, "-x"),))
    assert judge.node_valid(p.motion.pose((2 / 3,)), (place(p, "+z"),))
    assert not judge.node_valid(p.motion.pose((0.7,)), (place(p, "+z"),))


def test_without_fingers_the_object_alone_must_be_free(problem: MakeProblem) -> None:
    """A hand of no fingers leaves the object's own penetration to decide."""
    p = problem(f_max=(), walls=[([4.5, -9, 0], [9, 9, 9])])
    judge = ReferenceJudge(p)
    assert judge.node_valid(p.motion.pose((0.5,)), ())
    assert not judge.node_valid(p.motion.pose((0.9,)), ())


def test_findings_of_a_segment(problem: MakeProblem) -> None:
    """Pushing holds, pulling has no equilibrium, a high threshold is too weak, a wall blocks."""
    p = problem(grid=(3, 1), f_max=(10.0, 10.0))
    behind = (place(p, "-x", (0, 0)), place(p, "-x", (2, 0)))
    judge = ReferenceJudge(p)
    assert judge.segment(p.motion.moment((0.5,), (1.0,)), behind).finding is Ruling.HOLDS
    assert judge.segment(p.motion.moment((0.5,), (-1.0,)), behind).finding is Ruling.NO_EQUILIBRIUM
    strict = ReferenceJudge(problem(grid=(3, 1), z_min=100.0))
    assert strict.segment(p.motion.moment((0.5,), (1.0,)), behind).finding is Ruling.TOO_WEAK
    walled = problem(grid=(3, 1), walls=[([-9, -9, 0], [-2.6, 9, 9])])
    blocked = ReferenceJudge(walled).segment(walled.motion.moment((0.0,), (1.0,)), behind)
    assert blocked.finding is Ruling.PENETRATION
    assert blocked.decision is None


def test_resting_box_may_be_let_go(problem: MakeProblem) -> None:
    """A box on its face rests by itself; on its edge it does not."""
    p = problem(f_max=(10.0,))
    assert ReferenceJudge(p).rest(p.motion.pose((0.0,)), (0,), 0).finding is Ruling.HOLDS
    tipped = problem(f_max=(10.0,), tumble=np.pi / 2)
    assert ReferenceJudge(tipped).rest(tipped.motion.pose((0.0,)), (0,), 0).finding is Ruling.HOLDS
    assert (
        ReferenceJudge(tipped).rest(tipped.motion.pose((0.5,)), (0,), 0).finding is not Ruling.HOLDS
    )


def test_contacts_of_a_tumbling_box(problem: MakeProblem) -> None:
    """A tumbling box stands on its edge's two ends, static; sliding, on four that all slide."""
    p = problem(tumble=np.pi / 2)
    tumbling = ReferenceJudge(p).contacts(p.motion.moment((0.4,), (1.0,)))
    assert len(tumbling.points) == 2
    assert not tumbling.slip.any()
    p = problem()
    sliding = ReferenceJudge(p).contacts(p.motion.moment((0.4,), (-1.0,)))
    np.testing.assert_allclose(sliding.slip, np.tile([-1.0, 0, 0], (4, 1)), atol=1e-12)


def test_cost_of_a_slide_by_hand(problem: MakeProblem) -> None:
    """Eq. (9) for one third of a slide by 3: each finger travels 1, weighted 1 + X_stab / z."""
    p = problem(grid=(3, 1), stability=0.5)
    judge = ReferenceJudge(p)
    ways = way_along(p.motion, ((0.0,), (1 / 3,)), 3)
    arc = judge.displacement(ways, 0, (place(p, "-x", (0, 0)), place(p, "-x", (2, 0))))
    assert arc is not None
    z = [d.z for d in arc.segments]
    assert len(z) == 3
    assert arc.cost == pytest.approx(sum((1 + 0.5 / z_j) / 3 for z_j in z))


def test_cost_of_a_tumble_is_of_chords_of_the_centre(problem: MakeProblem) -> None:
    """A fingertip centre at distance r from the axis moves 2 r sin(angle / 2) per segment."""
    p = problem(tumble=np.pi / 2, stability=0.0, grid=(1, 1))
    judge = ReferenceJudge(p)
    a, b = place(p, "+y"), place(p, "+z")
    cost = judge.displacement_cost(p.motion.arc((0.0,), (1.0,)), (a, b), [1.0, 1.0])
    farther = np.hypot(2.5, 5.0 + 1.0)  # the centre above the top face, from the bottom edge
    assert cost == pytest.approx(2 * 2 * farther * np.sin(np.pi / 8))


def test_equal_contact_states_are_decided_once(problem: MakeProblem) -> None:
    """While the box slides nothing changes in its frame: one decision answers nine segments."""
    p = problem(grid=(3, 1))
    calls = []

    def counted(instant: Instant, prefer: Modes | None) -> ModeDecision:
        calls.append(instant)
        return decide_modes(instant, prefer)

    judge = ReferenceJudge(p, counted)
    behind = (place(p, "-x", (0, 0)), place(p, "-x", (2, 0)))
    way = way_along(p.motion, tuple((i / 3,) for i in range(4)), 3)
    arcs = [judge.displacement(way, i, behind) for i in range(3)]
    assert all(arc is not None for arc in arcs)
    assert len(calls) == judge.decisions == 1


def test_previous_modes_are_preferred_along_an_arc(problem: MakeProblem) -> None:
    """From the second segment on, the decision hears the first one's modes."""
    p = problem(tumble=np.pi / 2, f_max=(10.0,))
    heard = []

    def force(instant: Instant, prefer: Modes | None) -> ModeDecision:
        heard.append(prefer)
        mode = ControlMode.FORCE if len(heard) == 1 else ControlMode.POSITION
        return ModeDecision(Outcome.STABLE, 1.0 + len(instant.points), (mode,), (None,), 0)

    way = way_along(p.motion, ((0.0,), (0.5,)), 2)
    arc = ReferenceJudge(p, force).displacement(way, 0, (place(p, "+z"),))
    assert arc is not None
    assert heard == [None, None, (ControlMode.FORCE,)]
