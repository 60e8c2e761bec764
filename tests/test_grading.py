"""Course files from the command line, `variant` and `grade`: one sentence for each mistake, and tables that platforms import."""

from __future__ import annotations

import csv
import json
from inspect import cleandoc
from pathlib import Path

import pytest
from commands import refused
from course_makers import COURSE, EXAM, TASK, course_of, right_answer, token

from observer_lab.cli.courses import course_in
from observer_lab.cli.entry import main
from observer_lab.course.handin import course_file
from observer_lab.course.handin.grading import canvas_table, moodle_table
from observer_lab.course.handin.hand_in import HandIn, write_hand_in
from observer_lab.course.handin.served_course import student_item
from observer_lab.lessons import LESSONS

FILE = """
course = "filtering-2026"
secret-file = "the.secret"
deadline = 2026-12-18T23:59:00+01:00

[[lessons]]
lesson = "kalman"
exams = ["sheet", "nis"]
tasks = "all"
points = 2.5
"""
SECRET = "3f1c0e5a6b7d8c9e0f1a2b3c4d5e6f70"
ON_TIME, LATE = 1_790_000_000, 1_800_000_000


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "the.secret").write_text(f"{SECRET}\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    path = Path("course.toml")
    path.write_text(FILE, encoding="utf-8")
    return path


def answer(file: Path, student: str, exam_id: str = "sheet") -> str:
    exam = next(exam for exam in LESSONS["kalman"].exams if exam.id == exam_id)
    return exam.digits.written(student_item(course_in(str(file)), student, "kalman", exam).answer)


def signed(file: Path, student: str, said: str, exam: str = "sheet", issued: int = ON_TIME) -> str:
    course = course_in(str(file))
    return write_hand_in(course, HandIn(course.id, f"kalman exam {exam}", student, said, issued))


# --- course files --------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("old", "new", "says"), [
    ('course = "filtering-2026"', "course = ", "(at line 2"),
    ('course = "filtering-2026"', "", "course must be a name"),
    ('course = "filtering-2026"', 'course = "a b"', "course must be a name"),
    ('course = "filtering-2026"', 'course = "a"\ntitle = 3', "title must be a text"),
    ('course = "filtering-2026"', 'course = "a"\ntirade = 3', "tirade is no key"),
    ('secret-file = "the.secret"', "", "secret or secret-file must be given"),
    ('secret-file = "the.secret"', 'secret-file = "none"', "secret file"),
    ('secret-file = "the.secret"', 'secret = "0123456789abcdef"', "secret must hold at least 20"),
    ('secret-file = "the.secret"', "secret = 3", "secret must be a text"),
    ("2026-12-18T23:59:00+01:00", "2026-12-18T23:59:00", "deadline must be a date and time with its distance from UTC"),
    ("2026-12-18T23:59:00+01:00", '"soon"', "deadline must be"),
    ('lesson = "kalman"', 'lesson = "calman"', "lesson 1, lesson names no lesson (calman)"),
    ('lesson = "kalman"', "", "lesson 1, lesson names no lesson"),
    ('["sheet", "nis"]', '["sheet", "nip"]', "lesson 1, exams names nip"),
    ('["sheet", "nis"]', "3", "lesson 1, exams must be a list"),
    ('["sheet", "nis"]', '["sheet", "sheet"]', "lesson 1, exams names sheet of kalman a second time"),
    ("points = 2.5", "points = 0", "lesson 1, points must be a positive number"),
    ("points = 2.5", "tries = 1.5", "lesson 1, tries must be a whole number"),
    ("points = 2.5", "tries = true", "lesson 1, tries must be a whole number"),
    ("points = 2.5", 'mode = "open"', "lesson 1, mode must be"),
    ("points = 2.5", "point = 2", "lesson 1, point is no key"),
    ("[[lessons]]", "[lessons]", "lessons is missing"),
    ('exams = ["sheet", "nis"]\ntasks = "all"', "", "lesson 1, exams and tasks are missing"),
])
@pytest.mark.parametrize("command", [("grade", "olh1.x.y"), ("variant", "s1"), ("serve", "--port", "0")])
def test_a_bad_course_file_is_one_sentence_with_file_and_key(capsys, file: Path, command: tuple[str, ...], old: str, new: str,
                                                             says: str) -> None:
    assert old in FILE
    file.write_text(FILE.replace(old, new), encoding="utf-8")
    said = refused(capsys, *command, "--course", str(file))
    assert says in said and ("course.toml" in said or "none" in said) and "0123456789abcdef" not in said


@pytest.mark.parametrize("page", ["README.md", "course_file.py"])
def test_a_course_file_that_a_reader_copies_can_be_read(page: str) -> None:
    readme = (Path(__file__).parent.parent / "README.md").read_text("utf-8")
    shown = readme if page == "README.md" else cleandoc(course_file.__doc__ or "").replace("\n    ", "\n") + "```"
    text = shown[shown.index('course = "'):].partition("```")[0]
    assert course_file.read_course(text, LESSONS, lambda _: SECRET).items


def test_serve_takes_a_course_or_exam(capsys, file: Path) -> None:
    assert "--course without --exam" in refused(capsys, "serve", "--port", "0", "--exam", "--course", str(file))


def test_what_a_lesson_says_stands_before_what_the_head_says() -> None:
    course = course_of(COURSE.replace("points = 5", 'points = 5\ntries = 7\ndeadline = 2026-01-01T00:00:00Z'))
    toy, drill = course.item("exam", "toy", "twice"), course.item("exam", "drill", "twice")
    assert toy is not None and (toy.tries, toy.points, toy.practice) == (7, 5.0, False) and str(toy.deadline).startswith("2026-01-01")
    assert drill is not None and (drill.tries, drill.points, drill.practice) == (2, 1.0, True)
    assert str(drill.deadline).startswith("2026-09-21")
    assert list(course.items) == [EXAM, TASK, "drill exam twice", "drill task high"]


# --- variant -------------------------------------------------------------------------------------------------------
def test_variant_prints_anybodys_items_with_answers(capsys, file: Path) -> None:
    assert main(["variant", " S1 ", "--course", str(file)]) == 0
    told = capsys.readouterr().out
    for exam in ("sheet", "nis"):
        assert f"## {LESSONS['kalman'].words['en'].exams[exam].title}\n" in told and f"\n**{answer(file, 's1', exam)}**\n" in told
    assert "[[" not in told and told.count("## ") == 2 and SECRET not in told
    assert main(["variant", "s1", "--course", str(file), "--lesson", "kalman", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert [item["answer"] for item in record["items"]] == [answer(file, "s1", exam) for exam in ("sheet", "nis")]
    assert "no exam here" in refused(capsys, "variant", "s1", "--course", str(file), "--lesson", "lqg")
    assert "is empty" in refused(capsys, "variant", "  ", "--course", str(file))


def test_exam_without_the_course_prints_other_numbers(capsys, file: Path) -> None:
    assert main(["exam", "kalman", "--key", "s1"]) == 0
    printed = capsys.readouterr().out
    assert main(["variant", "s1", "--course", str(file)]) == 0
    ours = capsys.readouterr().out
    assert not [part for part in ours.split("## ") if part and part in printed]


# --- grade ---------------------------------------------------------------------------------------------------------
def test_grade_names_each_kind_and_writes_both_tables(capsys, file: Path, tmp_path: Path) -> None:
    right, wrong = signed(file, "S1", answer(file, "S1")), signed(file, "s2", "-1000")
    foreign, late, none = token(course_of(), "s1"), signed(file, "s1", "1", "nis", LATE), signed(file, "s1", "1", "none")
    tokens = [right, wrong, right, late, right[:-3] + "AAA", foreign, none]
    (tmp_path / "all.txt").write_text("Dear lecturer,\n" + "\n".join(tokens), encoding="utf-8")
    out = tmp_path / "grades.csv"
    assert main(["grade", str(tmp_path / "all.txt"), "--course", str(file), "-o", str(out)]) == 1
    told = capsys.readouterr().out
    assert told.startswith("hand-ins: 7, counted: 2, students: 2; not counted: ")
    for kind in ("doubled", "late", "forged", "another course", "not asked"):
        assert told.count(f"  {kind}: ") == 1
    names = ["kalman exam sheet", "kalman exam nis", *(f"kalman task {task.id}" for task in LESSONS["kalman"].tasks)]
    with out.open(encoding="utf-8", newline="") as moodle:
        none = ["-"] * (len(names) - 1)
        assert list(csv.reader(moodle)) == [["ID number", *names], ["S1", "2.5", *none], ["s2", "0", *none]]
    with (tmp_path / "grades-canvas.csv").open(encoding="utf-8", newline="") as canvas:
        rows = list(csv.reader(canvas))
    assert rows[0] == ["Student", "ID", "SIS User ID", "SIS Login ID", "Section", *names]
    assert rows[1] == ["Points Possible", "", "", "", "", *["2.5"] * len(names)]
    assert rows[2] == ["S1", "", "S1", "S1", "", "2.5", *[""] * (len(names) - 1)] and len(rows) == 4


def test_grade_is_status_0_where_all_count_and_json_says_all(capsys, file: Path) -> None:
    right = signed(file, "s1", answer(file, "s1"))
    assert main(["grade", right, "--course", str(file), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["points"] == {"s1": {"kalman exam sheet": 2.5}} and record["hand_ins"][0]["verdict"] == "counts"


def test_grade_takes_a_folder_with_anything_in_it(capsys, file: Path, tmp_path: Path) -> None:
    folder = tmp_path / "in"
    (folder / "s1").mkdir(parents=True)
    (folder / "s2").mkdir()
    (folder / "s1" / "onlinetext.html").write_text(f"<p>{signed(file, 's1', answer(file, 's1'))}</p>", encoding="utf-8")
    (folder / "s2" / "photo.jpg").write_bytes(b"\xff\xd8\xff\xe0" * 100)
    (folder / "s2" / "empty.txt").write_bytes(b"")
    (folder / "s2" / "a\x1b[31mb.txt").write_bytes(b"")
    (folder / "s2" / "colour.txt").write_text("\x1b[31m" + "A" * 60, encoding="utf-8")
    assert main(["grade", str(folder), "--course", str(file)]) == 1
    told = capsys.readouterr().out
    assert "hand-ins: 5, counted: 1, students: 1; not counted: 4 forged\n" in told and "\x1b" not in told
    assert all(name in told for name in ("photo.jpg", "empty.txt", "colour.txt"))


@pytest.mark.parametrize("words", [("none.txt",), ("course.toml", "none.txt")])
def test_a_file_that_is_not_there_is_one_sentence(capsys, file: Path, words: tuple[str, ...]) -> None:
    assert "none.txt" in refused(capsys, "grade", *words, "--course", str(file))


def test_tables_hold_only_what_is_handed_in() -> None:
    course = course_of()
    assert right_answer(course, "s1") and moodle_table(course, {}) == f"ID number,{EXAM},{TASK}\r\n"
    assert canvas_table(course, {"s1": {TASK: 5.0}}).splitlines()[2] == "s1,,s1,s1,,,5"
