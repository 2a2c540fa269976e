"""A film of an execution, rendered without a display: the door to imageio."""

from __future__ import annotations

from contextlib import ExitStack
from io import BytesIO
from pathlib import Path
from typing import Any

from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.simulation.engine import STEP
from gm_ompl.simulation.play import Player
from gm_ompl.writing import whole, write_bytes

RATE = 30  # pictures per second

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
            from imageio_ffmpeg import count_frames_and_secs
        except ModuleNotFoundError as error:
            raise MissingExtraError("imageio", "sim") from error
        self._imageio, self._count, self._path = imageio, count_frames_and_secs, path
        self._writer: Any = None
        self._camera: Any = None
        self._picture: Any = None
        self._shown = 0
        self._files = ExitStack()

    def __enter__(self) -> Film:
        """Begin; the file is made with the first picture."""
        return self

    def __exit__(self, *raised: Any) -> None:
        """Finish the file and release the renderer.

        Raises:
            InputError: the file could not be written whole.
        """
        if self._camera is not None:
            self._camera.__exit__(*raised)
        self._files.__exit__(*raised)

    def _finish(self, part: Path) -> None:
        """Close the film and count its pictures: ffmpeg does not say that a disk was full."""
        self._writer.close()
        try:
            written, _ = self._count(str(part))
        except (OSError, RuntimeError):
            written = 0
        if written < self._shown:
            raise self._refused()

    def _refused(self) -> InputError:
        return InputError(
            f"cannot write {self._path}: ffmpeg stopped before its end; is there space left?"
        )

    def __call__(self, player: Player, instant: int) -> None:
        """Add a picture where one is due.

        Raises:
            InputError: this machine cannot render.
        """
        if instant * STEP * RATE < self._shown:
            return
        if self._camera is None:
            self._begin(player)
        picture = self._picture()
        try:
            self._writer.append_data(picture)
        except OSError as error:
            raise self._refused() from error
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
        if self._path.suffix.lower() == ".gif":
            self._begin_gif()
        else:
            self._begin_mp4()

    def _begin_gif(self) -> None:
        """Gather the pictures in memory: imageio complains again and again of a file that fails."""
        content = BytesIO()
        self._writer = self._imageio.get_writer(
            content, format="GIF", mode="I", loop=0, duration=1000.0 / RATE
        )

        def finish(kind: object, *_: object) -> None:
            self._writer.close()
            if kind is None:
                write_bytes(self._path, content.getvalue())

        self._files.push(finish)

    def _begin_mp4(self) -> None:
        part = self._files.enter_context(whole(self._path))
        self._writer = self._imageio.get_writer(
            str(part), macro_block_size=1, fps=RATE, ffmpeg_log_level="quiet"
        )
        self._files.push(lambda kind, *_: self._writer.close() if kind else self._finish(part))
