"""The contact lattice's arcs, many nodes at once: the same as one by one, in any portions."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest

from gm_ompl import cores
from gm_ompl.arrays import Array
from gm_ompl.contact import lattice
from gm_ompl.contact.lattice import ContactLattice
from gm_ompl.contact.numbered_arcs import NumberedArcs
from gm_ompl.graph.kept_chords import chords, lines
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load

NODES = 200
SCENARIOS = (
    ("tasks/ledge", ()),
    ("free/l-bracket", ()),  # pieces that touch one body: contacts are found by plain code
    ("tasks/flip-cube", ("cost.samples_at=ends",)),
    ("tasks/corner-pivot", ("lattice.depth=6",)),
    ("free/out-of-the-corner", ()),
    ("random/free-clutter/5", ()),
)
each = pytest.mark.parametrize(("name", "changes"), SCENARIOS)


def _lattice(name: str, changes: tuple[str, ...]) -> tuple[Problem, ContactLattice]:
    problem = load(name, changes).problem
    found = problem.object_graph
    assert isinstance(found, ContactLattice)
    return problem, found


def _grown(graph: ContactLattice, at_once: int) -> list[tuple[Array, ...]]:
    """Leave nodes in the order in which they are found; return all arcs by poses and cuts."""
    left, rows = 0, list[tuple[Array, ...]]()
    while left < min(NODES, len(graph)):
        nodes = list(range(left, min(left + at_once, len(graph), NODES)))
        graph.leave(nodes)
        left = nodes[-1] + 1
    for node in range(left):
        for arc in graph.arcs_from(node):
            ends, middle = (graph.pose(node), graph.pose(arc.head)), arc.arc.pose(0.4)
            cut = np.array([arc.parts, arc.bare, arc.kind is None])
            poses = [np.append(pose.position, pose.rotation) for pose in (*ends, middle)]
            rows.append((*poses, cut))
    return rows


@each
def test_many_at_once_are_as_one_by_one(name: str, changes: tuple[str, ...]) -> None:
    """Arcs from many nodes at once are those that leave each; numbers alone may differ."""
    whole = (*changes, "lattice.depth=3")
    rows = [_grown(_lattice(name, whole)[1], at_once) for at_once in (1, NODES)]
    one, many = (
        Counter(tuple(np.round(np.concatenate(row), 6) + 0.0) for row in found) for found in rows
    )
    assert one == many
    assert len(one) > 10


@each
def test_room_and_cores_change_nothing(
    name: str, changes: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Room that must grow and the number of threads leave every number as it was."""
    before = _grown(_lattice(name, changes)[1], NODES)
    monkeypatch.setattr(lattice, "MOTIONS", 1)
    monkeypatch.setattr(lattice, "CONTACTS", 1)
    monkeypatch.setattr(lattice, "A_FEW", 1)
    monkeypatch.setattr(lattice, "AT_ONCE", 7)
    monkeypatch.setattr(cores, "cores", lambda: 3)
    after = _grown(_lattice(name, changes)[1], NODES)
    assert len(before) == len(after)
    for one, other in zip(before, after, strict=True):
        assert all((a == b).all() for a, b in zip(one, other, strict=True))


@each
def test_distances_times_chords_are_lengths(name: str, changes: tuple[str, ...]) -> None:
    """|dq_finger i,j| of Eq. (9) by many arcs at once is what each arc says."""
    problem, graph = _lattice(name, changes)
    graph.leave([0])
    graph.leave(list(range(min(20, len(graph)))))
    which, parts = np.arange(len(graph.arcs)), problem.cost.samples_per_arc
    tips = problem.fingers.placements.centres(float(problem.fingers.radius[0]))
    courses = graph.courses(which)
    own, long = lines(courses), chords(courses, parts, ends=problem.motion.ends)
    arms = np.linalg.norm(np.cross(tips - own[:, :1], own[:, 1:]), axis=2)
    far = np.where(own[:, 1:].any(axis=2), arms, 1.0)
    for k in which.tolist():
        arc = graph.arc(k)
        expected = arc.lengths(tips)
        found = far[k][:, None] * long[k]
        assert np.abs(found[:, : arc.parts] - expected).max() <= 1e-12 * problem.body.diagonal
        assert not long[k, arc.parts :].any()


def test_depth_ends_all() -> None:
    """Nothing leaves a node that is as deep as nodes may be, however it is asked."""
    _, graph = _lattice("tasks/corner-pivot", ("lattice.depth=2",))
    everyone = list(range(len(graph)))
    for _ in range(4):
        graph.leave(everyone)
        everyone = list(range(len(graph)))
    first, past = graph.spans(np.array(everyone))
    deep = [node for node in everyone if not graph.arcs_from(node)]
    assert deep
    assert (first[deep] == past[deep]).all()
    assert len(graph) == len(everyone)


@pytest.mark.parametrize("where", ["_formed", "_kinded", "_append", "_rows"])
def test_what_ctrl_c_breaks_off_is_made_anew(where: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever it comes, the arcs that are made later are those that would have been made."""
    name, changes = "tasks/ledge", ("lattice.depth=4",)
    whole, (_, graph) = _grown(_lattice(name, changes)[1], 8), _lattice(name, changes)
    kept, calls = getattr(NumberedArcs, where), iter(range(10_000))

    def broken(*given: Any) -> Any:
        done = kept(*given)
        if next(calls) % 3 == 1:
            raise KeyboardInterrupt
        return done

    monkeypatch.setattr(NumberedArcs, where, broken)
    left, breaks = 0, 0
    while left < min(NODES, len(graph)):
        nodes = list(range(left, min(left + 8, len(graph), NODES)))
        try:
            graph.leave(nodes)
            left = nodes[-1] + 1
        except KeyboardInterrupt:
            breaks += 1
    monkeypatch.undo()
    after = _grown(graph, 8)
    assert breaks > 3
    assert len(graph.arcs) >= len(after) == len(whole)
    for k in range(len(graph.arcs.form_arcs)):
        assert graph.arcs.rows.forms[graph.arcs.form_arcs[k]] == k
    for one, other in zip(after, whole, strict=True):
        assert all((a == b).all() for a, b in zip(one, other, strict=True))
