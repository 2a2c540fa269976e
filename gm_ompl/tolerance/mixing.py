"""Forces between several worlds whose columns change evenly, mixed from those at the corners.

Between corners v of a box, forces k = sum_v lambda_v k_v with the weights of a multilinear mixture
resist z l_i but for a rest: per side c of the box t_c (1 - t_c) times the mixture, over the other
sides, of dA_c dk_i. z less that rest's norm is what is left; it is bounded from below by its least
coefficient in Bernstein's form, of degree two along each side.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.tolerance.forces import Held


def covered(corners: Sequence[Held], sides: int) -> bool:
    """Whether slacks at the corners of a box of worlds make up for the rest everywhere in it.

    Args:
        corners: 2 ** ``sides`` worlds, the last side changing fastest.
        sides: how many of the box there are.
    """
    if not all(len(here.forces) for here in corners):
        return False
    shape = (2,) * sides
    slack = np.array([here.slack for here in corners]).reshape(shape)
    rests = [_rest(corners, shape, side) for side in range(sides)]
    return all(
        least_coefficient(slack, rests, index) >= 0.0
        for index in itertools.product((0, 0.5, 1), repeat=sides)
        if 0.5 in index
    )


def _rest(corners: Sequence[Held], shape: tuple[int, ...], side: int) -> Array:
    """Return dA dk along one side, by the corners of the others: (2, ..., 1, ..., 2, 76, 6)."""
    forces = np.stack([here.forces for here in corners])
    forces = forces.reshape(*shape, *forces.shape[1:])
    columns = np.array([0, 2 ** (len(shape) - 1 - side)])
    change = corners[columns[1]].columns - corners[columns[0]].columns
    rest: Array = np.diff(forces, axis=side) @ change.T
    return rest


def least_coefficient(slack: Array, rests: Sequence[Array], index: Sequence[float]) -> float:
    """Return one coefficient of what is left, the least of all directions.

    Args:
        slack: (2, ..., 2), by corner.
        rests: per side, as ``_rest`` returns it.
        index: per side 0 or 1, an end, or 0.5, its middle.
    """
    half = [side for side, place in enumerate(index) if place == 0.5]
    left = np.zeros(rests[0].shape[-2:])
    for side in half:
        left += _mixed(rests[side], index, skip=side) / 2.0
    return float(_mixed(slack, index)) - float(np.linalg.norm(left, axis=1).max())


def _mixed(values: Array, index: Sequence[float], skip: int = -1) -> Array:
    """Return values at ends, and the mean of both at middles, of the first axes."""
    for side, place in enumerate(index):
        if side == skip:
            values = values[0]
        else:
            values = values.mean(axis=0) if place == 0.5 else values[int(place)]
    return values
