"""Lessons of one's own in teaching: exams with personal numbers, every command that names a lesson, and one file for colleagues."""

from __future__ import annotations

import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm
from test_lesson_files import COMMANDS, LINES, changed, refused, written

from observer_lab.cli.entry import main
from observer_lab.cli.opening import ServeRequest, opening_of
from observer_lab.course.exercises.exam import seed_of
from observer_lab.lessons.from_files.read_lesson import read_lesson

FOLDER_COMMANDS = (["run", "{id}"], ["run", "{id}", "--set", "k=1.5", "--json"], ["link", "{id}"], ["exam", "{id}", "--key", "anna"],
                   ["teach", "{id}"], ["list"], ["export", "{id}", "--to", "json", "-o", "{out}/x.json"],
                   ["export", "{id}", "--to", "csv", "-o", "{out}/x.csv"], ["sheet", "{id}", "-o", "{out}/x.pdf"])


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    place = written(tmp_path, COMMANDS[0])
    for name, blocks in (("lesson.toml", LINES["toml"]), ("lesson.md", LINES["markdown"])):
        (place / name).write_text("\n".join([(place / name).read_text(encoding="utf-8"), *blocks]), encoding="utf-8")
    return place


@pytest.fixture
def packed(whole: Path, tmp_path: Path) -> Path:
    file = tmp_path / "lessons.zip"
    assert main(["list", "--lessons", str(whole.parent), "--zip", str(file)]) == 0
    return file


@pytest.mark.parametrize("command", FOLDER_COMMANDS, ids=lambda command: " ".join(command[:2]))
@pytest.mark.parametrize("how", ["folder", "zip"])
def test_a_command_takes_lessons_of_ones_own(whole: Path, packed: Path, tmp_path: Path, command: list[str], how: str,
                                             capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    said = [part.format(id=whole.name, out=tmp_path) for part in command]
    assert main([*said, "--lessons", str(whole.parent if how == "folder" else packed)]) == 0
    told = capsys.readouterr()
    written_file = next((tmp_path / f"x.{kind}" for kind in ("json", "csv", "pdf") if f"{{out}}/x.{kind}" in command), None)
    assert written_file is None or written_file.stat().st_size > 500
    assert command[0] not in ("run", "list") or whole.name in told.out or '"largest_gain"' in told.out
    assert command[0] != "link" or "/#1." in told.out
    assert "exam" not in command or "the second entry" in told.out
    assert "teach" not in command or "teacher.md" in told.err


def test_a_lesson_without_the_option_is_not_found(whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", whole.name]) == 2
    assert f"no lesson {whole.name}" in capsys.readouterr().err


def test_notes_beside_the_lesson_are_printed(whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (whole / "teacher.md").write_text("# Notes\nBegin with the spring.\n", encoding="utf-8")
    assert main(["teach", whole.name, "--lessons", str(whole.parent)]) == 0
    assert "Begin with the spring." in capsys.readouterr().out


# --- exams ---------------------------------------------------------------------------------------------------------
def test_each_student_has_numbers_and_the_answer_follows_from_them(whole: Path) -> None:
    lesson, seen = read_lesson(whole, 22, False), set()
    exam = next(exam for exam in lesson.exams if exam.id == "gain")
    for student in range(40):
        item = exam.item(seed_of(f"student {student}", lesson.id, exam.id, 0))
        k, p = float(item.given["k"]), float(item.given["p"])
        A, C = np.array([[0, 1], [-k, 0]]), np.array([[1.0, 0.0]])
        L = np.array([[2 * p + 1], [item.answer]])
        np.testing.assert_allclose(np.sort(np.linalg.eigvals(A - L @ C)), [-p - 1, -p], rtol=1e-9)
        assert str(item.answer)[:3] in exam.derived(lesson.words["en"].exams["gain"].derivation, item)
        seen.add((k, p))
    assert len(seen) > 20


def test_an_answer_may_be_a_number_of_the_run(whole: Path) -> None:
    """The root mean square error of the guide's block, by the matrix exponential."""
    lesson = read_lesson(whole, 22, False)
    exam = next(exam for exam in lesson.exams if exam.id == "spring")
    item = exam.item("one")
    k = float(item.given["p"]) / 10
    start = lesson.compute(lesson.start())
    L, run = start.gains["L"], start.run
    real, believed = (np.array([[0, 1], [-stiff, -0.5]]) for stiff in (k, 1.0))
    C = np.array([[1.0, 0.0]])
    L = np.array(lesson.compute(lesson.apply(lesson.start(), {"k": k})).gains["L"])
    M = np.block([[real, np.zeros((2, 2))], [L @ C, believed - L @ C]])
    step, z, e = expm(M * 0.03), np.concatenate([run.x[0], run.xhat[0]]), []
    for _ in run.t:
        e.append(z[:2] - z[2:])
        z = step @ z
    assert item.answer == pytest.approx(np.sqrt(np.mean(np.sum(np.square(e), axis=1))), rel=1e-6)


@pytest.mark.parametrize("old, new, said", [
    ("numbers = { k = [1, 9], p = [2, 9] }", "numbers = { k = [9, 1], p = [2, 9] }", "k must be [low, high]"),
    ("numbers = { k = [1, 9], p = [2, 9] }", "numbers = { k = 3, p = [2, 9] }", "k must be [low, high]"),
    ("numbers = { k = [1, 9], p = [2, 9] }", "", "An exam needs numbers"),
    ('answer = "product-k"', 'answer = "product-q"', "“product-q” is no formula"),
    ('answer = "product-k"', 'answer = "__import__(1)"', "is no formula"),
    ('answer = "product-k"', 'answer = "1/0"', "gives a fit answer"),
    ('digits = "2 decimals"', 'digits = "many"', "digits must be"),
    ('id = "gain"', 'id = "loss"', "“## exam loss: title”"),
    ('set = { k = "p/10" }', 'set = { stiff = "p/10" }', "There is no knob stiff"),
    ('set = { k = "p/10" }', 'set = { q = "p/10" }', "q is no number that an exam can set"),
    ('steps = { product = "p*(p+1)" }', 'steps = { prod = "p*(p+1)" }', "[[product]], which is none of k, p, prod, answer"),
])
def test_a_wrong_exam_is_one_sentence(whole: Path, old: str, new: str, said: str) -> None:
    changed(whole / "lesson.toml", old, new)
    told = refused(whole)
    assert said in told and re.match(r"lesson\.toml, line \d+: ", told)


# --- one file for colleagues -----------------------------------------------------------------------------------------
def test_a_zip_is_the_same_each_time_and_a_server_opens_it(whole: Path, packed: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.zip"
    assert main(["list", "--lessons", str(whole.parent), "--zip", str(again)]) == 0
    assert again.read_bytes() == packed.read_bytes()
    opening = opening_of(ServeRequest(lessons=str(packed)))
    assert opening.lesson == whole.name and not opening.lessons[whole.name].fault.id


def test_a_broken_lesson_and_one_with_code_are_not_packed(whole: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (whole / "plant.py").write_text("x = 1\n", encoding="utf-8")
    assert main(["list", "--lessons", str(whole.parent), "--zip", str(tmp_path / "a.zip")]) == 2
    assert "plant.py" in capsys.readouterr().err and not (tmp_path / "a.zip").exists()
    (whole / "plant.py").unlink()
    (whole / "lesson.toml").write_text("broken", encoding="utf-8")
    assert main(["list", "--lessons", str(whole.parent), "--zip", str(tmp_path / "a.zip")]) == 2
    assert "cannot be read" in capsys.readouterr().err


@pytest.mark.parametrize("name, content, said", [
    ("../out/lesson.toml", b"x", "a lesson is a folder with files"), ("/abs/lesson.toml", b"x", "a lesson is a folder with files"),
    ("a/../b/lesson.toml", b"x", "a lesson is a folder with files"), ("..", b"x", "a lesson is a folder with files"),
    ("tank/code.py", b"import os", "no code"), ("tank/lesson.toml", b"0" * 1_000_001, "too large"),
    ("lesson.toml", b"x", "a lesson is a folder")])
def test_a_hostile_zip_is_refused_in_one_sentence(tmp_path: Path, name: str, content: bytes, said: str,
                                                  capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "bad.zip"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr(name, content)
    assert main(["list", "--lessons", str(file)]) == 2
    told = capsys.readouterr().err
    assert said in told and told.count("\n") == 1
    assert not (tmp_path.parent / "out").exists()


def test_what_is_no_zip_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "bad.zip"
    file.write_bytes(b"PK but no zip")
    assert main(["list", "--lessons", str(file)]) == 2
    assert "cannot be opened as a .zip of lessons" in capsys.readouterr().err


def test_a_zip_with_a_folder_around_its_lessons_is_read(packed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outer = tmp_path / "outer.zip"
    with zipfile.ZipFile(packed) as source, zipfile.ZipFile(outer, "w") as target:
        for entry in source.infolist():
            target.writestr(f"my-lessons/{entry.filename}", source.read(entry))
    assert main(["list", "--json", "--lessons", str(outer)]) == 0
    assert len(json.loads(capsys.readouterr().out)) == 22
