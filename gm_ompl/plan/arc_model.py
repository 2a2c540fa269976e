"""How a plan file states an arc: one key, which says its kind."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import AfterValidator, Discriminator, Field, Tag

from gm_ompl.plan.record import Record, Vector, not_zero


class TranslationArc(Record):
    """The object moves without turning.

    Attributes:
        translation: the whole way, world frame.
    """

    translation: Vector


class Turn(Record):
    """A turn about a line fixed in the world.

    Attributes:
        point: of the line.
        axis: unit, the line's direction.
        angle: the whole turn about ``axis`` [rad].
    """

    point: Vector
    axis: Annotated[Vector, AfterValidator(not_zero)]
    angle: float


class RotationArc(Record):
    """The object turns about a line.

    Attributes:
        rotation: the turn.
    """

    rotation: Turn


class Line(Record):
    """A straight line in x, y and yaw [rad].

    Attributes:
        from_: where it begins (``from`` in the file).
        to: where it ends.
    """

    from_: Vector = Field(validation_alias="from", serialization_alias="from")
    to: Vector


class StraightArc(Record):
    """Position in the plane and yaw change linearly at once.

    Attributes:
        straight: from where to where.
    """

    straight: Line


KINDS = ("translation", "rotation", "straight")


def _kind(value: Any) -> str | None:
    """Return the tag of an arc's kind; tags must not look like keys of the file."""
    for kind in KINDS:
        if kind in value if isinstance(value, dict) else hasattr(value, kind):
            return f"arc: {kind}"
    return None


ArcRecord: TypeAlias = Annotated[
    Annotated[TranslationArc, Tag("arc: translation")]
    | Annotated[RotationArc, Tag("arc: rotation")]
    | Annotated[StraightArc, Tag("arc: straight")],
    Discriminator(
        _kind,
        custom_error_type="arc_kind",
        custom_error_message="must have one of the keys " + ", ".join(KINDS),
    ),
]
"""One arc: exactly one kind."""
