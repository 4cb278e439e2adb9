"""Films: GIF by Pillow, MP4 by ffmpeg where it is installed."""

from __future__ import annotations

import io
import itertools
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from PIL import Image

from billow.base.errors import InputError

NO_FFMPEG = InputError.declare(
    "E-PIC-004",
    "there is no ffmpeg to write a film with",
    where="{path}",
    why="MP4 is written by the program ffmpeg, which is not on the path",
    remedy="install ffmpeg, or give the film a name that ends in .gif",
)
FFMPEG_FAILED = InputError.declare(
    "E-PIC-005",
    "ffmpeg could not write the film",
    where="{path}",
    cause="a build of ffmpeg without the encoder libx264",
    remedy="install a full build of ffmpeg, or give the film a name that ends in .gif",
)

COLOURS_OF_GIF = 256
MADE_BY = "Made by Billow."


def gif(pictures: Iterable[np.ndarray], per_second: float) -> bytes:
    """A film as GIF, played again and again; it stands still at its end for a second.

    pictures: red, green, blue as bytes, (height, width, 3), at least one. All share one palette, so that colours keep
    their meaning: that of all pictures together.
    """
    images = [Image.fromarray(picture) for picture in pictures]
    wide, tall = images[0].size
    small = [image.resize((max(wide // 4, 1), max(tall // 4, 1)), Image.Resampling.NEAREST) for image in images]
    every = Image.fromarray(
        np.concatenate([np.asarray(image) for image in small[:: -(-len(small) // 16)] + small[-1:]])
    )
    palette = every.quantize(COLOURS_OF_GIF, Image.Quantize.MEDIANCUT)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    length = max(round(100.0 / per_second), 2) * 10  # hundredths of a second; players slow down what is below two
    buffer = io.BytesIO()
    frames[0].save(
        buffer, "GIF", save_all=True, append_images=frames[1:], loop=0, comment=MADE_BY.encode(),
        duration=[length] * (len(frames) - 1) + [1000], optimize=False,
    )  # fmt: skip
    return buffer.getvalue()


def mp4(pictures: Iterable[np.ndarray], per_second: float, path: Path) -> bytes:
    """A film as MP4 (H.264). pictures: as `gif` takes them. path: for messages. InputError E-PIC-004, E-PIC-005."""
    program = shutil.which("ffmpeg")
    if program is None:
        raise NO_FFMPEG(path=path)
    pictures = map(_even, pictures)
    first = next(pictures)
    with tempfile.TemporaryDirectory(prefix="billow-film-") as folder:
        made = Path(folder, "film.mp4")
        command = [
            program, "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", f"{first.shape[1]}x{first.shape[0]}", "-r", f"{per_second:g}", "-i", "-",
            "-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18", "-metadata", f"comment={MADE_BY}", str(made),
        ]  # fmt: skip
        with tempfile.TemporaryFile() as told:
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=told)
            try:
                for picture in itertools.chain([first], pictures):
                    process.stdin.write(picture.tobytes())
                process.stdin.close()
            except BrokenPipeError:  # it has ended; what it said follows
                pass
            if process.wait() != 0:
                told.seek(0)
                raise FFMPEG_FAILED(
                    path=path, why=told.read().decode("utf-8", "replace").strip()[-300:] or "it does not say why"
                )
        return made.read_bytes()


def _even(picture: np.ndarray) -> np.ndarray:
    """A picture with even numbers of rows and columns, as H.264 needs them."""
    tall, wide = picture.shape[:2]
    return np.ascontiguousarray(np.pad(picture, ((0, tall % 2), (0, wide % 2), (0, 0)), "edge"))
