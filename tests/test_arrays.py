"""Read-only arrays: what is copied, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.arrays import read_only
from gm_ompl.errors import ShapeError
from gm_ompl.geometry.pose import Twist


def test_only_what_nobody_can_write_to_is_not_copied() -> None:
    """A result comes back as it is; whatever could still be written to is copied."""
    values = np.arange(6.0).reshape(2, 3)
    once = read_only(values, (2, 3), "values")
    values[0, 0] = 9.0
    assert once[0, 0] == 0.0
    assert read_only(once, (None, 3), "values") is once
    with pytest.raises(ValueError, match="read-only"):
        once[0, 0] = 1.0
    view = values.copy()[:1]
    view.flags.writeable = False  # its base is not
    assert read_only(view, (1, 3), "values").base is None
    whole = np.arange(3)
    whole.flags.writeable = False
    assert read_only(whole, (3,), "values").dtype == np.float64


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_nan_and_infinity_are_refused_but_not_large_numbers(bad: float) -> None:
    """Numbers whose squares overflow are numbers; a read-only array is looked at, too."""
    assert read_only([1e200, -1e300], (2,), "values")[1] == -1e300
    fixed = np.array([1.0, bad])
    fixed.flags.writeable = False
    for values in ([1e200, bad], fixed):
        with pytest.raises(ShapeError, match="NaN or infinite"):
            read_only(values, (2,), "values")


def test_shapes_are_held_to() -> None:
    """A wrong length or number of axes is an error; no rows at all fit any number of them."""
    assert read_only([], (None, 3), "values").shape == (0, 3)
    for shape in ((3,), (2, 2), (2, None, 3)):
        with pytest.raises(ShapeError):
            read_only(np.zeros((2, 3)), shape, "values")


def test_fastest_is_the_greatest_of_all_speeds() -> None:
    """By the cross product, for translations, rotations and both."""
    rng = np.random.default_rng(0)
    for linear, angular in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0)):
        twist = Twist(linear * rng.normal(size=3), angular * rng.normal(size=3))
        arms = rng.normal(size=(7, 3))
        velocities = twist.linear + np.cross(twist.angular, arms)
        np.testing.assert_allclose(twist.at(arms), velocities, rtol=0, atol=1e-14)
        assert twist.fastest(arms) == pytest.approx(np.linalg.norm(velocities, axis=1).max())
