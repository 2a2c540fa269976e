"""A plan as a moving picture: one small GIF, drawn as the snapshots are."""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array, unit
from gm_ompl.errors import InputError
from gm_ompl.writing import write_bytes

from .animation import Animation, ShownSegment
from .canvas import STDOUT, new_figure
from .region import neighbourhood, viewpoint
from .snapshots import Painter, Picture, Projection

RATE: Final = 10.0  # pictures per second
WIDTH: Final = 4.0  # of a picture [inch]
DOTS: Final = 90  # per inch
COLOURS: Final = 64  # of all pictures together: flat areas and few hues
SAMPLES: Final = 16  # pictures from which the colours are chosen, at most
SHORTEST: Final = 8.0  # a film lasts at least so long: few steps go slower [s]
LAST: Final = 1.5  # how long the goal is shown before all begins anew [s]


def check_film(path: Path) -> None:
    """Refuse a file whose name does not end in .gif.

    Raises:
        InputError: it does not.
    """
    if path not in STDOUT and path.suffix.lower() != ".gif":
        raise InputError(f"-o {path}: a film's name must end in .gif")


def write_film(animation: Animation, path: Path) -> None:
    """Write the film of a plan; inside ``canvas.styled`` alone.

    Raises:
        InputError: the plan has no steps, or the file cannot be written.
    """
    if not animation.segments:
        raise InputError(
            "--show film: without a plan nothing moves; --show snapshots shows the start"
        )
    first, *others = _few_colours(list(_frames(animation)))
    seconds = [1.0 / RATE] * len(others) + [LAST]
    content = BytesIO()
    first.save(
        content, format="GIF", save_all=True, append_images=others, loop=0,
        duration=[round(1000 * s) for s in seconds], optimize=True,
    )  # fmt: skip
    write_bytes(path, content.getvalue())


def moments(animation: Animation) -> Iterator[Picture]:
    """Yield what is to be seen at equal times, the last at the end."""
    count = round(max(animation.duration, SHORTEST) * RATE) + 1
    k = 0
    for time in np.linspace(0.0, animation.duration, count).tolist():
        while time > animation.segments[k].end and k + 1 < len(animation.segments):
            k += 1
        yield _moment(animation.segments[k], time)


def _moment(segment: ShownSegment, time: float) -> Picture:
    share = (time - segment.start) / (segment.end - segment.start)
    pose = _between(segment.poses, share)
    pose[3:] = unit(pose[3:])
    path = segment.path
    return Picture("", segment, pose, _between(path, share) if len(path) else None)


def _between(rows: Array, share: float) -> Array:
    """Return the row (n,) at a share of the way through rows (k, n) at equal times."""
    place = min(max(share, 0.0), 1.0) * (len(rows) - 1)
    low = min(int(place), max(len(rows) - 2, 0))
    row: Array = rows[low] + (place - low) * (rows[min(low + 1, len(rows) - 1)] - rows[low])
    return row


def _frames(animation: Animation) -> Iterator[Any]:
    """Yield the pictures as images."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    view, region = Projection(viewpoint(animation)), neighbourhood(animation)
    corners = np.array(np.meshgrid(*zip(region.low, region.high, strict=True))).reshape(3, -1).T
    frame = view.flat(corners)
    width, height = np.ptp(frame, axis=0)
    figure = new_figure(WIDTH, WIDTH * height / width)
    figure.set_dpi(DOTS)
    figure.set_layout_engine("none")  # the one pair of axes fills it
    canvas: Any = FigureCanvasAgg(figure)  # its methods have no types
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    for picture in moments(animation):
        axes.clear()
        Painter(axes, animation, view, region).draw(picture)
        axes.set_xlim(frame[:, 0].min(), frame[:, 0].max())
        axes.set_ylim(frame[:, 1].min(), frame[:, 1].max())
        axes.set_axis_off()
        canvas.draw()
        yield Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")


def _few_colours(images: list[Any]) -> list[Any]:
    """Return images of one size in the same few colours."""
    from PIL import Image

    some = images[:: -(-len(images) // SAMPLES)]
    width, height = images[0].size
    sheet = Image.new("RGB", (width, height * len(some)))
    for k, image in enumerate(some):
        sheet.paste(image, (0, k * height))
    palette = sheet.quantize(COLOURS)
    return [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
