"""Animations to files: GIF by Pillow, MP4 by ffmpeg, as the ending says.

What does not move is drawn once. A GIF file has the same bytes every time.
"""

from __future__ import annotations

import csv
import io
import itertools
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from fivebar_atlas.errors import FileError, InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.animation import PathAnimation
from fivebar_atlas.figures.linkage import plain
from fivebar_atlas.output_file import atomic_output, check_output, checked_ending

Pixels = npt.NDArray[np.uint8]

#: Dots per inch of the frames.
RESOLUTION = 200
FORMATS = ("gif", "mp4")
#: Frames a second; viewers show GIF files no faster.
FRAME_RATE_RANGE = (1, 50)

# Colours of a palette, and those among them that are there for being frequent.
_COLOURS, _FREQUENT = 256, 128
# Pixels that all frames of a GIF file may have together, a byte each.
_MOST_PIXELS = 2_000_000_000
# Frames whose colours make the palette of all.
_PALETTE_FRAMES = 6


def check_animation_output(path: Path, frame_rate: int, overwrite: bool = False) -> None:
    """Refuse an output that cannot be written, before any frame is drawn.

    Parameters
    ----------
    path
        The file; its ending decides the format.
    frame_rate
        Frames a second.
    overwrite
        Whether an existing file may be replaced.

    Raises
    ------
    InputError
        If the ending is not that of a format, or the frame rate out of range.
    FileUsageError, FileError
        If the folder is missing or not writable, the file exists already, or what writes
        the format is not installed.
    """
    checked_ending(path, FORMATS)
    least, most = FRAME_RATE_RANGE
    if not least <= frame_rate <= most:
        raise InputError("fps", frame_rate, f"frames a second from {least} to {most}")
    check_output(path, overwrite)
    with style.styled():
        is_writable = checked_ending(path, FORMATS) != "mp4" or FFMpegWriter.isAvailable()
    if not is_writable:
        raise FileError(path, "MP4 needs ffmpeg, which is not found; install it, or write a .gif")


def frame_seconds(path: Path, frame_rate: int) -> float:
    """Return how long a frame is shown: in a GIF file whole hundredths of a second."""
    return (
        round(100 / frame_rate) / 100
        if checked_ending(path, FORMATS) == "gif"
        else 1.0 / frame_rate
    )


def save_animation(
    animation: PathAnimation,
    path: Path,
    frame_rate: int,
    overwrite: bool = False,
    advance: Callable[[int], None] = lambda _: None,
) -> None:
    """Write an animation; a file appears whole under its name or not at all.

    Parameters
    ----------
    animation
        The animation.
    path
        The file; its ending decides the format.
    frame_rate
        Frames a second; see :func:`frame_seconds`.
    overwrite
        Whether an existing file may be replaced.
    advance
        Is told how many frames were drawn since it was told last.

    Raises
    ------
    InputError
        If the ending is not that of a format, the frame rate out of range, or the frames of
        a GIF file, which are kept until the last one is drawn, too many for their size.
    FileUsageError, FileError
        If the file cannot be written or exists already.
    """
    check_animation_output(path, frame_rate, overwrite)
    with style.styled(), _drawn(animation) as draw, atomic_output(path, overwrite) as temporary:
        screen = _Screen(draw(0))
        writer: FFMpegWriter | PillowWriter
        if checked_ending(path, FORMATS) == "gif":
            _check_memory(len(animation), screen.pixels)
            shown = np.linspace(0, len(animation) - 1, _PALETTE_FRAMES).astype(int)
            seconds = frame_seconds(path, frame_rate)
            writer = _GifWriter(seconds, np.concatenate([draw(number) for number in shown]))
        else:
            writer = FFMpegWriter(fps=frame_rate)
        try:
            with writer.saving(screen, str(temporary), RESOLUTION):
                for number in range(len(animation)):
                    screen.pixels = draw(number)
                    writer.grab_frame()
                    advance(1)
        except subprocess.CalledProcessError as error:
            reason = " ".join(str(error.stderr).split()) or f"exit code {error.returncode}"
            raise FileError(path, f"cannot be written by ffmpeg: {reason}") from None


def save_frames(
    animation: PathAnimation, path: Path, seconds: float, unit: str, overwrite: bool = False
) -> None:
    """Write what the frames of an animation show as comma-separated values, one row a frame.

    Parameters
    ----------
    animation
        The animation.
    path
        The file.
    seconds
        How long a frame is shown.
    unit
        Unit of lengths, for the names of their columns; empty where they are
        non-dimensional.
    overwrite
        Whether an existing file may be replaced.

    Raises
    ------
    FileUsageError, FileError
        If the file cannot be written or exists already.
    """
    suffix = f"_{unit}" if unit else ""
    names = [plain(joint.symbol) for joint in animation.poses[0].joints]
    header = [
        *("frame", "time_s", f"path_length{suffix}"),
        *(f"{name}_{axis}{suffix}" for name in names for axis in "xy"),
        *(f"{name}_deg" for name in animation.input_names),
        "lci",
    ]
    with (
        atomic_output(path, overwrite) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for number, pose in enumerate(animation.poses):
            places = [part for joint in pose.joints for part in joint.position]
            angles = np.degrees(animation.inputs[number]).tolist()
            length, lci = float(animation.lengths[number]), float(animation.lci[number])
            writer.writerow([number + 1, number * seconds, length, *places, *angles, lci])


@contextmanager
def _drawn(animation: PathAnimation) -> Iterator[Callable[[int], Pixels]]:
    """Give the body a function that draws a frame, shape (height, width, 4).

    Height and width are even, as some formats of video need it.
    """
    figure = animation.figure
    before = figure.dpi
    figure.set_dpi(RESOLUTION)
    canvas: Any = FigureCanvasAgg(figure)
    for artist in animation.moving:
        artist.set_animated(True)  # and so not drawn with the rest
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)

    def draw(number: int) -> Pixels:
        animation.show(number)
        canvas.restore_region(still)
        for artist in animation.moving:
            assert artist.axes is not None
            artist.axes.draw_artist(artist)
        pixels = np.array(canvas.buffer_rgba())
        height, width = pixels.shape[0] // 2 * 2, pixels.shape[1] // 2 * 2
        return np.ascontiguousarray(pixels[:height, :width])

    try:
        yield draw
    finally:
        for artist in animation.moving:
            artist.set_animated(False)
        figure.set_dpi(before)


class _Screen(Figure):
    """A figure whose picture is drawn already.

    Attributes
    ----------
    pixels
        The picture, shape (height, width, 4).
    """

    def __init__(self, pixels: Pixels) -> None:
        height, width = pixels.shape[:2]
        # A little more, as writers round down.
        super().__init__(((width + 0.01) / RESOLUTION, (height + 0.01) / RESOLUTION), RESOLUTION)
        self.pixels = pixels

    def savefig(self, fname: BinaryIO, **_: Any) -> None:  # type: ignore[override]
        """Write the picture as the bytes of its pixels."""
        fname.write(self.pixels.tobytes())


class _GifWriter(PillowWriter):
    """Writes GIF files with one palette for all frames, so that no colour flickers.

    Parameters
    ----------
    seconds
        How long a frame is shown.
    sample
        Pixels with all colours there are, shape (height, width, 4).
    """

    def __init__(self, seconds: float, sample: Pixels) -> None:
        super().__init__()
        self._milliseconds = round(1000 * seconds)
        self._matched, self._shown = _palettes(sample)
        self._images: list[Image.Image] = []

    def grab_frame(self, **_: Any) -> None:
        """Keep the present picture of the figure."""
        picture = io.BytesIO()
        self.fig.savefig(picture)
        width, height = self.frame_size
        pixels = np.frombuffer(picture.getbuffer(), dtype=np.uint8).reshape(height, width, 4)
        image = _image(pixels).quantize(palette=self._matched, dither=Image.Dither.NONE)
        image.putpalette(self._shown)
        self._images.append(image)

    def finish(self) -> None:
        """Write the file."""
        if not self._images:
            return
        first, *others = self._images
        first.save(
            self.outfile, save_all=True, append_images=others, duration=self._milliseconds, loop=0
        )


def _check_memory(frames: int, pixels: Pixels) -> None:
    """Raise InputError if the frames of a GIF file do not fit into memory together."""
    height, width = pixels.shape[:2]
    most = _MOST_PIXELS // (height * width)
    if frames > most:
        raise InputError(
            "frames",
            frames,
            f"at most {most} of {width} by {height} pixels in a GIF file; narrower ones, or MP4, "
            "can be more",
        )


def _palettes(sample: Pixels) -> tuple[Image.Image, list[int]]:
    """Return what colours are matched with, and what they are shown as in its place.

    Pillow measures distances from the least corner of a cell, which is 4 wide in each of red,
    green and blue. So that is what the palette has for matching; what is shown is the
    most frequent colour of the cell, or one that covers rare ones.
    """
    image = _image(sample)
    counted: list[Any] = image.getcolors(image.width * image.height) or []
    frequent = [colour for _, colour in sorted(counted, key=lambda each: (-each[0], each[1]))]
    cover = image.quantize(_COLOURS, Image.Quantize.MAXCOVERAGE).getpalette() or []
    rare = list(zip(cover[::3], cover[1::3], cover[2::3], strict=True))
    shown: dict[tuple[int, ...], tuple[int, ...]] = {}
    for limit, colours in ((_FREQUENT, frequent), (_COLOURS, rare)):
        for colour in colours:
            if len(shown) < limit:
                shown.setdefault(tuple(part & ~3 for part in colour), colour)
    matched = Image.new("P", (1, 1))
    matched.putpalette(list(itertools.chain.from_iterable(shown)))
    return matched, list(itertools.chain.from_iterable(shown.values()))


def _image(pixels: Pixels) -> Image.Image:
    return Image.fromarray(np.ascontiguousarray(pixels[:, :, :3]))
