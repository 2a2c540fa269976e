"""The simulators there are."""

from __future__ import annotations

from gm_ompl.arrays import Array
from gm_ompl.simulation import dart, physics
from gm_ompl.simulation.dart import Dart
from gm_ompl.simulation.engine import Engine, EngineName
from gm_ompl.simulation.physics import FreeTips
from gm_ompl.simulation.world import Bodies


def start(
    name: EngineName, world: Bodies, position: Array, quaternion: Array, centres: Array
) -> Engine:
    """Return a simulator at the beginning.

    Args:
        name: one of ``ENGINES``.
        world: the bodies.
        position: (3,), of the object.
        quaternion: (4,), its orientation (w, x, y, z).
        centres: (n, 3), of the fingertips.

    Raises:
        MissingExtraError: it is not installed.
    """
    engine: type[Dart | FreeTips] = Dart if name == "dart" else FreeTips
    return engine(world, position, quaternion, centres)


def load(name: EngineName) -> None:
    """Import an engine's library.

    Raises:
        MissingExtraError: it is not installed.
    """
    if name == "dart":
        dart.load()
    else:
        physics.load()
