"""The back ends by name."""

from __future__ import annotations

from collections.abc import Callable

from gm_ompl.errors import InputError, did_you_mean
from gm_ompl.feasibility.backend import Backend
from gm_ompl.problem import Problem


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
