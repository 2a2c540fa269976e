"""Judges a plan's junctions: the ramps between segments, and before and after a lifted finger."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import NamedTuple

from gm_ompl.checking.recheck import Hold, Recheck
from gm_ompl.checking.report import Findings
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.junction import Control, Forces, JunctionVerdict, controls, junction, passage
from gm_ompl.contact.state import ContactState
from gm_ompl.errors import SolverError
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.planfile.model import DisplacementStep, RegraspStep, SegmentRecord
from gm_ompl.problem import Placements

NEEDED = {"coordinates", "placements", "segments", "lifted finger", "f_com", "continuity"}
"""Topics without which a step has no junctions to judge."""


class ClaimedStage(NamedTuple):
    """A segment, or a rest, as the plan claims it.

    Attributes:
        hand: what each finger does.
        rows: the placements of all fingers.
        first: the object where it begins.
        last: where it ends.
        segment: its number, None of a rest.
    """

    hand: tuple[Control, ...]
    rows: Placements
    first: Moment
    last: Moment
    segment: int | None


class Junctions:
    """Judges the junctions of a plan step by step.

    Args:
        recheck: what judges.
        stated: how many failing junctions the plan owns up to; None where it knows of no number.
    """

    def __init__(self, recheck: Recheck, stated: int | None) -> None:
        self._recheck, self._stated = recheck, stated
        self._last: ClaimedStage | None = None
        self._places: dict[JunctionVerdict, list[str]] = {
            passage: [] for passage in JunctionVerdict
        }

    def displacement(self, step: DisplacementStep, arc: Arc | None, found: Findings) -> None:
        """Judge the junctions on the way into and within a displacement along its arc."""
        stages = []
        if arc is not None and not _doubtful(found):
            moments = [arc.moment(t) for t in arc.bounds(len(step.segments))]
            stages = [
                ClaimedStage(_hand(segment), self._rows(step), moments[j], moments[j + 1], j)
                for j, segment in enumerate(step.segments)
            ]
        self._follow(stages, found)

    def regrasp(self, step: RegraspStep, pose: Pose | None, found: Findings) -> None:
        """Judge the junction on the way into a regrasp, the object at rest."""
        stages = []
        if pose is not None and not _doubtful(found):
            rest = Moment(pose)
            stages = [ClaimedStage(_hand(step), self._rows(step), rest, rest, None)]
        self._follow(stages, found)

    def _follow(self, stages: list[ClaimedStage], found: Findings) -> None:
        """Judge the junctions between stages, the last of the step before included."""
        before = [] if self._last is None or not stages else [self._last]
        for one, other in pairwise([*before, *stages]):
            found.check("junctions", True)  # where no command changes there is no ramp
            if one.hand != other.hand:
                self._judge(one, other, found)
        self._last = stages[-1] if stages else None

    def _rows(self, step: DisplacementStep | RegraspStep) -> Placements:
        table = self._recheck.problem.fingers.placements
        found = [record.row(table) for record in step.placements]
        return tuple(row for row in found if row is not None)

    def notes(self) -> Iterator[str]:
        """Yield what a reader should know of junctions that do not simply hold."""
        for verdict in (JunctionVerdict.RESTS, JunctionVerdict.FAILS):
            if self._places[verdict]:
                places = self._places[verdict]
                yield f"junctions: {len(places)} where {verdict.value}: {'; '.join(places)}"

    def _judge(self, before: ClaimedStage, after: ClaimedStage, found: Findings) -> None:
        verdict, doubt = JunctionVerdict.FAILS, ""
        try:
            verdict = self._passage(before, after)
        except SolverError as error:
            doubt = f" (undecided: {error})"
        place = f"step {found.step}" + (
            "" if after.segment is None else f", segment {after.segment}"
        )
        known = len(self._places[JunctionVerdict.FAILS])
        allowed = self._stated is None or known < self._stated
        if verdict is not JunctionVerdict.FAILS or allowed:
            self._places[verdict].append(f"before {place}")
        found.check(
            "junctions",
            verdict is not JunctionVerdict.FAILS or allowed,
            f"before it {verdict.value}{doubt}; the plan states {self._stated or 'no'} failing "
            "junctions",
            after.segment,
        )

    def _passage(self, before: ClaimedStage, after: ClaimedStage) -> JunctionVerdict:
        ramp, recheck = junction(before.hand, after.hand), self._recheck
        rows = tuple(
            (before if after.hand[i].mode is None else after).rows[i] for i in ramp.fingers
        )

        @cache
        def contacts_at(moment: Moment) -> ContactState:
            return recheck.contacts(moment)

        def balanced(moment: Moment, f_com: Forces) -> bool:
            contacts = contacts_at(moment)
            return recheck.balanced(Hold(contacts, ramp.fingers, rows, ramp.modes, f_com))

        return passage(ramp, before.last, after.first, balanced)


def _doubtful(found: Findings) -> bool:
    """Whether a step's claims allow no judgement of its junctions."""
    return any(violation.topic in NEEDED for violation in found.violations)


def _hand(record: SegmentRecord | RegraspStep) -> tuple[Control, ...]:
    touching = [i for i, mode in enumerate(record.modes) if mode is not None]
    modes = [ControlMode(record.modes[i]) for i in touching]
    f_com = tuple(record.f_com[i] for i in touching)
    return controls(modes, f_com, touching, len(record.modes))
