"""Where a plan goes over from one set of commands to the next.

Between two segments, and before and after a finger is lifted, the hand ramps from the commands
before to the commands after at one pose. Which forces balance the object on the way is a convex
question: where they do at both ends of the ramp, they do all along it.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

from gm_ompl.contact.decision import ControlMode
from gm_ompl.motion.arc import Moment

Forces: TypeAlias = tuple[float | None, ...]
"""Commanded normal force per finger, None under position control."""


class JunctionVerdict(enum.Enum):
    """Whether a junction holds; the value is a sentence for the user."""

    HOLDS = "forces balance all along the ramp"
    RESTS = "forces balance all along the ramp while the object rests, but not as it moves"
    FAILS = "on the ramp no forces balance, not even while the object rests"


class Control(NamedTuple):
    """What one finger does in a segment or at a rest.

    Attributes:
        mode: None while it does not touch.
        f_com: the commanded normal force; None but under force control.
    """

    mode: ControlMode | None = None
    f_com: float | None = None


class Junction(NamedTuple):
    """A ramp from one set of commands to the next, at one pose.

    Attributes:
        fingers: of the hand, those that touch before or after.
        modes: of those fingers, throughout the ramp.
        before: their commands at its beginning.
        after: their commands at its end.
    """

    fingers: tuple[int, ...]
    modes: tuple[ControlMode, ...]
    before: Forces
    after: Forces

    @property
    def ends(self) -> tuple[Forces, ...]:
        """The commands at both ends; one entry where they are equal."""
        return (self.before,) if self.before == self.after else (self.before, self.after)


def controls(
    modes: Sequence[ControlMode], f_com: Forces, fingers: Sequence[int], count: int
) -> tuple[Control, ...]:
    """Return what each finger of a hand of ``count`` does; modes and f_com are of ``fingers``."""
    hand = [Control()] * count
    for finger, mode, force in zip(fingers, modes, f_com, strict=True):
        hand[finger] = Control(mode, force)
    return tuple(hand)


def meeting(before: Moment, after: Moment) -> tuple[Moment, ...]:
    """Return the instants at which a junction is judged.

    It is the pose between under each of the two twists; where the object rests before or after,
    it rests there, too.

    Args:
        before: the last instant of what comes before.
        after: the first of what follows, at the same pose.
    """
    if before.twist is None or after.twist is None:
        return (Moment(before.pose),)
    return (before,) if before.key == after.key else (before, after)


def passage(
    ramp: Junction, before: Moment, after: Moment, balanced: Callable[[Moment, Forces], bool]
) -> JunctionVerdict:
    """Judge a junction.

    Args:
        ramp: the junction.
        before: the last instant of what comes before.
        after: the first of what follows, at the same pose.
        balanced: whether forces balance the object at an instant, with given commands.
    """
    for answer, moments in (
        (JunctionVerdict.HOLDS, meeting(before, after)),
        (JunctionVerdict.RESTS, (Moment(before.pose),)),
    ):
        if all(balanced(moment, end) for moment in moments for end in ramp.ends):
            return answer
    return JunctionVerdict.FAILS


def junction(before: Sequence[Control], after: Sequence[Control]) -> Junction:
    """Return the ramp between two sets of commands, one ``Control`` per finger of the hand.

    Position-controlled are the fingers that are so in both. A finger commanded in only one takes
    that command throughout. A finger that touches in only one, since it is lifted or set down
    between the two, keeps the mode that it has there; under force control it ramps to, or from, 0.
    """
    rows = [
        (finger, *_ramp(a, b))
        for finger, (a, b) in enumerate(zip(before, after, strict=True))
        if a.mode is not None or b.mode is not None
    ]
    return Junction(
        fingers=tuple(row[0] for row in rows),
        modes=tuple(row[1] for row in rows),
        before=tuple(row[2] for row in rows),
        after=tuple(row[3] for row in rows),
    )


def _ramp(before: Control, after: Control) -> tuple[ControlMode, float | None, float | None]:
    """Return a finger's mode on the way, and its command at both ends."""
    touching = [control for control in (before, after) if control.mode is not None]
    commanded = [c.f_com for c in touching if c.mode is ControlMode.FORCE]
    if not commanded:
        return ControlMode.POSITION, None, None
    if before.mode is None:
        return ControlMode.FORCE, 0.0, commanded[0]
    if after.mode is None:
        return ControlMode.FORCE, commanded[0], 0.0
    return ControlMode.FORCE, commanded[0], commanded[-1]
