"""A film of an execution, rendered without a display: the door to imageio."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.simulation.physics import STEP
from gm_ompl.simulation.play import Player

RATE = 30
"""Pictures per second."""

WIDTH, HEIGHT = 640, 480

SUFFIXES = (".mp4", ".gif")


class Film:
    """Writes what a player shows to a file, in real time; call it with every instant.

    Args:
        path: an .mp4 or .gif file.

    Raises:
        InputError: another kind of file.
        MissingExtraError: imageio is not installed.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() not in SUFFIXES:
            raise InputError(f"--video {path}: must end in {' or '.join(SUFFIXES)}")
        try:
            import imageio.v2 as imageio
        except ModuleNotFoundError as error:
            raise MissingExtraError("imageio", "sim") from error
        self._imageio, self._path = imageio, path
        self._writer: Any = None
        self._camera: Any = None
        self._picture: Any = None
        self._shown = 0

    def __enter__(self) -> Film:
        """Begin; the file is made with the first picture."""
        return self

    def __exit__(self, *raised: Any) -> None:
        """Finish the file and release the renderer."""
        if self._writer is not None:
            self._writer.close()
        if self._camera is not None:
            self._camera.__exit__(*raised)

    def __call__(self, player: Player, instant: int) -> None:
        """Add a picture where one is due.

        Raises:
            InputError: this machine cannot render.
        """
        if instant * STEP * RATE < self._shown:
            return
        if self._camera is None:
            self._begin(player)
        self._writer.append_data(self._picture())
        self._shown += 1

    def _begin(self, player: Player) -> None:
        line, scale = player.timeline, player.units.length
        middle = scale * (line.position.min(axis=0) + line.position.max(axis=0)) / 2.0
        camera = player.physics.camera(middle, WIDTH, HEIGHT)
        try:
            self._picture = camera.__enter__()
        except Exception as error:
            raise InputError(
                f"this machine cannot render: {error}; on Debian or Ubuntu: apt-get install "
                "libegl1 libegl-mesa0 libgl1-mesa-dri"
            ) from error
        self._camera = camera
        gif = self._path.suffix.lower() == ".gif"
        options: dict[str, Any] = {"loop": 0} if gif else {"macro_block_size": 1}
        timing = {"duration": 1000.0 / RATE} if gif else {"fps": RATE}
        self._writer = self._imageio.get_writer(str(self._path), **options, **timing)
