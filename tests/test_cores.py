"""Work shared out among the cores."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl import cores
from gm_ompl.cores import share_out


@pytest.mark.parametrize("threads", [1, 2, 64])
@pytest.mark.parametrize("count", [0, 1, 2, 7, 1000])
@pytest.mark.parametrize("least", [1, 4, 5000])
def test_every_item_is_done_once(
    count: int, least: int, threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However few the items and many the cores, each belongs to one part."""
    monkeypatch.setattr(cores, "cores", lambda: threads)
    done = np.zeros(count, dtype=int)

    def work(part: slice) -> None:
        assert part.stop - part.start >= min(count, least)
        done[part] += 1

    share_out(work, count, least)
    assert (done == 1).all()


def test_an_error_in_a_part_is_the_caller_s(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a thread raises is raised here."""
    monkeypatch.setattr(cores, "cores", lambda: 2)

    def work(part: slice) -> None:
        if part.start:
            raise ValueError("second part")

    with pytest.raises(ValueError, match="second part"):
        share_out(work, 10)
