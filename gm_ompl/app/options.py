"""How a verb's options, fields of a dataclass, become a command."""

from __future__ import annotations

import importlib
import inspect
import math
from collections.abc import Callable
from dataclasses import MISSING, field, fields
from typing import Annotated, Any, get_type_hints

import typer

from gm_ompl.app.exits import Exit, guarded
from gm_ompl.errors import InputError


def option(default: Any, text: str, metavar: str | None = None, *names: str, **more: Any) -> Any:
    """Return a field that is an option: with its default, ``...`` for none, and its help.

    Its value is called ``metavar``; ``names`` are others than the field's.
    """
    return _field(default, typer.Option(*names, metavar=metavar, help=text, **more))


def argument(text: str, metavar: str) -> Any:
    """Return a field that is an argument, with its help and what it is called."""
    return _field(..., typer.Argument(metavar=metavar, help=text))


def _field(default: Any, info: Any) -> Any:
    return field(default=MISSING if default is ... else default, metadata={"typer": info})


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
        options: a dataclass of ``option`` and ``argument``.
        handler: "MODULE:FUNCTION" in this folder, which takes the options and returns the exit
            code. It is imported when the verb runs, so that ``--help`` answers at once.
    """
    module, _, name = handler.partition(":")

    def run(**given: Any) -> Exit:
        found: Callable[[Any], Exit] = getattr(importlib.import_module(module, __package__), name)
        return found(options(**given))

    types = get_type_hints(options)
    hints = {f.name: Annotated[types[f.name], f.metadata["typer"]] for f in fields(options)}
    empty, kind = inspect.Parameter.empty, inspect.Parameter.KEYWORD_ONLY
    parameters = []
    for one in fields(options):
        default = empty if one.default is MISSING else one.default
        parameters.append(
            inspect.Parameter(one.name, kind, annotation=hints[one.name], default=default)
        )
    made = guarded(run)
    made.__doc__, made.__annotations__ = options.__doc__, hints
    made.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return made
