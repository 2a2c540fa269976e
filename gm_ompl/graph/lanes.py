"""The manipulation-feasibility graph of one degree of freedom, as lanes joined by hubs.

With one coordinate a set of placements is a line of nodes, and the rest of its path is known. A
hub (one finger lifted, the object at rest) joins the lanes that share the other placements.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.cost import chords
from gm_ompl.graph.goals import GoalNodes
from gm_ompl.graph.lane_bounds import UNASKED, LaneTables
from gm_ompl.graph.watch import Stop, watched
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Problem


def lane_tables(problem: Problem, judge: Judge, backend: KernelBackend, stop: Stop) -> LaneTables:
    """Return what all lanes of a problem of one coordinate share, geometry tested throughout.

    Raises:
        Stopped: ``stop`` said so.
    """
    lattice, P = problem.lattice, problem.cost.samples_per_arc
    nodes = [lattice.coordinates(c) for c in range(lattice.size)]
    N = len(nodes) - 1
    arcs = list(itertools.pairwise(nodes))
    middles = [_middles(a, b, P) for a, b in arcs]
    node_free = _free(judge, [[q] for q in nodes], stop)
    free = _free(judge, middles, stop) & node_free[:, :, :-1] & node_free[:, :, 1:]
    lengths = _lengths(problem, judge)
    goals = GoalNodes(problem)
    goal = np.zeros(N + 1, dtype=bool)
    goal[list(goals.nodes)] = True
    forward = np.array(
        [
            [judge.environment(q, (b[0] - a[0],)) for q in row]
            for row, (a, b) in watched(zip(middles, arcs, strict=True), stop)
        ],
        dtype=np.int64,
    ).reshape(N, P)
    travel = lengths.sum(axis=3)
    # Each arc by whatever placement is shortest there: a plan that regrasps again may change.
    shortest = np.where(free, travel, np.inf).min(axis=1, keepdims=True, initial=np.inf)
    least = _ahead(shortest, np.isfinite(shortest), goal)[:, 0].max(axis=0)
    tables = LaneTables(
        forward=forward,
        backward=np.full((N, P), UNASKED),
        lengths=lengths,
        free=free,
        node_free=node_free,
        goal=goal,
        wanted=np.array([-1 if g is None else g for g in problem.fingers.goal], dtype=np.int64),
        ahead=_ahead(travel, free, goal),
        least=least,
        z_min=problem.mechanics.z_min / backend.scale,
        X_stab=problem.cost.stability / backend.scale,
        X_regr=float(problem.cost.regrasp),
    )
    backend.pool.reserve(1 + int(forward.max(initial=0)))
    return tables


def ask_backward(tables: LaneTables, problem: Problem, judge: Judge, span: slice) -> int:
    """Find contact states of backward arcs, which most searches hardly need; return of how many."""
    backward, P = tables.backward, problem.cost.samples_per_arc
    unasked = [i for i in range(span.start, span.stop) if backward[i, 0] == UNASKED]
    for i in unasked:
        tail, head = problem.lattice.coordinates(i + 1), problem.lattice.coordinates(i)
        direction = (head[0] - tail[0],)
        backward[i] = [judge.environment(q, direction) for q in _middles(head, tail, P)]
    return len(unasked)


def _middles(a: Coordinates, b: Coordinates, P: int) -> list[Coordinates]:
    """Return the midpoints of the P segments from node ``a`` to the next."""
    return [(a[0] + (j + 0.5) / P * (b[0] - a[0]),) for j in range(P)]


def _free(judge: Judge, places: Sequence[Sequence[Coordinates]], stop: Stop) -> BoolArray:
    """Return (n, placements, len(places)): free at all coordinates of each place."""
    columns = []
    for place in watched(places, stop):
        at = [judge.node(q) for q in place]
        columns.append(np.stack([np.stack(node.free) for node in at]).all(axis=0))
    if not columns:
        n, rows = judge.problem.fingers.count, len(judge.problem.fingers.placements)
        return np.zeros((n, rows, 0), dtype=bool)
    return np.ascontiguousarray(np.stack(columns, axis=2))


def _lengths(problem: Problem, judge: Judge) -> Array:
    """Return the chords (n, placements, N, P) of Eq. (9)."""
    lattice, P = problem.lattice, problem.cost.samples_per_arc
    axis = lattice.axes[0]
    ends = [(float(axis[0]),)]
    for a, b in itertools.pairwise(axis):
        ends.extend((float(a + (b - a) * j / P),) for j in range(1, P))
        ends.append((float(b),))
    poses = [problem.motion.pose(q) for q in ends]
    N = len(axis) - 1
    known: dict[float, Array] = {}
    for i, radius in enumerate(problem.fingers.radius.tolist()):
        if radius not in known:
            known[radius] = chords(poses, judge.centres(i)).T.reshape(-1, N, P)
    return np.ascontiguousarray(np.stack([known[r] for r in problem.fingers.radius.tolist()]))


def _ahead(travel: Array, free: BoolArray, goal: BoolArray) -> Array:
    """Return (n, placements, N + 1): travel to the nearest goal node; +inf where blocked."""
    n, rows, N = travel.shape
    cost = np.where(free, travel, np.inf)
    ahead = np.full((n, rows, N + 1), np.inf)
    run = np.full((n, rows), np.inf)
    for c in range(N, -1, -1):
        run = np.zeros((n, rows)) if goal[c] else (run + cost[:, :, c] if c < N else run)
        ahead[:, :, c] = run
    run = np.full((n, rows), np.inf)
    for c in range(N + 1):
        run = np.zeros((n, rows)) if goal[c] else (run + cost[:, :, c - 1] if c else run)
        ahead[:, :, c] = np.minimum(ahead[:, :, c], run)
    return ahead
