"""Text of strangers in files: TOML that would fill the memory or stop a parser, and files that are none, end in one sentence."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
import tomllib
import tracemalloc
from pathlib import Path

import pytest
from commands import refused
from fakes import toy
from laws import each

from observer_lab.cli.file_limit import MAX_MEMORY_BYTES
from observer_lab.course.handin.course_file import CourseFileError, read_course
from observer_lab.course.knobs import KnobError
from observer_lab.course.lectures import read_lecture
from observer_lab.course.reading.toml_table import LessonFileError, read_table
from observer_lab.lessons.from_files.folder import LessonFolder
from observer_lab.text import OutsideFileError, read_outside_bytes, read_outside_toml

HOSTILE = {
    "parts": "a." * 29_000 + "a=1", "quoted parts": '"a".' * 9000 + "b=1", "spaced parts": "a . " * 9000 + "b=1",
    "header": "[" + "a." * 9000 + "a]",
    "arrays": "x=" + "[" * 40_000, "tables": "x=" + "{a=" * 10_000, "both": "x=" + "[{a=" * 10_000, "closed": "x=" + "[" * 400 + "]" * 400,
    "digits": "x=" + "9" * 5000, "hexadecimal": "x=0x" + "f" * 100_000, "float": "x=0." + "1" * 100_000, "underscores": "x=1" + "_1" * 5000,
    "long": "#" * 500_001, "quotes": '"""' * 20_001, "escapes": 'x="""' + '\\"""' * 50_000, "apostrophes": "x='''" + "''a" * 50_000 + "'"}


@each("kind", list(HOSTILE))
def test_hostile_toml_is_refused_in_bounded_time_and_memory(kind: str) -> None:
    tracemalloc.start()
    began = time.process_time()
    with pytest.raises(tomllib.TOMLDecodeError):
        read_outside_toml(HOSTILE[kind])
    spent, (_, peak) = time.process_time() - began, tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert spent < 5 and peak < 50 * 2**20, (spent, peak)


@each("kind", list(HOSTILE))
def test_every_reader_of_toml_answers_it_with_one_sentence(kind: str) -> None:
    with pytest.raises(CourseFileError):
        read_course(HOSTILE[kind], {"toy": toy("toy")}, str)
    with pytest.raises(KnobError):
        read_lecture(HOSTILE[kind], {"toy": toy("toy")})
    with pytest.raises(LessonFileError) as problem:
        read_table("lesson.toml", HOSTILE[kind])
    assert "lesson.toml, line 1" in problem.value.text("en")


def test_toml_that_people_write_is_read_as_it_was() -> None:
    root = Path(__file__).parents[1]
    found = [path.read_text(encoding="utf-8") for folder in ("assets", "lessons", "app") for path in (root / folder).rglob("*.toml")]
    found += ['a.b.c = 0.1\nx = [[1, 2], [3]]\n[d.e]\ns = """[[[[ a.b.c.d.e.f """\n', "x = '" + "[" * 99 + "'", 'x = "' + "9" * 5000 + '"']
    assert len(found) > 5
    for words in found:
        assert read_outside_toml(words) == tomllib.loads(words)


def test_only_a_regular_file_of_bounded_size_is_read(tmp_path: Path) -> None:
    (tmp_path / "good").write_bytes(b"x" * 100)
    assert read_outside_bytes(tmp_path / "good", 100) == b"x" * 100
    with pytest.raises(OutsideFileError, match="larger"):
        read_outside_bytes(tmp_path / "good", 99)
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero"), tmp_path):
        with pytest.raises((OutsideFileError, IsADirectoryError)):
            read_outside_bytes(path, 100)


@pytest.mark.parametrize("words", [("grade", "olh1.x.y", "--course"), ("run", "separation", "--state"), ("run", "separation", "--plant"),
                                   ("serve", "--port", "0", "--lecture"), ("study",)])
def test_no_command_waits_for_a_pipe(capsys, tmp_path: Path, words: tuple[str, ...]) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert "no plain file" in refused(capsys, *words, str(tmp_path / "pipe"))


# --- lessons of one's own ------------------------------------------------------------------------------------------
def test_each_lesson_is_judged_alone(tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    from observer_lab.cli.entry import main
    from observer_lab.lessons.from_files import folder as module

    assert main(["new-lesson", "good", "--folder", str(tmp_path)]) == 0
    folder = LessonFolder(tmp_path, (), False)
    assert not folder.lessons()["good"].fault.id
    for name in ("deep", "pipe", "zero", "odd"):
        (tmp_path / name).mkdir()
    (tmp_path / "deep" / "lesson.toml").write_text(HOSTILE["parts"], encoding="utf-8")
    os.mkfifo(tmp_path / "pipe" / "lesson.toml")
    (tmp_path / "zero" / "lesson.toml").symlink_to("/dev/zero")
    (tmp_path / "odd" / "lesson.toml").write_text("", encoding="utf-8")
    real = module.read_lesson

    def read(place: Path, number: int, trusted: bool, uploaded: bool):
        if place.name == "odd":
            raise MemoryError
        return real(place, number, trusted, uploaded)
    monkeypatch.setattr(module, "read_lesson", read)
    words = tmp_path / "good" / "lesson.md"
    words.write_text(words.read_text(encoding="utf-8").replace("# ", "# Better: ", 1), encoding="utf-8")
    assert folder.changed()
    found: dict[str, object] = {}
    reading = threading.Thread(target=lambda: found.update(folder.lessons()), daemon=True)
    reading.start()
    reading.join(60)
    assert not reading.is_alive() and set(found) == {"good", "deep", "pipe", "zero", "odd-broken"}
    lessons = folder.lessons()
    assert lessons["good"].words["en"].title.startswith("Better") and not lessons["good"].fault.id
    assert all(lessons[name].fault.id for name in found if name != "good") and not folder.changed()


@pytest.mark.slow
def test_a_server_gets_no_more_memory_than_its_bound() -> None:
    script = ("from observer_lab.cli.file_limit import bound_memory, MAX_MEMORY_BYTES\nbound_memory()\n"
              "try:\n    held = bytearray(MAX_MEMORY_BYTES)\nexcept MemoryError:\n    print('bounded')")
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == "bounded\n" and MAX_MEMORY_BYTES >= 2**32
