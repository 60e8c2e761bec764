"""The problem sheet of `sheet`: the numbers of a key, no answer on it, the solutions apart, the same bytes each time."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from laws import each
from sampling import some

from observer_lab.cli.entry import main
from observer_lab.course.exercises.exam import seed_of
from observer_lab.course.handin.exam_sheet import exam_parts
from observer_lab.export.sheet import sheet as sheets
from observer_lab.lessons import LESSONS
from observer_lab.text import languages

LESSON_FILES = sorted((Path(__file__).parents[1] / "lessons").glob("*/lesson.toml"))
SAMPLED = ("virtual-sensor", "kalman", "bilinear-observer")


def printed(arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> list[tuple[bool, str]]:
    """What is set on the sheets of a call, and whether they are the solved ones."""
    found: list[tuple[bool, str]] = []

    def watched(title: str, key: str, problems: Any, solved: bool, language: str = "en") -> bytes:
        said: list[str] = []
        with monkeypatch.context() as patched:
            kept = sheets._Paper.say
            patched.setattr(sheets._Paper, "say", lambda self, words, *a, **k: (said.append(words), kept(self, words, *a, **k))[1])
            content = make(title, key, problems, solved, language)
        found.append((solved, "\n".join(said)))
        return content
    make = sheets.problem_sheet
    monkeypatch.setattr(sheets, "problem_sheet", watched)
    assert main(arguments) == 0
    return found


@each(("id", "language"), some("a sheet asks", [(id, language) for id in SAMPLED for language in languages()], 3))
def test_a_sheet_asks_with_the_numbers_of_a_key_and_answers_apart(id: str, language: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
                                                                  ) -> None:
    lesson = LESSONS[id]
    sheet, solved = tmp_path / "sheet.pdf", tmp_path / "solved.pdf"
    told = printed(["sheet", id, "--key", "s1", "--variant", "3", "--lang", language, "-o", str(sheet), "--solutions", str(solved)],
                   monkeypatch)
    assert [kind for kind, _ in told] == [False, True]
    for exam in lesson.exams:
        title, statement, solution = exam_parts(lesson, exam, exam.item(seed_of("s1", id, exam.id, 3)), language)
        assert statement in told[0][1] and title in told[0][1] and solution not in told[0][1]
        assert statement in told[1][1] and solution in told[1][1]
    assert sheet.read_bytes().startswith(b"%PDF") and len(re.findall(rb"/Type /Page\b", solved.read_bytes())) >= 1


def test_the_same_call_writes_the_same_bytes_and_another_key_others(tmp_path: Path) -> None:
    files = [tmp_path / f"{k}.pdf" for k in range(3)]
    for file, key in zip(files, ("s1", "s1", "s2"), strict=True):
        assert main(["sheet", "noise", "--key", key, "-o", str(file)]) == 0
    first, again, other = (file.read_bytes() for file in files)
    assert first == again != other


@pytest.mark.parametrize(("arguments", "words"), [
    (["nothing", "-o", "a.pdf"], "There is no lesson nothing"), (["-o", "a.pdf"], "There is no exam to print"),
    (["--course", "nothing", "-o", "a.pdf"], "there are first, estimation, platform"),
    (["--course", "nothing.toml", "-o", "a.pdf"], "course file"),
    (["noise", "-o", "a.txt"], "does not end in .pdf"), (["noise", "-o", "a.pdf", "--solutions", "b.doc"], "does not end in .pdf")])
def test_what_cannot_be_printed_is_said_in_a_sentence_and_nothing_is_written(arguments: list[str], words: str, tmp_path: Path,
                                                                            monkeypatch: pytest.MonkeyPatch,
                                                                            capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["sheet", *arguments]) == 2
    assert words in capsys.readouterr().err and not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["first", "estimation", "platform"])
def test_a_course_of_the_lab_is_printed_by_its_name(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The lessons are those whose `lesson.toml` names the course; one of them alone can be asked for."""
    table = {path.parent.name.replace("_", "-"): tomllib.loads(path.read_text(encoding="utf-8")) for path in LESSON_FILES}
    inside = [id for id in LESSONS if name in table[id].get("ways", ())]
    told = printed(["sheet", "--course", name, "--key", "s1", "-o", str(tmp_path / "sheet.pdf")], monkeypatch)[0][1]
    for id in LESSONS:
        for exam in LESSONS[id].exams:
            statement = exam_parts(LESSONS[id], exam, exam.item(seed_of("s1", id, exam.id, 1)), "en")[1]
            assert (statement in told) == (id in inside), (id, exam.id)
    assert len(inside) >= 4
    one = printed(["sheet", inside[1], "--course", name, "--key", "s1", "-o", str(tmp_path / "one.pdf")], monkeypatch)[0][1]
    assert LESSONS[inside[1]].words["en"].title in one or len(one) < len(told) / 2


def test_a_course_file_is_printed_by_its_name_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the file has the name of a course of the lab."""
    for name in ("own.toml", "first"):
        (tmp_path / "s.secret").write_text("ab" * 32)
        (tmp_path / name).write_text('course = "own"\nsecret-file = "s.secret"\n[[lessons]]\nlesson = "kalman"\nexams = ["nis"]\n')
        monkeypatch.chdir(tmp_path)
        told = printed(["sheet", "--course", name, "-o", "sheet.pdf"], monkeypatch)[0][1]
        assert LESSONS["kalman"].words["en"].exams["nis"].title in told and LESSONS["kalman"].words["en"].exams["sheet"].title not in told
