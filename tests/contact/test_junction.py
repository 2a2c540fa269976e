"""Which commands a ramp between two sets of commands goes through."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.junction import Control, JunctionVerdict, controls, junction, meeting, passage
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.arc import Moment

P, F, NONE = Control(ControlMode.POSITION), ControlMode.FORCE, Control()


def force(f_com: float) -> Control:
    return Control(F, f_com)


@pytest.mark.parametrize(
    ("before", "after", "ramp"),
    [
        (P, P, (None, None)),
        (force(2.0), force(3.0), (2.0, 3.0)),
        (P, force(3.0), (3.0, 3.0)),
        (force(2.0), P, (2.0, 2.0)),
        (NONE, force(3.0), (0.0, 3.0)),
        (force(2.0), NONE, (2.0, 0.0)),
        (NONE, P, (None, None)),
        (P, NONE, (None, None)),
        (force(0.0), force(0.0), (0.0, 0.0)),
    ],
)
def test_a_finger_is_commanded_as_defined(
    before: Control, after: Control, ramp: tuple[float | None, float | None]
) -> None:
    """Position only where it is so in both; one command counts throughout; lifted means 0."""
    found = junction([P, before], [P, after])
    assert found.fingers == (0, 1)
    assert (found.before[1], found.after[1]) == ramp
    assert (found.modes[1] is F) == (ramp[0] is not None)
    assert len(found.ends) == 1 + (ramp[0] != ramp[1])


def test_a_finger_that_never_touches_takes_no_part() -> None:
    """Lifted before and after: it is in no ramp."""
    hand = controls((ControlMode.POSITION, F), (None, 1.0), (0, 2), 3)
    assert hand == (P, NONE, force(1.0))
    assert junction(hand, hand).fingers == (0, 2)


def test_a_ramp_backwards_has_the_same_ends() -> None:
    """Before and after exchanged: the same modes, the ends exchanged."""
    kinds = [P, NONE, force(1.0), force(2.0)]
    for a in kinds:
        for b in kinds:
            there, back = junction([a], [b]), junction([b], [a])
            assert there.modes == back.modes
            assert (there.before, there.after) == (back.after, back.before)


def test_it_is_judged_under_both_motions_or_at_rest() -> None:
    """One instant where both motions are one, two at a corner, rest where either side rests."""
    pose = Pose.from_yaw([0.0, 0.0, 1.0])
    along, across = (Moment(pose, Twist(np.array(v), np.zeros(3))) for v in np.eye(3)[:2])
    rest = Moment(pose)
    assert meeting(along, along) == (along,)
    assert meeting(along, across) == (along, across)
    assert (
        [m.twist for m in meeting(along, rest)] == [None] == [m.twist for m in meeting(rest, rest)]
    )


@pytest.mark.parametrize(
    ("moving", "resting", "verdict"),
    [(True, True, "HOLDS"), (False, True, "RESTS"), (False, False, "FAILS")],
)
def test_a_verdict_says_when_forces_balance(moving: bool, resting: bool, verdict: str) -> None:
    """Both ends must balance, under the motion first, else at rest."""
    pose = Pose.from_yaw([0.0, 0.0, 1.0])
    moment = Moment(pose, Twist(np.array([1.0, 0.0, 0.0]), np.zeros(3)))
    ramp = junction([force(1.0)], [force(2.0)])

    def balanced(at: Moment, f_com: tuple[float | None, ...]) -> bool:
        return f_com == (1.0,) or (resting if at.twist is None else moving)

    assert passage(ramp, moment, moment, balanced) is JunctionVerdict[verdict]
