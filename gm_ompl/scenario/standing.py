"""Where the object stands: heights found, contacts made exact, and what looks like a mistake."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import Environment, environment_contacts
from gm_ompl.contact.projection import ANY_WAY, projected
from gm_ompl.errors import GeometryError, ScenarioWarning
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import PlacedPiece, Support, below, gap, lowered, supports
from gm_ompl.geometry.solids import Body
from gm_ompl.scenario.document import Document, Path, dotted

FLOATS = 1e-3
"""An object less than this, relative to D, above something was perhaps meant to stand on it."""


@dataclass(frozen=True, eq=False)
class Ground:
    """The object and what it can stand on.

    Attributes:
        body: the object, object frame.
        environment: floor and obstacles.
        spread: (3, 3), J / M about the centre of mass, object frame.
        gravity: g.
        document: where the values stand.
        warnings: what looks like a mistake; grows.
    """

    body: Body
    environment: Environment
    spread: Array
    gravity: float
    document: Document
    warnings: list[ScenarioWarning] = field(default_factory=list)

    def height(self, rotation: Array, xy: tuple[float, float]) -> float:
        """Return the height of the centre of mass at which the object, lowered there, stands.

        Raises:
            GeometryError: it would fall for ever.
        """
        pose = Pose(rotation, np.array([*xy, 0.0]))
        rise = lowered(self._supports(pose), self.body.diagonal)
        if rise is None:
            raise GeometryError(
                "rest: neither floor nor obstacle lies below the object there; give its height"
            )
        return rise

    def exact(self, pose: Pose, ways: Array = ANY_WAY) -> Pose:
        """Return ``pose`` with the contacts that it has within the tolerance made exact."""
        return projected(self.body, self.environment, pose, self.spread, ways)

    def look(self, name: str, path: Path, pose: Pose, held: bool = False) -> None:
        """Keep a warning where the object at ``pose`` floats, or touches nothing.

        Args:
            name: what is looked at, "start" or "goal".
            path: where it stands in the scenario.
            pose: where the object is.
            held: that it touches nothing is no mistake: fingers hold it there.
        """
        if self.gravity == 0.0:
            return
        D = self.body.diagonal
        touching, under = (
            environment_contacts(self.body, self.environment, pose),
            below(self._supports(pose)),
        )
        drop = -under.stands if under is not None else np.inf
        if under is not None and self._tolerance < drop < FLOATS * D:
            stood = float(pose.position[2]) - drop
            text = (
                f"at the {name} the object floats {drop:.3g} ({drop / D:.2g} of its size) above "
                f"{under.name}; did you mean rest (here z = {stood:.9g})?"
            )
            self._warn(text, path, "floats", drop)
        elif not held and not len(touching.points):
            self._alone(name, path, pose)

    def _alone(self, name: str, path: Path, pose: Pose) -> None:
        widths = list(self._widths(pose))
        if not widths:
            text = f"at the {name} the object touches nothing: there is no floor and no obstacle"
            self._warn(text, path, "touches nothing", None)
            return
        width, part = min(widths)
        if width > self._tolerance:
            text = (
                f"at the {name} the object touches nothing; the nearest is {part}, {width:.3g} "
                f"({width / self.body.diagonal:.2g} of its size) away"
            )
            self._warn(text, path, "touches nothing", width)

    @property
    def _tolerance(self) -> float:
        return self.environment.contact_tolerance * self.body.diagonal

    def _warn(self, text: str, path: Path, kind: str, width: float | None) -> None:
        line, relative = self.document.line(path, text), None
        if width is not None:
            relative = width / self.body.diagonal
        self.warnings.append(ScenarioWarning(line, dotted(path), kind, width, relative))

    def _supports(self, pose: Pose) -> tuple[Support, ...]:
        environment = self.environment
        obstacles = [(obstacle.name, obstacle.body) for obstacle in environment.obstacles]
        tolerance = environment.contact_tolerance
        return supports(self.body, obstacles, environment.floor, pose, tolerance)

    def _widths(self, pose: Pose) -> Iterator[tuple[float, str]]:
        """Yield how far everything is from the object, at least, and its name."""
        pieces = [PlacedPiece(piece, pose) for piece in self.body.pieces]
        if self.environment.floor:
            yield min(float(piece.vertices[:, 2].min()) for piece in pieces), "the floor"
        for obstacle in self.environment.obstacles:
            for other in map(PlacedPiece, obstacle.body.pieces):
                name = f"obstacle {obstacle.name!r}"
                yield min(gap(piece, other).width for piece in pieces), name
