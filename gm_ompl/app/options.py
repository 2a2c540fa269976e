"""How a verb's options, fields of a dataclass, become a command."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import math
from collections.abc import Callable
from typing import Any, get_type_hints

import typer

from gm_ompl.app.exits import Exit, guarded
from gm_ompl.errors import InputError


def option(text: str, metavar: str | None = None, *names: str, **more: Any) -> Any:
    """Return an option for typer: its help, what its value is called, other names than its own."""
    return typer.Option(*names, metavar=metavar, help=text, **more)


def argument(text: str, metavar: str) -> Any:
    """Return an argument for typer: its help and what it is called."""
    return typer.Argument(metavar=metavar, help=text)


def require(holds: bool, option: str, value: object, wanted: str) -> None:
    """Refuse an option's value.

    Raises:
        InputError: it does not hold; the message names option, value and what would be right.
    """
    if not holds:
        raise InputError(f"{option} {value}: must be {wanted}")


def require_positive(**limits: float | None) -> None:
    """Refuse limits that are given and are not positive numbers; named as the options are."""
    for name, value in limits.items():
        holds = value is None or (math.isfinite(value) and value > 0)
        require(holds, f"--{name.replace('_', '-')}", value, "a positive number")


def command(options: type[Any], handler: str) -> Callable[..., None]:
    """Return a verb for typer: its parameters and its help are those of ``options``.

    Args:
        options: a dataclass, its fields annotated for typer.
        handler: "MODULE:FUNCTION" in this folder, which takes the options and returns the exit
            code. It is imported when the verb runs, so that ``--help`` answers at once.
    """
    module, _, name = handler.partition(":")

    def run(**given: Any) -> Exit:
        found: Callable[[Any], Exit] = getattr(importlib.import_module(module, __package__), name)
        return found(options(**given))

    hints = get_type_hints(options, include_extras=True)
    parameters = [
        inspect.Parameter(
            field.name,
            inspect.Parameter.KEYWORD_ONLY,
            annotation=hints[field.name],
            default=inspect.Parameter.empty
            if field.default is dataclasses.MISSING
            else field.default,
        )
        for field in dataclasses.fields(options)
    ]
    made = guarded(run)
    made.__doc__, made.__annotations__ = options.__doc__, hints
    made.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return made
