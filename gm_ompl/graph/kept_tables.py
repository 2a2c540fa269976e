"""What the search for plans that keep the whole hand goes by, as compiled code reads it."""

from __future__ import annotations

from typing import Final, NamedTuple

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.graph.goal_distance import GoalTips
from gm_ompl.graph.potentials import PlaneGoal

SAME: Final = 1e-12
"""A way cheaper by less than this, relatively, is no better: sums differ by rounding."""

UNKNOWN, WANTED, READY, BLOCKED = range(4)
"""What is known of a class of arcs: nothing; all; or that no hand passes."""

STATES, ASKED, ARRIVED = range(3)
"""Which of ``StateBook.counts`` is which: states, margins asked for, ways to the goal."""

EMPTY: Final = -1
"""A slot that nothing is in."""

ASKED_FOR: Final = -2
"""Stands for what is to be found."""

ASKS_APART: Final = 1 << 24
"""Margins are asked for by contact states times this, plus sets."""

FAILED: Final = -1.0
"""Stands for a margin below z_min; a margin that was asked for and is not known is NaN."""


class KeptSets(NamedTuple):
    """Sets of placements.

    Attributes:
        rows: (S, n), placements; LIFTED where a finger is in the air: such a set is a hub.
        shapes: (n,), which fingers share their tables of placements.
        alive: (S,), whether plans may have them.
        lifts: (S, n), the hubs that lifting a finger leads to; EMPTY: it is not to be lifted.
        known: (S,), whether ``potentials`` holds them.
        potentials: (S, K, 4).
        target: where the object must end, in the plane.
    """

    rows: IntArray
    shapes: IntArray
    alive: BoolArray
    lifts: IntArray
    known: BoolArray
    potentials: Array
    target: PlaneGoal


class FloorTable(NamedTuple):
    """What is left to pay on an open floor, see ``floor_values``.

    Attributes:
        rows: (S,), a set's row in what follows; -1: none.
        points: (N, 3), o.
        ways: (N, 2), y.
        values: (N, A), by attitude.
        goal: (2,), where the centre of mass must be.
        slack: how far from there it may be.
    """

    rows: IntArray
    points: Array
    ways: Array
    values: Array
    goal: Array
    slack: float


class Poses(NamedTuple):
    """Poses that were met.

    Attributes:
        places: (V, 5), as ``potential`` has it.
        goal: (V,), whether the object has arrived.
        first: (V,), the first arc that leaves it; -1 where its arcs are not known.
        past: (V,), the arc past its last.
        attitudes: (V,), their numbers on an open floor; -1: none.
        rests: (V,), contact states of the object at rest; EMPTY or ASKED_FOR where not known.
    """

    places: Array
    goal: BoolArray
    first: IntArray
    past: IntArray
    attitudes: IntArray
    rests: IntArray


class BodyPoses(NamedTuple):
    """Where the object is at poses.

    Attributes:
        numbers: (V,), rows of what follows.
        rotations: (B, 3, 3).
        positions: (B, 3).
    """

    numbers: IntArray
    rotations: Array
    positions: Array


class KeptArcs(NamedTuple):
    """Arcs, and the classes of those that are alike.

    Attributes:
        heads: (A,), the poses they lead to.
        forms: (A,), their row in what follows.
        kinds: (A,), their row in what follows that.
        lines: (R, 2, 3), a point and the unit direction of a rotation's line, object frame; zeros
            of a translation.
        chords: (R, parts): times the distance from the line, |dq_finger i,j| of Eq. (9); of a
            translation as they are.
        stages: (K,), UNKNOWN to BLOCKED.
        free: (K, F, P), whether a fingertip is free all along.
        states: (K, parts), contact states; -1 behind the last.
    """

    heads: IntArray
    forms: IntArray
    kinds: IntArray
    lines: Array
    chords: Array
    stages: IntArray
    free: BoolArray
    states: IntArray


class StateBook(NamedTuple):
    """States that were met, and margins.

    Attributes:
        slots: numbers of states by pose and set, EMPTY where there is none; a power of two.
        pose: (E,).
        hand: (E,), the set.
        cost: (E,), of getting there.
        bound: (E,), on what follows.
        key: (E,), the least bound of a plan by an arc to be followed; +inf: it is not open.
        parent: (E,), the state before; -1 at the start.
        via: (E,), the arc from there.
        asks: (M,), contact states and sets; EMPTY where there is none.
        margins: (M,), z.
        new: (N, 2), contact states and sets that were asked for.
        counts: (3,), of states, of rows of ``new``, of ways found to the goal.
    """

    slots: IntArray
    pose: IntArray
    hand: IntArray
    cost: Array
    bound: Array
    key: Array
    parent: IntArray
    via: IntArray
    asks: IntArray
    margins: Array
    new: IntArray
    counts: IntArray


class Relaxed(NamedTuple):
    """What is left to travel where no margin is asked for, see ``relaxed``.

    Attributes:
        rows: (S,), what stands for the fingers of a set that stay to the end; EMPTY: nothing; of a
            set with ``lifts`` it is what stands for those.
        extra: (S,), what regrasps to come cost.
        book: states of what stands for sets.
        after: (E,), what follows them costs at least.
        reached: all ways of at most this were followed.
    """

    rows: IntArray
    extra: Array
    book: StateBook
    after: Array
    reached: float


class Prices(NamedTuple):
    """What Eqs. (9) and (10) go by.

    Attributes:
        X_stab: a force.
        z_floor: a force.
        X_regr: a length.
    """

    X_stab: float
    z_floor: float
    X_regr: float


class KeptTables(NamedTuple):
    """All that the search goes by."""

    hands: KeptSets
    floor: FloorTable
    poses: Poses
    bodies: BodyPoses
    goal: GoalTips
    arcs: KeptArcs
    book: StateBook
    prices: Prices
    relaxed: Relaxed
