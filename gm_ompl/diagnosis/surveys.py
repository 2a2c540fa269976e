"""Many sets of placements at once: what blocks how many of them, and which came furthest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from gm_ompl.arrays import BoolArray
from gm_ompl.diagnosis.values import FacesLine, SetLine, Survey
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.geometry.pose import Pose
from gm_ompl.holds.goals import restricted
from gm_ompl.holds.sets import PlacementSets, placement_sets
from gm_ompl.problem import Placements, Problem

_Part = TypeVar("_Part")

COUNTED = 300_000
"""Sets at one configuration that are all listed; of larger hands' sets some are drawn."""

CLOSEST = 3
"""Sets shown one by one."""

Scored = tuple[Placements, Finding | None, float | None, float]
"""A set, what blocks it first (None where nothing does), z / z_min there, how far it came."""


def known(parts: Iterable[_Part]) -> Iterator[_Part]:
    """Yield the parts that are found before a limit in force is reached."""
    try:
        yield from parts
    except LimitError:
        return


def sets_at(
    problem: Problem,
    judge: Judge,
    pose: Pose,
    required: tuple[int | None, ...],
    samples: int,
    rng: np.random.Generator,
) -> tuple[list[Placements], int | None]:
    """Return at most ``samples`` sets valid at ``pose``, and how many there are (None: unknown).

    They come in random order, so that the first of them are a sample, too.
    """
    geometry = judge.node(pose)
    if not geometry.object_free:
        return [], 0
    allowed = restricted(geometry.free, required)
    listed = placement_sets(problem.fingers.groups(), allowed, judge.clear, COUNTED)
    if listed is None:
        return _drawn(problem, judge, allowed, samples, rng), None
    if len(listed) > samples:
        listed, count = listed[rng.choice(len(listed), samples, replace=False)], len(listed)
    else:
        listed, count = listed[rng.permutation(len(listed))], len(listed)
    return [tuple(row) for row in listed.tolist()], count


def _drawn(
    problem: Problem,
    judge: Judge,
    allowed: tuple[BoolArray, ...],
    samples: int,
    rng: np.random.Generator,
) -> list[Placements]:
    """Return different random sets, drawn finger by finger."""
    canonical = PlacementSets(problem.fingers.groups()).canonical
    rows = [np.flatnonzero(mask) for mask in allowed]
    found: dict[Placements, None] = {}
    if not all(len(choices) for choices in rows):
        return []
    for _ in range(50 * samples):
        drawn = tuple(int(rng.choice(choices)) for choices in rows)
        if judge.apart(drawn):
            found[canonical(drawn)] = None
        if len(found) == samples:
            break
    return list(found)


def survey(
    problem: Problem,
    where: str,
    possible: int | None,
    scored: Sequence[Scored],
    describe: Callable[[Placements], SetLine],
    stop: Callable[[], bool],
) -> Survey:
    """Return the counts of judged sets and a description of those that came furthest.

    Args:
        problem: the problem.
        where: "start", "goal" or "at".
        possible: how many sets there are; None if too many to count.
        scored: those that were judged.
        describe: describes one in full.
        stop: asked before each description but the first.
    """
    table = problem.fingers.placements
    by_faces: dict[tuple[str, ...], list[Scored]] = {}
    for entry in scored:
        labels = (table.labels[int(table.face[row])] for row in entry[0])
        by_faces.setdefault(tuple(sorted(labels)), []).append(entry)
    faces = [
        FacesLine(
            faces=key,
            sets=len(group),
            holding=sum(finding is None for _, finding, _, _ in group),
            findings=_counts(group),
            ratio=max((r for _, _, r, _ in group if r is not None), default=None),
        )
        for key, group in by_faces.items()
    ]
    faces.sort(key=lambda line: (-line.holding, -(line.ratio or 0.0), line.faces))
    nearest = sorted(scored, key=lambda entry: (-entry[3], -(entry[2] or 0.0), entry[0]))
    closest = _described([placements for placements, *_ in nearest[:CLOSEST]], describe, stop)
    return Survey(
        where=where,
        possible=possible,
        judged=len(scored),
        sampled=possible is None or possible > len(scored),
        holding=sum(finding is None for _, finding, _, _ in scored),
        findings=_counts(scored),
        faces=tuple(faces),
        closest=tuple(closest),
    )


def _described(
    nearest: Sequence[Placements],
    describe: Callable[[Placements], SetLine],
    stop: Callable[[], bool],
) -> list[SetLine]:
    """Return as many descriptions as there is time for."""
    closest: list[SetLine] = []
    for placements in nearest:
        if closest and stop():
            break
        try:
            closest.append(describe(placements))
        except LimitError:
            break
    return closest


def _counts(scored: Sequence[Scored]) -> dict[str, int]:
    counts = Counter(finding.name.lower() for _, finding, _, _ in scored if finding is not None)
    return dict(counts.most_common())
