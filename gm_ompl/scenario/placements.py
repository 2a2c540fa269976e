"""Where fingers may be placed, as a scenario states it."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from gm_ompl.scenario.fields import NotNegative, Share, Strict, Text, Whole, WordOr, said

MAX_COUNT = 1_000_000
"""No lattice axis and no grid side is longer than this."""

Count: TypeAlias = Annotated[Whole, Field(ge=1, le=MAX_COUNT)]

FaceName: TypeAlias = WordOr[Text, Whole]


class Placed(Strict):
    """One fingertip placement."""

    face: FaceName = said("its name or number")
    cell: Annotated[
        tuple[Annotated[Whole, Field(ge=0)], ...], Field(min_length=2, max_length=2)
    ] = said("of the grid on the face, counted from 0")


Hand: TypeAlias = WordOr[Literal["any"], tuple[WordOr[Literal["any"], Placed], ...]]


class ContinuousModel(Strict):
    """Placements anywhere on the faces."""

    margin: NotNegative = said("least distance from a face's rim")
    gap: Share = said("a plan so near the best of all, for example 0.1%, ends the search", 0.001)


class PlacementsModel(Strict):
    """The grid of placements on the object's faces."""

    grid: Annotated[tuple[Count, ...], Field(min_length=2, max_length=2)] = said(
        "cells along the face's two axes; a placement in the middle of each", (7, 7)
    )
    faces: WordOr[Literal["all"], Annotated[tuple[FaceName, ...], Field(min_length=1)]] = said(
        "their names: +x, -x, ... of a box, else numbers", "all"
    )
    margin: NotNegative | None = said("least distance from a face's rim", None)
    smallest_face: Annotated[NotNegative, Field(lt=1)] | None = Field(
        default=None,
        description="faces with less than this part of the surface get no placements",
    )
    continuous: ContinuousModel | None = said("fingers anywhere, not on the grid alone", None)
