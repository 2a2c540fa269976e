"""The least change of one value with which a plan exists."""

from __future__ import annotations

import dataclasses
import enum
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.diagnosis.values import Remedy
from gm_ompl.limits import Limits
from gm_ompl.motion.free import FreeMotion
from gm_ompl.problem import Fingers, Problem
from gm_ompl.scenario.checks import MOST_FRICTION, MOST_WEIGHTS

FAR = 100.0
"""No value is changed by more than this factor."""

CLOSE = 1.02
"""Bisection ends where what helps and what does not are this near to each other."""

FROM_ZERO = 0.01
"""Where a friction coefficient that is 0 begins to grow."""

SOFTEST = 0.99
"""The largest length of a soft fingertip that is tried, over its radius: rounding stays below."""

TO_ZERO = math.inf
"""The factor of a value that is turned down to 0."""


class TrialOutcome(enum.Enum):
    """Whether a changed problem has what is wanted."""

    YES = "it has"
    NO = "it is proven that it has not"
    UNKNOWN = "not known"


Holds: TypeAlias = Callable[[Problem, float], TrialOutcome]
"""Answers about a changed problem within some seconds."""


@dataclass(frozen=True)
class Knob:
    """One value of a scenario that may be turned.

    Attributes:
        key: its path in the scenario.
        values: (k,), what it is today, per finger or one.
        put: returns the problem with other values.
        up: whether larger values are tried.
        orderly: whether what holds at one value holds at every more generous one.
        most: the largest factor that a scenario may have.
        from_zero: (k,) or a number, where values that are 0 begin to grow.
    """

    key: str
    values: Array
    put: Callable[[Array], Problem]
    up: bool
    orderly: bool
    most: float = FAR
    from_zero: Array | float = FROM_ZERO

    @property
    def rungs(self) -> tuple[float, ...]:
        """The factors that are tried first, in increasing order."""
        rungs = (FAR, TO_ZERO) if self.orderly else (1.5, 4.0, 20.0, FAR)
        return tuple(sorted({min(rung, self.most) for rung in rungs}))

    def at(self, factor: float) -> Array:
        """Return the values ``factor`` times more generous, as they can be written."""
        base = np.where(self.values > 0.0, self.values, self.from_zero if factor > 1.0 else 0.0)
        wanted = base * factor if self.up else base / factor
        return np.array([float(f"{value:.3g}") for value in wanted.tolist()])

    def shown(self, values: Array) -> str:
        """Return values as in a scenario: one number where they are equal."""
        texts = [f"{value:.6g}" for value in values.tolist()]
        return texts[0] if len(set(texts)) == 1 else f"[{', '.join(texts)}]"

    @property
    def name(self) -> str:
        """What its values are said to be of."""
        return self.key

    def told(self, values: Array) -> str:
        """Return values as they are spoken of."""
        return self.shown(values)


@dataclass(frozen=True)
class Words:
    """What is said of one value.

    Attributes:
        so: what holds with it: "a plan exists".
        not_so: what is proven not to: "none on the lattice".
        not_known: what was not found: "none found".
    """

    so: str
    not_so: str
    not_known: str


def knobs(problem: Problem) -> Iterator[Knob]:
    """Yield what may be turned to help a problem.

    Stronger fingers and a smaller z_min can only help. Friction and softness may also harm, since
    they can build up internal force: what is found between two values need not hold beyond.
    """
    hand, environment = problem.fingers, problem.environment

    def put(part: str, key: str, number: bool) -> Callable[[Array], Problem]:
        def changed(values: Array) -> Problem:
            value = float(values[0]) if number else values
            whole = dataclasses.replace(getattr(problem, part), **{key: value})
            found = dataclasses.replace(problem, **{part: whole})
            if isinstance(problem.motion, FreeMotion):  # where the object can get stays the same
                vars(found)["object_graph"] = problem.object_graph
            return found

        return changed

    weight = problem.mass * problem.mechanics.gravity
    strongest = float(hand.max_normal_force.max(initial=0.0))
    most = FAR if weight <= 0.0 else min(FAR, MOST_WEIGHTS * weight / max(strongest, 1e-300))
    tips, ground = put("fingers", "friction", False), put("environment", "friction", True)
    z_min, rough = np.array([problem.mechanics.z_min]), np.array([environment.friction])
    if hand.count:
        limits = put("fingers", "max_normal_force", False)
        yield Knob("fingers.max_normal_force", hand.max_normal_force, limits, True, True, most)
    if problem.mechanics.z_min > 0.0:
        smaller = put("mechanics", "z_min", True)
        yield Knob("mechanics.z_min", z_min, smaller, False, True, TO_ZERO)
    if hand.count:
        yield Knob("friction.finger", hand.friction, tips, True, False, _rougher(hand.friction))
        yield from _softer(hand, put("fingers", "soft", False))
    yield Knob("friction.environment", rough, ground, True, False, _rougher(rough))
    if environment.friction > 0.0:
        yield Knob("friction.environment", rough, ground, False, False)


def _rougher(friction: Array) -> float:
    """Return by what factor friction may grow."""
    return min(FAR, MOST_FRICTION / max(float(friction.max()), FROM_ZERO))


def _softer(hand: Fingers, put: Callable[[Array], Problem]) -> Iterator[Knob]:
    """Yield how much softer fingertips may become, all by one factor, if they may."""
    begin = FROM_ZERO * hand.radius
    today = np.where(hand.soft > 0.0, hand.soft, begin)
    most = float(np.min(SOFTEST * hand.radius / today))
    if most > 1.0:
        yield Knob("fingers.soft", hand.soft, put, True, False, min(FAR, most), begin)


def least(knob: Knob, holds: Holds, words: Words, today: TrialOutcome, deadline: Limits) -> Remedy:
    """Return the least change of one value that helps, found by bisection.

    Args:
        knob: what is turned; what is wanted does not hold today.
        holds: answers about the changed problem.
        words: for the sentence.
        today: NO where it is proven that it does not hold today.
        deadline: of all that is tried.
    """
    low, high, proven = _bracket(knob, holds, today is TrialOutcome.NO, deadline)
    if high is None:
        return _in_vain(knob, words, low, proven)
    values, below = knob.at(high), knob.at(low)
    while high / low > CLOSE and not deadline.passed():
        middle = math.sqrt(low * high)
        tried = knob.at(middle)
        if (tried == values).all() or (tried == below).all():
            break
        answer = holds(knob.put(tried), deadline.left() / 2)
        if answer is TrialOutcome.YES:
            high, values = middle, tried
        else:
            low, below, proven = middle, tried, answer is TrialOutcome.NO
    told, now = knob.told(values), knob.told(knob.values)
    missed = f"{words.not_so if proven else words.not_known} with {knob.told(below)}"
    aside = "" if high / low <= CLOSE or high == TO_ZERO else ", the time was up"
    evidence = f"{words.so} with {knob.name} = {told} (today {now}; {missed}{aside})"
    return Remedy(f"{knob.key}={knob.shown(values)}", True, evidence)


def _bracket(
    knob: Knob, holds: Holds, proven: bool, deadline: Limits
) -> tuple[float, float | None, bool]:
    """Return a factor that does not help, a larger one that does, and whether the first is proven.

    Where nothing helps: the largest factor tried, and whether all of them were proven in vain.
    """
    low = 1.0
    for rung in knob.rungs:
        if rung <= 1.0 or deadline.passed():
            return low, None, False
        answer = holds(knob.put(knob.at(rung)), deadline.left() / 2)
        if answer is TrialOutcome.YES:
            return low, rung, proven
        proven = proven and answer is TrialOutcome.NO
        if not knob.orderly or answer is TrialOutcome.NO:
            low = rung
    return low, None, proven


def _in_vain(knob: Knob, words: Words, far: float, proven: bool) -> Remedy:
    factor = f"{far:.3g} times" if knob.up else "0" if far == TO_ZERO else f"1/{far:.3g}"
    values = knob.shown(knob.at(far if far > 1.0 else knob.most))
    if far <= 1.0:
        why = "not settled in the time"
    elif knob.orderly:
        why = f"{words.not_so} {'up' if knob.up else 'down'} to {factor}"
    else:
        why = f"{words.not_so if proven else words.not_known} with values tried "
        why += f"{'up' if knob.up else 'down'} to {factor}"
    return Remedy(f"{knob.key}={values}", False, f"{why} (today {knob.told(knob.values)})")
