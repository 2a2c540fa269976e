"""Junctions of plans that were tampered with."""

from __future__ import annotations

import json
from typing import Any

import pytest

from gm_ompl.checking import check
from gm_ompl.checking.report import CheckReport
from gm_ompl.contact.junction import JunctionVerdict
from gm_ompl.planfile.model import Plan
from tests.check.tampering import Draft


def judged(draft: Draft) -> CheckReport:
    return check(Plan.model_validate_json(json.dumps(draft)))


def command(draft: Draft, modes: list[str], f_com: list[float | None]) -> None:
    """Control the second segment of the first arc otherwise than its neighbours."""
    draft["steps"][0]["segments"][1].update(modes=modes, f_com=f_com)


def blamed(report: CheckReport) -> list[tuple[int | None, int | None]]:
    return [(v.step, v.segment) for v in report.violations if v.topic == "junctions"]


def test_every_step_says_that_its_junctions_hold(draft: Draft) -> None:
    """Of the plan as it is, all do; the first step too, whose segments meet each other."""
    report = judged(draft)
    assert all("junctions" in step.checked for step in report.steps)
    assert report.holds and not any(note.startswith("junctions") for note in report.notes)


def test_a_broken_ramp_is_refused_with_its_place(draft: Draft) -> None:
    """Pushed with 10 and not pressed down the box of weight 9.8 runs away, even from rest."""
    command(draft, ["force", "force"], [0.0, 10.0])
    report = judged(draft)
    assert blamed(report) == [(0, 1), (0, 2)]
    message = next(v.message for v in report.violations if v.topic == "junctions")
    assert JunctionVerdict.FAILS.value in message and "states no failing" in message


@pytest.mark.parametrize(
    ("stated", "blames"), [(1, [(0, 2)]), (2, []), (None, []), ("many", [(0, 1), (0, 2)])]
)
def test_what_the_plan_states_is_noted(draft: Draft, stated: Any, blames: list[Any]) -> None:
    """So many failing junctions as the plan states are a note; a plan may not know the number."""
    command(draft, ["force", "force"], [0.0, 10.0])
    draft["statistics"]["failing_junctions"] = stated
    report = judged(draft)
    assert blamed(report) == blames
    noted = 2 - len(blames)
    assert any(n.startswith(f"junctions: {noted} where") for n in report.notes) == (noted > 0)


def test_a_ramp_that_holds_at_rest_is_noted(draft: Draft) -> None:
    """A push of 1 moves nothing: the box on its way would stop, one at rest stays."""
    command(draft, ["force", "force"], [10.0, 1.0])
    report = judged(draft)
    assert not blamed(report)
    assert any(
        JunctionVerdict.RESTS.value in note and "step 0, segment 1" in note for note in report.notes
    )


def test_around_a_regrasp_the_object_rests(draft: Draft) -> None:
    """Without any force at the rest the box stands by itself: no ramp to it or from it fails."""
    draft["steps"][2].update(modes=["force", None], f_com=[0.0, None])
    report = judged(draft)
    assert not blamed(report) and not any(n.startswith("junctions") for n in report.notes)


def test_what_cannot_be_read_has_no_junctions(draft: Draft) -> None:
    """A step whose lists do not fit is refused for that, and the next begins anew."""
    draft["steps"][0]["segments"][1]["modes"].pop()
    report = judged(draft)
    assert not blamed(report) and not report.holds
    assert "junctions" not in report.steps[0].checked
    assert "junctions" in report.steps[1].checked
