"""The best partners of every placement are those that deciding every set finds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gm_ompl import api
from gm_ompl.feasibility import partners
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.motion.arc import Moment

CASES: tuple[tuple[str, float | None, dict[str, Any]], ...] = (
    ("paper/slide", 0.4, {}),
    ("paper/push", 0.4, {}),
    ("paper/tumble", 0.3, {}),
    ("paper/regrasp", None, {}),
    ("paper/tumble", 0.7, {"fingers.soft": 0.3}),
    ("paper/slide", 0.4, {"mechanics.z_min": 0}),
    ("paper/slide", 0.2, {"fingers.max_normal_force": [10, 4]}),
    ("paper/tumble", 0.5, {"fingers.count": 1}),
    ("paper/tumble", 0.5, {"fingers.count": 3, "fingers.placements.grid": [2, 2]}),
    ("paper/push", 0.5, {"fingers.count": 3, "fingers.placements.grid": [2, 2],
                         "friction.finger": [0.7, 0.7, 0.2]}),
)  # fmt: skip


@pytest.mark.parametrize(("name", "s", "changes"), CASES)
def test_every_set_decided_finds_the_same(
    name: str, s: float | None, changes: dict[str, Any]
) -> None:
    """By bounds and by brute force: the same margins, and a set that has each of them."""
    problem = api.load(name, {"fingers.placements.grid": [3, 3]} | changes).problem
    judge = Judge(problem, make_backend(problem))
    if s is None:
        moment = Moment(problem.motion.pose((0.5,)))
    else:
        moment = problem.motion.moment((s,), (1.0,))
    state, free = judge.environment(moment), np.array(judge.node(moment.pose).free)
    found = partners.best_partners(judge, state, free)
    every = partners._all_sets(judge, state, free)
    assert np.array_equal(np.isfinite(found.z), np.isfinite(every.z))
    reached = np.isfinite(found.z)
    assert reached.any() or not np.isfinite(every.z).any()
    assert found.z[reached] == pytest.approx(every.z[reached], rel=1e-6, abs=1e-6)
    assert found.undecided == every.undecided == 0
    everyone = tuple(range(problem.fingers.count))
    for i, row in np.argwhere(reached)[::7]:
        rows = tuple(found.sets[i, row].tolist())
        assert rows[i] == row and judge.apart(rows)
        decision = judge.backend.decide(state, everyone, rows)
        assert decision.z == pytest.approx(found.z[i, row], rel=1e-6, abs=1e-6)


def test_what_the_kernel_cannot_prove_is_decided_by_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sets that come back unproven go to the back end, and count where they hold."""
    problem = api.load("paper/slide", {"fingers.placements.grid": [2, 2]}).problem
    judge = Judge(problem, make_backend(problem))
    moment = problem.motion.moment((0.4,), (1.0,))
    state, free = judge.environment(moment), np.array(judge.node(moment.pose).free)
    right = partners.best_partners(judge, state, free)

    def lose(*given: Any) -> None:
        """Prove nothing."""
        ask, found = given[0], given[-1]
        for rows in partners._sets(judge, ask.allowed):
            found.lost[found.counts[1]] = rows
            found.counts[1] += 1

    monkeypatch.setattr(partners, "_work", lose)
    monkeypatch.setattr(partners, "_share", lambda *_: None)
    found = partners.best_partners(judge, state, free)
    assert found.z == pytest.approx(right.z, rel=1e-6)
    assert found.undecided == 0
