"""What an explanation says, as values: they become JSON or lines of text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gm_ompl.diagnosis.free_values import Explored, Place
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.writing import plain


@dataclass(frozen=True)
class ModeLine:
    """One combination of modes at an instant.

    Attributes:
        modes: per finger that touches.
        internal_force: whether Problem (5) rules it out.
        z: its margin with the best f_com; None where it is ruled out or not in equilibrium.
        f_com: per finger, None under position control; empty where ``z`` is None.
    """

    modes: tuple[str, ...]
    internal_force: bool
    z: float | None
    f_com: tuple[float | None, ...]


@dataclass(frozen=True)
class InstantLine:
    """One instant for one set of placements.

    Attributes:
        q: object coordinates.
        direction: of the object's motion; None at rest.
        finding: what blocks it, or that it holds.
        blocked_by: what penetrates what.
        z: the best margin; None where geometry, Problem (5) or equilibrium fails.
        ratio: z / z_min; 0 without equilibrium, None where it is not known or z_min is 0.
        limit: in words, the disturbance that limits z.
        gives_way: what every contact does under the least disturbance that is not strongly held,
            where z_strong counts and is less than z.
        modes: every combination of modes, where geometry holds.
        place: with free motion, where the object is.
        moving: with free motion, what it does there, in words; None at rest.
    """

    q: tuple[float, ...]
    direction: tuple[float, ...] | None
    finding: Finding
    blocked_by: tuple[str, ...] = ()
    z: float | None = None
    ratio: float | None = None
    limit: str | None = None
    gives_way: tuple[str, ...] = ()
    modes: tuple[ModeLine, ...] = ()
    place: Place | None = None
    moving: str | None = None


@dataclass(frozen=True)
class Stretch:
    """Part of a path along which one finding blocks a set of placements.

    Attributes:
        first: least coordinate judged there.
        last: greatest coordinate judged there.
        finding: what blocks it.
        blocked_by: what penetrates what.
        ratio: least z / z_min.
    """

    first: float
    last: float
    finding: Finding
    blocked_by: tuple[str, ...]
    ratio: float | None


@dataclass(frozen=True)
class SetLine:
    """One set of placements along the whole motion.

    Attributes:
        placements: per finger, "FACE:[i, j]".
        holds: whether it holds from start to goal.
        forward: the first instant that fails from the start on; None where none does.
        backward: the first that fails coming back from the goal; None where none does.
        stretches: all that fails along a path; empty in the plane.
        ratio: least z / z_min where geometry holds; None where nothing was judged.
        nodes_from_start: without a path, nodes reached from the start without regrasping.
        nodes_to_goal: without a path, nodes from which the goal is reached without regrasping.
        cut_short: without a path, whether there may be more nodes: ``holds`` is not settled then.
    """

    placements: tuple[str, ...]
    holds: bool
    forward: InstantLine | None
    backward: InstantLine | None
    stretches: tuple[Stretch, ...] = ()
    ratio: float | None = None
    nodes_from_start: int | None = None
    nodes_to_goal: int | None = None
    cut_short: bool = False


@dataclass(frozen=True)
class FacesLine:
    """All judged sets on the same faces.

    Attributes:
        faces: of the fingers, in order.
        sets: how many were judged.
        holding: how many hold.
        findings: how many each finding blocks first.
        ratio: largest z / z_min where they are blocked.
    """

    faces: tuple[str, ...]
    sets: int
    holding: int
    findings: dict[str, int]
    ratio: float | None


@dataclass(frozen=True)
class Survey:
    """Many sets of placements, judged from one end of the motion, or at one instant.

    Attributes:
        where: "start", "goal" or "at".
        possible: sets whose fingertips do not penetrate anything there; None if too many to count.
        judged: how many of them were judged.
        sampled: whether that is a random sample.
        holding: how many hold.
        findings: how many each finding blocks first.
        faces: the same by faces.
        closest: those that came furthest, best first.
    """

    where: str
    possible: int | None
    judged: int
    sampled: bool
    holding: int
    findings: dict[str, int]
    faces: tuple[FacesLine, ...]
    closest: tuple[SetLine, ...]


@dataclass(frozen=True)
class Remedy:
    """A change of the scenario that was tried.

    Attributes:
        change: as for ``--set``.
        helps: whether it was verified to help.
        evidence: how.
    """

    change: str
    helps: bool
    evidence: str


@dataclass(frozen=True)
class Attempt:
    """A search that is not bound to the scenario's lattice, or not to its ranges.

    Attributes:
        kind: "sampler", "finer lattice" or "no uncertainty".
        status: how it ended, as in plan files.
        sentence: what follows from that.
        change: of the scenario, as for ``--set``; None where it is as it was.
    """

    kind: str
    status: str
    sentence: str
    change: str | None = None


@dataclass(frozen=True)
class ContactLine:
    """A contact of the object with its environment at one instant.

    Attributes:
        against: what it touches.
        point: world frame.
        normal: unit, world frame, pointing into the object.
        motion: per direction of motion ("+s", "-yaw", "rest"): "sticks", "slides" or "separates".
    """

    against: str
    point: tuple[float, ...]
    normal: tuple[float, ...]
    motion: dict[str, str]


@dataclass(frozen=True)
class Explanation:
    """Why there is no plan, or none through there.

    Attributes:
        scenario: its name.
        z_min: the threshold.
        verdict: one sentence.
        search: how a search of limited time on the lattice ended; None where none was asked.
        attempts: what a sampler and a finer lattice found, where the search found no plan.
        contacts: the object's with its environment at the given coordinates.
        instants: the given placements at the given coordinates.
        placements: the given placements along the motion.
        surveys: over many sets, where no placements were given.
        explored: with free motion, what the object reaches by itself and held by fingers.
        remedies: what was tried.
    """

    scenario: str
    z_min: float
    verdict: str
    search: str | None = None
    attempts: tuple[Attempt, ...] = ()
    contacts: tuple[ContactLine, ...] = ()
    instants: tuple[InstantLine, ...] = ()
    placements: SetLine | None = None
    surveys: tuple[Survey, ...] = ()
    explored: tuple[Explored, ...] = ()
    remedies: tuple[Remedy, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return plain lists, mappings, numbers and text, no infinity among them."""
        tree: dict[str, Any] = plain(self)
        return tree
