"""A course of thirty students, three of whom cheat: everybody has the points of their own answers, and each trick is named."""

from __future__ import annotations

import csv
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from commands import refused
from course_makers import COURSE, DEADLINE, EXAM, course_of, right_answer, served, token, toys, word
from fakes import Tab

from observer_lab.cli.entry import main
from observer_lab.cli.hand_in_places import HandInPlaces
from observer_lab.course.handin.course_file import Course
from observer_lab.course.handin.grading import Finding, Refusal, best_points, grade, sources_of_students
from observer_lab.course.handin.ledger import Ledger
from observer_lab.course.handin.served_course import ServedCourse
from observer_lab.session.commands.exams import HandIn, SetKey, SetWord
from observer_lab.session.handlers.exams import NEEDS_WORD, TRIES_USED

HONEST = [f"s{number}" for number in range(27)]
MALLORY, TRUDY, OSCAR = "mallory", "trudy", "oscar"
WITHOUT_WORDS = COURSE.replace("tries = 2", "tries = 2\nwords = false")


def at_a_page(course: ServedCourse, student: str, said: list[str], typed: str | None = None) -> list[str]:
    """What the page signs for who types that key and that word."""
    tab = Tab(toys(), "toy", sealed=True, course=course)
    tab.do(SetKey(student))
    tab.do(SetWord(word(course.course, student) if typed is None else typed))
    signed = []
    for answer in said:
        tab.do(HandIn("exam", "twice", answer))
        signed.append(tab.picture.state.hand_ins.get(EXAM, ""))
    return [each for each in dict.fromkeys(signed) if each]


def answers(course: Course, student: str) -> list[str]:
    """Of three honest students one is right at once, one at the second try, one never."""
    right = right_answer(course, student)
    return [[right], ["-1000", right], ["-1000", "-2000"]][HONEST.index(student) % 3]


def handed_in(course: ServedCourse, folder: Path) -> None:
    """Everybody's folder. The cheats were first, so that what they have signed counts before the honest."""
    def give(student: str, tokens: list[str]) -> None:
        (folder / student).mkdir(parents=True, exist_ok=True)
        for number, each in enumerate(tokens):
            (folder / student / f"{number}.txt").write_text(each, encoding="utf-8")

    now = course.clock()
    early = ServedCourse(course.course, lambda: now - 600)
    victims = [student for student in HONEST if HONEST.index(student) % 3 == 0]
    spoilt = [each for victim in victims for each in at_a_page(early, victim, ["-1", "-2"], typed=word(course.course, MALLORY))]
    give(MALLORY, [*at_a_page(early, MALLORY, ["-3"]), *spoilt])
    for student in HONEST:
        give(student, at_a_page(course, student, answers(course.course, student)))
    copied = (folder / HONEST[0] / "0.txt").read_text(encoding="utf-8")
    give(TRUDY, [copied, *at_a_page(course, TRUDY, [right_answer(course.course, HONEST[0])])])
    forged = token(course_of(COURSE.replace("a secret of a course", "a guessed one, as long")), OSCAR, right_answer(course.course, OSCAR))
    give(OSCAR, [forged, *at_a_page(course, OSCAR, ["-4", "-5", right_answer(course.course, OSCAR)])])


def graded(course: Course, folder: Path, places: HandInPlaces) -> tuple[Finding, ...]:
    tokens = [(str(path), path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.txt"))]
    return grade(course, toys(), tokens, places.stranger)


@pytest.mark.parametrize("bound", ["words", "folders", "map"])
def test_thirty_students_and_three_cheats_are_graded_right(bound: str, tmp_path: Path) -> None:
    course = served(words=COURSE if bound == "words" else WITHOUT_WORDS)
    folder, table = tmp_path / "in", tmp_path / "map.csv"
    handed_in(course, folder)
    table.write_text("".join(f"{who},{who.upper()}\n" for who in (*HONEST, MALLORY, TRUDY, OSCAR)), encoding="utf-8")
    places = HandInPlaces.of([str(folder)], bound == "folders", str(table) if bound == "map" else None)
    found = graded(course.course, folder, places)
    points = best_points(course.course, found)
    assert {who: points[who] for who in HONEST} == {who: {EXAM: 0.0 if HONEST.index(who) % 3 == 2 else 5.0} for who in HONEST}
    assert {points[who][EXAM] for who in (MALLORY, TRUDY, OSCAR)} == {0.0}
    kinds = [(one.refusal, Path(one.source).parent.name) for one in found if one.refusal is not None]
    assert (Refusal.FORGED, OSCAR) in kinds and (Refusal.DOUBLED, OSCAR) in kinds
    if bound == "words":
        assert (Refusal.DOUBLED, TRUDY) in kinds and sources_of_students(found, places.place) == {HONEST[0]: (HONEST[0], TRUDY)}
    else:
        assert kinds.count((Refusal.OTHER_STUDENT, MALLORY)) == 18 and (Refusal.OTHER_STUDENT, TRUDY) in kinds


def test_without_any_binding_grade_says_so_and_names_the_two_places(tmp_path: Path) -> None:
    course = served(words=WITHOUT_WORDS)
    handed_in(course, tmp_path)
    places = HandInPlaces.of([str(tmp_path)])
    several = sources_of_students(graded(course.course, tmp_path, places), places.place)
    assert all(several[who] == (MALLORY, who) for who in HONEST[3::3])


@pytest.mark.parametrize("typed", ["", "guess-gues", "s1"])
def test_no_answer_is_signed_or_noted_under_a_key_without_its_word(typed: str) -> None:
    course = served()
    tab = Tab(toys(), "toy", sealed=True, course=course)
    tab.do(SetKey("s1"))
    tab.do(SetWord(typed))
    tab.do(HandIn("exam", "twice", "1"))
    assert tab.view.scolded()[-1] == NEEDS_WORD and not tab.picture.state.hand_ins and not tab.picture.state.exams


def test_a_word_is_taken_as_people_type_it() -> None:
    course = course_of()
    mine = word(course, "s1")
    misread = mine.replace("o", "0").replace("l", "1").replace("b", "8")
    for typed in (mine, mine.upper(), mine.replace("-", " "), f"  {mine} ", misread):
        assert course.keys.knows("s1", typed)
    assert not course.keys.knows("s2", mine) and len({word(course, f"s{k}") for k in range(1000)}) == 1000


def test_the_server_signs_as_often_as_counts_and_the_same_answer_once(tmp_path: Path) -> None:
    course = ServedCourse(course_of(), lambda: DEADLINE - 60, Ledger(tmp_path))
    first = at_a_page(course, "s1", ["1", "1"])
    assert len(first) == 1 and at_a_page(course, " S1", ["1"]) == first
    assert len(at_a_page(ServedCourse(course.course, course.clock, Ledger(tmp_path)), "s1", ["2"])) == 1
    tab = Tab(toys(), "toy", sealed=True, course=course)
    tab.do(SetKey("s1"))
    tab.do(SetWord(word(course.course, "s1")))
    tab.do(HandIn("exam", "twice", "3"))
    assert tab.view.scolded()[-1] == TRIES_USED and not tab.picture.state.hand_ins
    assert at_a_page(course, "s2", ["3"])


def test_where_nothing_can_be_kept_it_is_signed_all_the_same_and_said(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    course, kept = ServedCourse(course_of(), lambda: DEADLINE - 60, ledger), (tmp_path / "course.sqlite").read_bytes()
    (tmp_path / "course.sqlite").write_bytes(b"no database at all" * 100)
    assert len(at_a_page(course, "s1", ["1"])) == 1 and ledger.failing
    (tmp_path / "course.sqlite").write_bytes(kept)
    assert len(at_a_page(course, "s2", ["1"])) == 1 and not ledger.failing


def test_the_file_of_the_version_before_is_taken_over_and_one_of_a_later_version_refused(tmp_path: Path) -> None:
    """The schema as fbea0ee wrote it, into lti.sqlite."""
    with closing(sqlite3.connect(tmp_path / "lti.sqlite")) as database, database:
        database.executescript("""
            CREATE TABLE nonces (nonce TEXT PRIMARY KEY, used INTEGER NOT NULL) WITHOUT ROWID;
            CREATE TABLE hand_ins (number INTEGER PRIMARY KEY, student TEXT NOT NULL, token TEXT NOT NULL UNIQUE);
            CREATE INDEX of_student ON hand_ins (student);
            CREATE TABLE reports (id INTEGER PRIMARY KEY CHECK (id = 1), ms INTEGER NOT NULL);
            INSERT INTO reports VALUES (1, 5000);
            INSERT INTO hand_ins (student, token) VALUES ('s1', 'a'), ('s2', 'b'), ('s1', 'c');""")
    assert Ledger(tmp_path).add("s1", "d", 1.0) == (["a", "c", "d"], 5001)
    with closing(sqlite3.connect(tmp_path / "course.sqlite")) as database, database:
        assert database.execute("PRAGMA user_version").fetchone() == (1,) and not (tmp_path / "lti.sqlite").exists()
        database.execute("PRAGMA user_version = 2")
    with pytest.raises(sqlite3.Error, match="later version"):
        Ledger(tmp_path)


# --- the command line ----------------------------------------------------------------------------------------------
FILE = 'course = "c"\nsecret = "a secret of a course, for tests alone"\n[[lessons]]\nlesson = "kalman"\nexams = "all"\n'


def test_variant_prints_the_words_of_a_list_of_keys(capsys, tmp_path: Path) -> None:
    file, keys = tmp_path / "course.toml", tmp_path / "keys.txt"
    file.write_text(FILE, encoding="utf-8")
    keys.write_text("s1\n\n李伟\n", encoding="utf-8")
    assert main(["variant", str(keys), "--words", "--course", str(file)]) == 0
    rows = list(csv.reader(capsys.readouterr().out.splitlines()))
    assert [row[0] for row in rows] == ["key", "s1", "李伟"] and len({row[1] for row in rows}) == 3
    assert main(["variant", "S1", "--words", "--course", str(file)]) == 0
    assert capsys.readouterr().out.splitlines()[1] == f"S1,{rows[1][1]}"
    keys.write_text("=1+1\n", encoding="utf-8")
    assert "is no key" in refused(capsys, "variant", str(keys), "--words", "--course", str(file))
    file.write_text(FILE.replace('"c"', '"c"\nwords = false'), encoding="utf-8")
    assert "words = false" in refused(capsys, "variant", "s1", "--words", "--course", str(file))


@pytest.mark.parametrize(("table", "says"), [("s1\n", "Line 1"), ("a,b\nc,\n", "Line 2"), ("a,b,c\n", "Line 1")])
def test_a_bad_map_is_one_sentence(capsys, tmp_path: Path, table: str, says: str) -> None:
    (tmp_path / "course.toml").write_text(FILE, encoding="utf-8")
    (tmp_path / "map.csv").write_text(table, encoding="utf-8")
    assert says in refused(capsys, "grade", "olh1.x.y", "--course", str(tmp_path / "course.toml"), "--map", str(tmp_path / "map.csv"))


@pytest.mark.parametrize(("source", "student", "whose"), [
    ("in/Carol Li_123_assignsubmission_file_/x.txt", "carol", True), ("in/Carol Li_123/x.txt", "carol", True),
    ("in/Carol Li_123_4/x.txt", "carol", True), ("in/Carol Li_1234/x.txt", "carol", False), ("in/dave.txt", "dave", True),
    ("in/dave.txt", "carol", False), ("in/none/x.txt", "carol", False)])
def test_a_map_reads_the_names_of_a_platforms_archive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str, student: str,
                                                      whose: bool) -> None:
    monkeypatch.chdir(tmp_path)
    Path("map.csv").write_text("\ufeffCarol Li_123_assignsubmission_file_;carol\ndave.txt;dave\n", encoding="utf-8")
    assert (HandInPlaces.of(["in"], table="map.csv").stranger(source, student) is None) is whose


@pytest.mark.parametrize(("source", "whose"), [("in/carol/x.txt", True), ("in/Carol/deep/x.txt", True), ("in/carol", False),
                                               ("in/mallory/carol/x.txt", False), ("carol/x.txt", False), ("command line", False)])
def test_only_a_folder_that_the_lecturer_named_makes_an_owner(source: str, whose: bool) -> None:
    assert (HandInPlaces.of(["in"], folders=True).stranger(source, "carol") is None) is whose


def test_a_course_of_lessons_of_ones_own_is_served_and_graded(capsys, tmp_path: Path) -> None:
    """The lesson that new-lesson writes has a task; its course file names it."""
    from observer_lab.cli.opening import ServeRequest, opening_of

    assert main(["new-lesson", "leaky", "--folder", str(tmp_path / "own")]) == 0 and capsys.readouterr().out
    for part, more in (("lesson.toml", '\n[[scenes]]\nid = "meet"\ndo = "play"\nfigures = ["error"]\n'
                        '[[tasks]]\nid = "settle"\nwithin = { settled = [0, 2.5], largest_gain = [0, 6] }\nsolution = { q = [-3, -3] }\n'),
                       ("lesson.md", "\n## task settle: Settle\nBring it below 2 %.\n- A hint.\n### solution\nBoth at -3.\n"
                                     "## scene meet: Meet it\nThe tank.\n### do\nPress *Play*.\n### say\nIt arrives.\n")):
        path = tmp_path / "own" / "leaky" / part
        path.write_text(path.read_text(encoding="utf-8") + more, encoding="utf-8")
    file, lecture = tmp_path / "course.toml", tmp_path / "lecture.toml"
    file.write_text('course = "c"\nsecret-file = "the.secret"\n[[lessons]]\nlesson = "leaky"\ntasks = "all"\n', encoding="utf-8")
    (tmp_path / "the.secret").write_text("a secret of a course, for tests alone", encoding="utf-8")
    (tmp_path / "the.secret").chmod(0o644)
    own = str(tmp_path / "own")
    assert "names no lesson" in refused(capsys, "grade", "olh1.x.y", "--course", str(file))
    opened = opening_of(ServeRequest(course=str(file), lessons=own, data_dir=str(tmp_path / "kept")))
    assert "chmod 600" in capsys.readouterr().err
    scene = opened.lessons["leaky"].path[0].id
    lecture.write_text(f'title = "T"\n[[stops]]\nlesson = "leaky"\nscene = "{scene}"\nminutes = 3\n', encoding="utf-8")
    talk = opening_of(ServeRequest(lecture=str(lecture), lessons=own)).talk
    assert talk is not None and talk.stops[0].lesson == "leaky"
    assert opened.course is not None
    (name, item), *_ = opened.course.course.items.items()
    signed = opened.course.hand_in(item, "s1", "solved", known=True)
    assert main(["grade", str(signed), "--course", str(file), "--lessons", own, "--json"]) == 0
    assert f'"{name}": 1' in capsys.readouterr().out
