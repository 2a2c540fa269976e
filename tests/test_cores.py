"""Work shared out among the cores."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.cores import share_out


@pytest.mark.parametrize("count", [0, 1, 2, 7, 1000])
@pytest.mark.parametrize("least", [1, 4, 5000])
def test_every_item_is_done_once(count: int, least: int) -> None:
    """However few the items, each belongs to one part."""
    done = np.zeros(count, dtype=int)

    def work(part: slice) -> None:
        assert part.stop - part.start >= min(count, least)
        done[part] += 1

    share_out(work, count, least)
    assert (done == 1).all()


def test_an_error_in_a_part_is_the_caller_s() -> None:
    """What a thread raises is raised here."""

    def work(part: slice) -> None:
        if part.start:
            raise ValueError("second part")

    with pytest.raises(ValueError, match="second part"):
        share_out(work, 10)
