"""What an explanation of free motion says beside the rest: values only."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Place:
    """Where the object is.

    Attributes:
        position: of the centre of mass, world frame.
        quaternion: unit, (w, x, y, z), object to world.
        words: the same in words, turned since the start.
    """

    position: tuple[float, ...]
    quaternion: tuple[float, ...]
    words: str


@dataclass(frozen=True)
class DeedLine:
    """Arcs of free motion on which the object does the same.

    Attributes:
        deed: what: "slides along x", "tumbles about y", "lifts off along z".
        arcs: how many were seen.
        holding: along how many some set of placements holds the object; 0 on geometry alone.
        findings: how many of the others each finding blocks, for the set that comes closest.
    """

    deed: str
    arcs: int
    holding: int
    findings: dict[str, int]


@dataclass(frozen=True)
class Nearest:
    """How near to its goal the object came.

    Attributes:
        distance: of the centre of mass from where it must be.
        angle: by which it must still turn [deg].
        place: where it is.
        arcs: how many led there as it was found.
    """

    distance: float
    angle: float
    place: Place
    arcs: int


@dataclass(frozen=True)
class Explored:
    """What the object reaches from the start in free motion.

    Attributes:
        fingers: whether it is held by sets of placements, each where it holds, as though fingers
            could change anywhere; else it goes wherever geometry lets it.
        sets: how many sets were tried; 0 on geometry alone.
        nodes: poses seen.
        arcs: arcs that leave those.
        whole: whether there are no more than these.
        arrived: whether the goal is among them.
        nearest: the nearest of them to the goal.
        deeds: the arcs by what the object does.
        contacts: how many poses have which contacts with the environment: "floor: face".
        changes: how many arcs lead from one to another: "floor: face > floor: edge".
        borders: where poses end less than a step from the region's: "x = 7".
    """

    fingers: bool
    sets: int
    nodes: int
    arcs: int
    whole: bool
    arrived: bool
    nearest: Nearest
    deeds: tuple[DeedLine, ...]
    contacts: dict[str, int]
    changes: dict[str, int]
    borders: tuple[str, ...]
