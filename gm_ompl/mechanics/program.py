"""What Problem (6) is asked about at an instant, as compiled functions hand it to each other."""

from __future__ import annotations

from typing import NamedTuple

from gm_ompl.arrays import Array, IntArray


class Program(NamedTuple):
    """The data of Problem (6) at an instant but for modes and f_com, forces over force_scale.

    Attributes:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,).
        L: (76, 6), the directions l_i.
    """

    env: Array
    q: Array
    tips: Array
    f_max: Array
    L: Array


class Touch(NamedTuple):
    """The same for fingers at some of their placements.

    Attributes:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        table: (N, P, s, 6), all fingers' columns for unit normal force at all placements.
        f_max: (N,).
        L: (76, 6), the directions l_i.
        hand: (n,), the fingers that touch.
        rows: (n,), where.
    """

    env: Array
    q: Array
    table: Array
    f_max: Array
    L: Array
    hand: IntArray
    rows: IntArray


class Separation(NamedTuple):
    """A wrench that separates the environment's columns a: w . a >= margin |a| for all of them.

    Attributes:
        w: (6,).
        margin: positive, or anything else where no such wrench is known.
    """

    w: Array
    margin: float
