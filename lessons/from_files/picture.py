"""Read the picture that a lesson file shows on its stage."""

from __future__ import annotations

import io
import re
import struct
from pathlib import Path
from types import MappingProxyType

import numpy as np
from PIL import Image

from observer_lab.course.figures.scene import StagePicture
from observer_lab.course.reading.toml_table import LessonFileError, Table
from observer_lab.text import OutsideFileError, read_outside_bytes, text

KINDS = MappingProxyType({".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".webp": "WEBP"})  # pictures of pixels, none with scripts
NAME = re.compile(r"[\w-][\w.-]{0,79}")
MAX_PICTURE_BYTES, MAX_PIXELS, SHOWN_PX = 500_000, 4_000_000, 800
UNREADABLE = (OSError, ValueError, SyntaxError, EOFError, struct.error, MemoryError, Image.DecompressionBombError)


def read_picture(top: Table, folder: Path) -> StagePicture | None:
    """The picture that `picture` names, a file beside the lesson; None without one. Raises LessonFileError."""
    if "picture" not in top.data:
        return None
    name = top.words("picture")
    kind = KINDS.get(Path(name).suffix.lower())
    if kind is None or not NAME.fullmatch(name):
        raise top.refuse("picture", text("A picture is a file beside the lesson that ends in {kinds}.", kinds=", ".join(KINDS)))
    try:
        content = read_outside_bytes(folder / name, MAX_PICTURE_BYTES)
    except (OSError, OutsideFileError) as problem:
        raise top.refuse("picture", text("There is no picture {file} of at most {most} kB beside this lesson.", file=name[:40],
                                        most=MAX_PICTURE_BYTES // 1000)) from problem
    try:
        with Image.open(io.BytesIO(content), formats=[kind]) as image:
            if image.width * image.height > MAX_PIXELS:
                raise top.refuse("picture", text("The picture {file} has {across}×{up} pixels; {most} million are allowed.", file=name[:40],
                                                across=image.width, up=image.height, most=MAX_PIXELS // 1_000_000))
            return StagePicture(_on_white(image))
    except LessonFileError:
        raise
    except UNREADABLE as problem:
        raise top.refuse("picture", text("{file} cannot be read as a picture of its kind.", file=name[:40])) from problem


def _on_white(image: Image.Image) -> np.ndarray:
    """The first frame (rows, columns, 3) on a white ground, made smaller where it is large."""
    drawn = image.convert("RGBA")
    drawn.thumbnail((SHOWN_PX, SHOWN_PX))
    ground = Image.new("RGBA", drawn.size, "white")
    ground.alpha_composite(drawn)
    return np.asarray(ground.convert("RGB"))
