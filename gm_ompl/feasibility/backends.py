"""The one interface behind which a mode decision is made, and the back ends by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.contact.state import ContactState
from gm_ompl.errors import InputError, did_you_mean
from gm_ompl.motion.arc import Arc
from gm_ompl.problem import Placements, Problem


class Backend(Protocol):
    """Decides Sec. 3.4 for placements of one problem.

    Attributes:
        decisions: mode decisions computed so far; answers from the memo are not counted.
        fallbacks: those among them that another back end had to make.
        undecided: those among them that nobody could prove.
        optimistic: whether what nobody can prove counts as any z instead of none: for bounds.
    """

    decisions: int
    fallbacks: int
    undecided: int
    optimistic: bool

    def environment(self, contacts: ContactState) -> int:
        """Register a contact state; equal states get the same number."""

    def environments(self, arc: Arc, parts: int) -> list[int] | None:
        """Register the contact states in the middles of an arc's segments.

        None where the back end finds none by itself: then ``environment`` is to be told each.
        """

    def decide(
        self,
        environment: int,
        fingers: tuple[int, ...],
        placements: Placements,
        below: float = 0.0,
    ) -> ModeDecision:
        """Return the best modes for ``fingers`` at ``placements`` (same length).

        Where z is proven smaller than ``below``, the outcome may be BELOW with a bound on z.
        """

    def bound(self, environment: int, fingers: tuple[int, ...], placements: Placements) -> float:
        """Return an upper bound on z of ``decide``, cheaply; +inf where nothing is known.

        Bounds only fall as decisions are made.
        """

    def forget(self) -> None:
        """Empty every memo (for measurements)."""


def _kernel(problem: Problem) -> Backend:
    from gm_ompl.feasibility.kernel_backend import KernelBackend  # loads numba

    return KernelBackend(problem)


def _highs(problem: Problem) -> Backend:
    from gm_ompl.feasibility.reference_backend import ReferenceBackend  # loads HiGHS

    return ReferenceBackend(problem)


BACKENDS: dict[str, Callable[[Problem], Backend]] = {"kernel": _kernel, "highs": _highs}


def make_backend(problem: Problem) -> Backend:
    """Return the back end that ``problem.mechanics.backend`` names.

    Raises:
        InputError: there is none of that name.
    """
    name = problem.mechanics.backend
    if name not in BACKENDS:
        raise InputError(
            f"mechanics.backend: unknown back end {name!r}{did_you_mean(name, BACKENDS)}; "
            f"back ends are: {', '.join(BACKENDS)}"
        )
    return BACKENDS[name](problem)
