"""Trials of f_com, compiled: tableaus to make them on, and how far each is taken."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.kelley import GAP, Cuts, ModeSets, force_control
from gm_ompl.mechanics.program import Program
from gm_ompl.mechanics.simplex import Target
from gm_ompl.mechanics.stability import run_pass
from gm_ompl.mechanics.tableau import NEVER
from gm_ompl.mechanics.tau import UNUSED, Tableau, Work, fill, taken

FRESH = 8
"""Passes on one tableau before it is filled anew: rounding adds up with every pivot."""
FIRST_LOOK = 12
"""Pivots at a trial f_com while nothing bounds z."""


@inlined
def plant(seed: Tableau, masks: IntArray, work: Work) -> None:
    """Begin every set of modes at the basis of position control of all fingers.

    A force-controlled finger has no slack. What its slack has in the tableau is also the artificial
    variable's of its row, which takes its place in the basis; so all reduced costs stay >= 0.
    """
    m, N = seed.raw.shape
    n, W = m - 6, len(seed.d)
    for j in range(len(masks)):
        basis = work.basis[j]
        basis[0] = UNUSED
        if seed.basis[0] == UNUSED:
            continue
        for r in range(m):
            old, new = seed.T[r], work.T[j, r]
            for k in range(W):
                new[k] = old[k]
            basis[r], work.tau[j, r] = seed.basis[r], seed.raw[r, 0]
        costs = work.d[j]
        for k in range(W):
            costs[k] = seed.d[k]
        for i in range(n):
            slack = N - n + i
            if (masks[j] >> i) & 1:
                continue
            costs[slack] = 0.0
            for r in range(m):
                work.T[j, r, slack] = 0.0
                if basis[r] == slack:
                    basis[r] = N + 6 + i


@compiled
def take_up(j: int, most: Array, sets: ModeSets, cuts: Cuts, force: BoolArray, caps: Array) -> int:
    """Write set j's modes, trial f_com and its limits; return how many are force-controlled."""
    force_control(sets.masks[j], force)
    nf = 0
    for i in range(len(force)):
        if force[i]:
            caps[nf] = most[i]
            sets.commands[j, i] = cuts.trials[j, nf]
            nf += 1
    return nf


@inlined
def aim_at(bound: float) -> Target:
    """Return where a pass at a trial f_com may stop: z reaches its bound, or a direction is worse.

    While nothing bounds z a look at the directions will do.
    """
    aim = bound - GAP * max(bound, 1e-3) if bound < np.inf else 0.0
    limit, enough = (1.0 / aim, 1.0 / aim) if aim > 0.0 else (np.inf, 0.0)
    return Target(limit, enough, NEVER if bound < np.inf else FIRST_LOOK)


@inlined
def try_command(
    program: Program, force: BoolArray, j: int, commands: Array, cuts: Cuts, work: Work
) -> int:
    """Try set j's f_com: SOLVED where z is proven to reach its bound, else ``work.y`` proves less.

    ``commands`` (n,) hold it.
    """
    tried = cuts.passes[j]
    cuts.passes[j] += 1
    cost = fill(program, force, commands, work.raw)
    tableau = taken(work, j)
    warm = tried % FRESH > 0 or (tried == 0 and tableau.basis[0] != UNUSED)
    end, _, _, cuts.held[j] = run_pass(
        tableau, cost, program.L, work.change, warm, aim_at(cuts.bounds[j])
    )
    return end
