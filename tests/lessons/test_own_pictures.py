"""A picture on the stage of a lesson of one's own: where it stands, and what is refused."""

from __future__ import annotations

import io
import os
import struct
import zlib
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest
from own_lessons import first_files, zipped
from PIL import Image, PngImagePlugin

from observer_lab.course.figures.scene import StagePicture
from observer_lab.course.lesson import Lesson
from observer_lab.course.reading.toml_table import LessonFileError
from observer_lab.lessons.from_files.packed import uploaded_lessons
from observer_lab.lessons.from_files.picture import MAX_PICTURE_BYTES, SHOWN_PX
from observer_lab.lessons.from_files.read_lesson import read_lesson
from observer_lab.page.stage.stage import StageView

RED, BLUE = (200, 30, 30), (30, 30, 200)


def picture(size: tuple[int, int] = (60, 40), kind: str = "PNG", mode: str = "RGB") -> bytes:
    """A red picture with a blue upper left corner."""
    image, out = Image.new("RGB", size, RED), io.BytesIO()
    image.paste(BLUE, (0, 0, size[0] // 2, size[1] // 2))
    image.convert(mode).save(out, kind)
    return out.getvalue()


def lesson_of(place: Path, content: bytes | None, name: str = "tank.png") -> Lesson:
    home = place / "tank"
    home.mkdir(exist_ok=True)
    files = first_files("tank")
    for file, words in {**files, "lesson.toml": f'picture = "{name}"\n{files["lesson.toml"]}'}.items():
        (home / file).write_text(words, encoding="utf-8")
    if content is not None:
        (home / name).write_bytes(content)
    return read_lesson(home, 1, trusted=False)


def shown(lesson: Lesson) -> StagePicture:
    stage = lesson.compute(lesson.start()).stage
    assert stage is not None and stage.picture is not None
    return stage.picture


@pytest.mark.parametrize("kind, name", [("PNG", "tank.png"), ("JPEG", "tank.jpg"), ("JPEG", "tank.JPEG"), ("WEBP", "tank.webp")])
def test_a_picture_of_each_kind_stands_on_the_stage(tmp_path: Path, kind: str, name: str) -> None:
    found = shown(lesson_of(tmp_path, picture(kind=kind), name))
    assert found.image.shape == (40, 60, 3) and found.image.dtype == np.uint8
    np.testing.assert_allclose(found.image[30, 50], RED, atol=8)
    np.testing.assert_allclose(found.image[5, 5], BLUE, atol=8)


@pytest.mark.parametrize("size", [(60, 40), (400, 20), (20, 400)])
def test_a_picture_keeps_its_shape_and_stands_on_the_floor_below_the_boards(tmp_path: Path, size: tuple[int, int]) -> None:
    found = shown(lesson_of(tmp_path, picture(size)))
    (across, up), (_, _, middle) = found.size, found.place
    assert across / up == pytest.approx(size[0] / size[1], rel=1e-9)
    assert middle - up / 2 > 0 and middle + up / 2 < 2.6  # where the boards begin


def test_a_large_picture_is_made_smaller_and_glass_is_white(tmp_path: Path) -> None:
    assert max(shown(lesson_of(tmp_path, picture((1600, 800)))).image.shape) == SHOWN_PX
    out = io.BytesIO()
    Image.new("RGBA", (10, 10), (0, 0, 0, 0)).save(out, "PNG")
    assert (shown(lesson_of(tmp_path, out.getvalue())).image == 255).all()


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def claims(across: int, up: int) -> bytes:
    """A PNG that says it is so large, and holds a few bytes."""
    head = struct.pack(">IIBBBBB", across, up, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")


def words_in() -> bytes:
    """A PNG whose comment unpacks to a hundred million letters."""
    notes, out = PngImagePlugin.PngInfo(), io.BytesIO()
    notes.add_text("Comment", "0" * 100_000_000, zip=True)
    Image.new("RGB", (10, 10)).save(out, "PNG", pnginfo=notes)
    return out.getvalue()


SVG = b"<svg xmlns='http://www.w3.org/2000/svg' onload='alert(1)'/>"
REFUSED = {
    "missing": (None, "tank.png", "There is no picture"), "svg": (SVG, "tank.svg", "ends in .png"),
    "svg as png": (SVG, "tank.png", "cannot be read"),
    "gif": (picture(kind="GIF"), "tank.gif", "ends in .png"), "gif as png": (picture(kind="GIF"), "tank.png", "cannot be read"),
    "other kind": (picture(kind="JPEG"), "tank.png", "cannot be read"), "cut": (picture()[:60], "tank.png", "cannot be read"),
    "large": (bytes(MAX_PICTURE_BYTES + 1), "tank.png", "at most 500 kB"), "many pixels": (claims(3000, 3000), "tank.png", "3000×3000"),
    "bomb": (claims(100_000, 100_000), "tank.png", "tank.png"), "half": (claims(1000, 1000), "tank.png", "cannot be read"),
    "upwards": (None, "../tank/lesson.png", "beside the lesson"), "absolute": (None, "/etc/passwd.png", "beside the lesson"),
    "hidden": (None, ".png", "beside the lesson"), "words": (words_in(), "tank.png", "tank.png")}


@pytest.mark.parametrize("case", REFUSED)
def test_a_hostile_picture_is_refused_with_file_and_line(tmp_path: Path, case: str) -> None:
    content, name, said = REFUSED[case]
    with pytest.raises(LessonFileError, match=rf"lesson\.toml, line \d+: .*{said}"):
        lesson_of(tmp_path, content, name)


def test_a_pipe_is_no_picture_and_is_not_waited_for(tmp_path: Path) -> None:
    lesson_of(tmp_path, picture())
    (tmp_path / "tank" / "tank.png").unlink()
    os.mkfifo(tmp_path / "tank" / "tank.png")
    with pytest.raises(LessonFileError, match="There is no picture"):
        read_lesson(tmp_path / "tank", 1, trusted=False)


def test_the_stage_shows_it_once_upright_and_takes_it_away_with_its_plant(tmp_path: Path) -> None:
    lesson, client = lesson_of(tmp_path, picture()), MagicMock()
    stage, images = lesson.compute(lesson.start()).stage, client.scene.add_image
    assert stage is not None
    view = StageView(client)
    view.build(stage, "en", 0.14)
    (name, image, across, up), more = images.call_args
    assert name == "/picture" and (across, up) == shown(lesson).size and more["position"] == shown(lesson).place
    np.testing.assert_array_equal(image[0, 0], RED)  # the last row of what lies flat is the highest of what stands
    other = lesson.compute(lesson.apply(lesson.start(), {"first": 1.0})).stage
    view.show(other, "en", 0.14)
    assert images.call_count == 1
    view.show(None, "en", 0.14)
    images.return_value.remove.assert_called_once()


def test_a_zip_may_bring_a_picture() -> None:
    files = first_files("tank")
    content = zipped({"tank": {**files, "lesson.toml": f'picture = "tank.png"\n{files["lesson.toml"]}', "tank.png": picture()}})
    lesson, = uploaded_lessons("mine.zip", content, ())
    assert not lesson.fault.id and shown(lesson).image.shape == (40, 60, 3)
