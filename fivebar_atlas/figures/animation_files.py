"""Animations to files: GIF by Pillow, MP4 by ffmpeg, as the ending says.

What does not move is drawn once. A GIF file has the same bytes every time.
"""

from __future__ import annotations

import csv
import io
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
from fivebar_atlas.output_file import atomic_output, check_output

Pixels = npt.NDArray[np.uint8]

#: Dots per inch of the frames.
RESOLUTION = 200
FORMATS = ("gif", "mp4")
#: Frames a second; viewers show GIF files no faster.
FRAME_RATE_RANGE = (1, 50)

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
    if _format(path) not in FORMATS:
        endings = " or ".join(f".{name}" for name in FORMATS)
        raise InputError("output", str(path), f"a file name that ends in {endings}")
    least, most = FRAME_RATE_RANGE
    if not least <= frame_rate <= most:
        raise InputError("fps", frame_rate, f"frames a second from {least} to {most}")
    check_output(path, overwrite)
    if _format(path) == "mp4" and not FFMpegWriter.isAvailable():
        raise FileError(path, "MP4 needs ffmpeg, which is not found; install it, or write a .gif")


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
        Frames a second; a GIF file counts the time of a frame in hundredths of a second.
    overwrite
        Whether an existing file may be replaced.
    advance
        Is told how many frames were drawn since it was told last.

    Raises
    ------
    InputError
        If the ending is not that of a format, or the frame rate out of range.
    FileUsageError, FileError
        If the file cannot be written or exists already.
    """
    check_animation_output(path, frame_rate, overwrite)
    with style.styled(), _drawn(animation) as draw, atomic_output(path, overwrite) as temporary:
        screen = _Screen(draw(0))
        writer: FFMpegWriter | PillowWriter
        if _format(path) == "gif":
            shown = np.linspace(0, len(animation) - 1, _PALETTE_FRAMES).astype(int)
            writer = _GifWriter(frame_rate, np.concatenate([draw(number) for number in shown]))
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
    animation: PathAnimation, path: Path, frame_rate: int, unit: str, overwrite: bool = False
) -> None:
    """Write what the frames of an animation show as comma-separated values, one row a frame.

    Parameters
    ----------
    animation
        The animation.
    path
        The file.
    frame_rate
        Frames a second.
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
        *(f"theta{number + 1}_deg" for number in range(animation.inputs.shape[1])),
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
            writer.writerow([number + 1, number / frame_rate, length, *places, *angles, lci])


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
    frame_rate
        Frames a second.
    sample
        Pixels with all colours there are, shape (height, width, 4).
    """

    def __init__(self, frame_rate: int, sample: Pixels) -> None:
        super().__init__(fps=frame_rate)
        self._palette = _image(sample).quantize(
            method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
        )
        self._images: list[Image.Image] = []

    def grab_frame(self, **_: Any) -> None:
        """Keep the present picture of the figure."""
        picture = io.BytesIO()
        self.fig.savefig(picture)
        width, height = self.frame_size
        pixels = np.frombuffer(picture.getbuffer(), dtype=np.uint8).reshape(height, width, 4)
        self._images.append(
            _image(pixels).quantize(palette=self._palette, dither=Image.Dither.NONE)
        )

    def finish(self) -> None:
        """Write the file."""
        hundredths = round(100 / self.fps)
        if not self._images:
            return
        first, *others = self._images
        first.save(
            self.outfile, save_all=True, append_images=others, duration=10 * hundredths, loop=0
        )


def _image(pixels: Pixels) -> Image.Image:
    return Image.fromarray(np.ascontiguousarray(pixels[:, :, :3]))


def _format(path: Path) -> str:
    return path.suffix.lower().removeprefix(".")
