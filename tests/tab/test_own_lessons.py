"""A person's own .zip of lessons: it opens in its tab alone and comes back after a reload; a hostile one is refused."""

from __future__ import annotations

import io
import json
import stat
import struct
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from fakes import Clock, FakeView, toy
from own_lessons import first_files, whole_files, zipped
from test_own_records import AtOnce

from observer_lab.lessons.from_files.packed import MAX_FILES, MAX_UPLOADED_LESSONS, uploaded_lessons
from observer_lab.session.commands.commands import Command, OpenLesson, SetKnobs
from observer_lab.session.commands.files import ClearBrowser, LessonsChanged, UploadLessons
from observer_lab.session.handlers.lesson_reload import BEING_READ, LOST, NOT_KEPT, NOT_TAKEN, TOO_LARGE
from observer_lab.session.runtime import watchdog
from observer_lab.session.session import Session
from observer_lab.session.state.own_lessons import MAX_KEPT_ZIP_BYTES, MAX_ZIP_BYTES, ReadLessons, read_zip, write_zip

TWO = {id: first_files(id) for id in ("big-tank", "leaky-tank")}


class OwnTab:
    """A tab of a server that takes lessons, with what its browser keeps."""

    def __init__(self, view: FakeView | None = None, read: ReadLessons | None = uploaded_lessons) -> None:
        self.view = view or FakeView()
        self.session = Session({"toy": toy(), "kalman": toy("kalman")}, self.view, "toy", clock=Clock(), read_lessons=read)
        self.session._begin()

    def do(self, command: Command | SetKnobs) -> None:
        self.session.post(command)
        for _ in range(3):  # what a job has found is posted
            self.session.step(0.0)

    def upload(self, content: object, name: object = "mine.zip") -> None:
        self.do(UploadLessons(name, content))

    @property
    def lesson(self) -> str:
        assert self.session.picture is not None
        return self.session.picture.lesson.id

    @property
    def catalogue(self) -> list[str]:
        assert self.session.picture is not None
        return [lesson.id for lesson in self.session.picture.catalogue]

    @property
    def scolded(self) -> str:
        return " ".join(words("en") for words in self.view.scolded())

    def loaded_again(self, keeps_file: bool = True, read: ReadLessons | None = uploaded_lessons) -> OwnTab:
        """The tab after a reload."""
        view = FakeView(kept=self.view.kept)
        view.zipped = self.view.zipped if keeps_file else ""
        return OwnTab(view, read)


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("observer_lab.session.session.BackgroundJobs", AtOnce)


def test_an_upload_opens_its_first_lesson_in_this_tab_alone() -> None:
    tab, other = OwnTab(), OwnTab()
    tab.upload(zipped(TWO))
    assert tab.lesson == "big-tank" and tab.catalogue == ["toy", "kalman", "big-tank", "leaky-tank"]
    assert not tab.view.scolded() and other.catalogue == ["toy", "kalman"]
    tab.do(OpenLesson("leaky-tank"))
    assert tab.lesson == "leaky-tank"
    other.do(OpenLesson("leaky-tank"))
    assert other.lesson == "toy" and "no lesson" in other.scolded


def test_a_server_that_does_not_allow_it_takes_none() -> None:
    tab = OwnTab(read=None)
    tab.upload(zipped(TWO))
    assert tab.view.scolded() == [NOT_TAKEN] and tab.catalogue == ["toy", "kalman"]


def test_each_lesson_is_judged_alone() -> None:
    wrong = {**first_files("wrong"), "lesson.toml": first_files("wrong")["lesson.toml"].replace("kind =", "kin =")}
    tab = OwnTab()
    tab.upload(zipped({"a-wrong": wrong, **TWO}))
    assert tab.lesson == "big-tank" and "a-wrong" in tab.catalogue
    assert len(tab.view.scolded()) == 1 and "lesson.toml, line" in tab.scolded and "kin" in tab.scolded
    tab.do(OpenLesson("a-wrong"))
    assert tab.session.picture is not None and "kin" in tab.session.picture.lesson.fault("en")
    tab.upload(zipped({"a-wrong": wrong, "b-wrong": wrong, **TWO}))
    assert "2 of 4 lessons" in tab.scolded and tab.lesson == "a-wrong"


def test_a_second_file_takes_the_place_of_the_first_and_keeps_what_fits() -> None:
    tab = OwnTab()
    tab.upload(zipped(TWO))
    tab.do(OpenLesson("leaky-tank"))
    tab.do(SetKnobs({"first": 1.25}))
    tab.session._show.remember()
    other = first_files("leaky-tank")["lesson.toml"].replace("seconds = 12.0", "seconds = 6.0")
    tab.upload(zipped({"leaky-tank": {**first_files("leaky-tank"), "lesson.toml": other}, "third": first_files("third")}))
    assert tab.lesson == "leaky-tank" and tab.catalogue == ["toy", "kalman", "leaky-tank", "third"]
    assert tab.session.picture is not None and tab.session.picture.horizon == 6.0 and tab.session.picture.design["first"] == 1.25
    tab.upload(zipped({"fourth": first_files("fourth")}))
    assert tab.lesson == "fourth" and tab.catalogue == ["toy", "kalman", "fourth"]


def test_a_file_that_cannot_be_read_leaves_what_was_open() -> None:
    tab = OwnTab()
    tab.upload(zipped(TWO))
    tab.upload(b"PK no zip")
    assert tab.lesson == "big-tank" and tab.catalogue[2:] == ["big-tank", "leaky-tank"] and "cannot be opened" in tab.scolded


class Later(AtOnce):
    """Background jobs that are never done."""

    def send(self, job: Callable[[], object]) -> bool:
        return True


def test_a_second_file_waits_until_the_first_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("observer_lab.session.session.BackgroundJobs", Later)
    tab = OwnTab()
    tab.upload(zipped(TWO))
    tab.upload(zipped(TWO))
    assert tab.view.scolded() == [BEING_READ] and tab.catalogue == ["toy", "kalman"]


# --- reloads -------------------------------------------------------------------------------------------------------
def test_a_reload_brings_lessons_and_work_back() -> None:
    tab = OwnTab()
    tab.upload(zipped({**TWO, "whole": whole_files("whole")}))
    tab.do(OpenLesson("whole"))
    tab.do(SetKnobs({"k": 1.5}))
    tab.session._show.remember()
    again = tab.loaded_again()
    assert again.lesson == "whole" and again.catalogue == tab.catalogue and not again.view.sentences()
    assert again.session.picture is not None and again.session.picture.design["k"] == 1.5


def test_a_reload_without_the_file_says_so_until_it_is_given_again() -> None:
    tab = OwnTab()
    tab.upload(zipped(TWO))
    tab.do(SetKnobs({"first": 1.25}))
    tab.session._show.remember()
    again = tab.loaded_again(keeps_file=False).loaded_again(keeps_file=False)
    assert again.lesson == "toy" and again.view.sentences() == [LOST.format(file="mine.zip")]
    again.upload(zipped(TWO))
    assert again.lesson == "big-tank"
    assert again.session.picture is not None and again.session.picture.design["first"] == 1.25


def test_a_file_that_is_too_large_to_keep_is_said_to_be() -> None:
    rest = "\n".join(f"# {number**9:x}" for number in range(1, 40_000))[:900_000]
    files = first_files("big-tank")
    large = zipped({"big-tank": {**files, "lesson.zh.md": f"{files['lesson.md']}\n\n{rest}"}})
    assert MAX_KEPT_ZIP_BYTES < len(large) <= MAX_ZIP_BYTES
    tab = OwnTab()
    tab.upload(large)
    assert not tab.view.zipped and NOT_KEPT.format(file="mine.zip", most=MAX_KEPT_ZIP_BYTES / 1e3) in tab.view.sentences()
    assert tab.loaded_again().view.sentences() == [LOST.format(file="mine.zip")]


def test_a_server_that_takes_none_any_more_says_so_after_a_reload() -> None:
    tab = OwnTab()
    tab.upload(zipped(TWO))
    again = tab.loaded_again(read=None)
    assert again.lesson == "toy" and again.view.sentences() == [NOT_TAKEN]


@pytest.mark.parametrize("kept", ['["a.zip", "no base64"]', '["a.zip"]', "[" * 10_000, "7", '["a.zip", "UEs="]'])
def test_a_browser_that_keeps_nonsense_costs_a_sentence(kept: str) -> None:
    view = FakeView()
    view.zipped = kept
    tab = OwnTab(view)
    assert tab.lesson == "toy" and tab.session._show.recalled and len(tab.view.sentences()) <= 1


def test_what_a_browser_keeps_reads_back() -> None:
    assert read_zip(write_zip("课.zip", b"\x00PK")) == ("课.zip", b"\x00PK")
    assert write_zip("a.zip", bytes(MAX_KEPT_ZIP_BYTES + 1)) == ""


def test_clearing_the_browser_takes_the_lessons_away() -> None:
    tab = OwnTab()
    tab.upload(zipped(TWO))
    tab.do(ClearBrowser())
    assert tab.lesson == "toy" and tab.catalogue == ["toy", "kalman"]


def test_changed_lessons_of_the_server_leave_own_ones_alone() -> None:
    tab = OwnTab()
    tab.upload(zipped(TWO))
    tab.do(LessonsChanged({"big-tank": toy("big-tank")}))
    assert tab.session.picture is not None and tab.session.picture.lesson.knobs[0].name == "q"


# --- attacks -------------------------------------------------------------------------------------------------------
def entry(name: str, content: bytes, kind: int = zipfile.ZIP_DEFLATED, mode: int = 0o644) -> bytes:
    """A .zip with a good lesson and one entry more."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for file, words in first_files("good").items():
            packed.writestr(f"good/{file}", words)
        info = zipfile.ZipInfo(name)
        info.external_attr = mode << 16
        packed.writestr(info, content, kind)
    return out.getvalue()


def bomb() -> bytes:
    return entry("bad/lesson.toml", bytes(200_000_000))


def bomb_of_many() -> bytes:
    return zipped({f"l{k}": {f"{n}.md": "0" * 999_000 for n in range(2)} for k in range(12)})


def encrypted() -> bytes:
    whole = bytearray(entry("bad/lesson.toml", b"x"))
    for mark, flags in ((b"PK\x01\x02", 8), (b"PK\x03\x04", 6)):
        place = whole.rfind(mark) + flags
        whole[place] |= 1
    return bytes(whole)


def damaged() -> bytes:
    whole = bytearray(entry("bad/lesson.toml", bytes(range(256)) * 40))
    place = whole.rfind(b"PK\x03\x04") + 30 + len("bad/lesson.toml")
    whole[place:place + 8] = b"\xff" * 8
    return bytes(whole)


def wrong_name() -> bytes:
    return entry("bäd/lesson.toml", b"x").replace("ä".encode(), b"\xff\xff")


def endless() -> bytes:
    """An entry that says it is small, and a directory that says there are four thousand million of them."""
    whole = bytearray(entry("bad/lesson.toml", b"x"))
    whole[whole.rfind(b"PK\x05\x06") + 8:][:4] = struct.pack("<HH", 0xFFFF, 0xFFFF)
    place = whole.rfind(b"PK\x05\x06") + 8
    whole[place:place + 4] = struct.pack("<HH", 0xFFFF, 0xFFFF)
    return bytes(whole[:-5])


ATTACKS: dict[str, tuple[Callable[[], bytes], str]] = {
    "bomb": (bomb, "too large"), "many large files": (bomb_of_many, "too large"),
    "path upwards": (lambda: entry("../../etc/lesson.toml", b"x"), "a lesson is a folder with files"),
    "absolute path": (lambda: entry("/etc/lesson.toml", b"x"), "a lesson is a folder with files"),
    "other slashes": (lambda: entry("..\\..\\lesson.toml", b"x"), "a lesson is a folder with files"),
    "code": (lambda: entry("bad/plant.py", b"import os"), "no code"), "a page": (lambda: entry("bad/x.html", b"<script>"), "no code"),
    "a drawing": (lambda: entry("bad/x.svg", b"<svg onload=alert(1)>"), "no code"),
    "a thousand files": (lambda: zipped({"a": {f"{k}.md": "x" for k in range(1000)}}), "too many files"),
    "many lessons": (lambda: zipped({f"l{k}": {"lesson.toml": "x"} for k in range(MAX_UPLOADED_LESSONS + 1)}), "give it 1 to"),
    "no lesson": (lambda: zipped({"a": {"lesson.md": "x"}}), "0 lessons"),
    "encrypted": (encrypted, "cannot be opened"), "damaged": (damaged, "cannot be opened"), "wrong name": (wrong_name, "cannot be opened"),
    "lzma": (lambda: entry("bad/lesson.toml", b"x", zipfile.ZIP_LZMA), "cannot be opened"), "cut": (endless, "cannot be opened"),
    "nothing": (bytes, "cannot be opened"), "a picture": (lambda: b"\x89PNG\r\n" * 99, "cannot be opened")}


@pytest.mark.parametrize("attack", ATTACKS)
def test_a_hostile_file_costs_one_sentence(attack: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    make, said = ATTACKS[attack]
    tab = OwnTab()
    tab.upload(make())
    assert len(tab.view.scolded()) == 1 and said in tab.scolded, tab.scolded
    assert tab.lesson == "toy" and tab.catalogue == ["toy", "kalman"] and not list(tmp_path.iterdir())


def test_a_link_in_a_file_is_no_link(tmp_path: Path) -> None:
    secret = tmp_path / "secret.toml"
    secret.write_text("secret = 1\n", encoding="utf-8")
    tab = OwnTab()
    tab.upload(entry("bad/lesson.toml", str(secret).encode(), zipfile.ZIP_STORED, stat.S_IFLNK | 0o777))
    assert tab.lesson == "good" and len(tab.view.scolded()) == 1 and "secret = 1" not in tab.scolded


@pytest.mark.parametrize("files", [
    {"lesson.toml": "title = '\xe9'".encode("latin-1")}, {"lesson.toml": "a." * 20_000 + "b = 1"}, {"lesson.toml": "x = " + "[" * 9000},
    {"lesson.toml": "x = " + "9" * 100_000}, {"lesson.md": b"\xff\xfe"}, {"lesson.toml": ""}, {"lesson.toml": "\x00"},
    {"lesson.toml": first_files("bad")["lesson.toml"] + '[plant]\nfile = "../good/lesson.toml"\n'}])
def test_a_hostile_lesson_is_refused_alone(files: dict[str, str | bytes]) -> None:
    tab = OwnTab()
    tab.upload(zipped({"bad": {**first_files("bad"), **files}, "good": first_files("good")}))
    assert tab.lesson == "good" and tab.catalogue[2:] == ["bad", "good"] and len(tab.view.scolded()) == 1


def test_a_lesson_of_the_server_cannot_be_replaced() -> None:
    tab = OwnTab()
    before = tab.session._show.lessons["kalman"]
    tab.upload(zipped({"kalman": first_files("kalman"), "good": first_files("good")}))
    assert tab.session._show.lessons["kalman"] is before and set(tab.catalogue[2:]) == {"good", "kalman-broken"}
    assert "There is a lesson of this name already" in tab.scolded


HTML = ("<img src=x onerror=alert(1)>", "<script>alert(1)</script>", r"$\text{<svg/onload=alert(1)>}$", "</div>", "<!--", "<", "a <$k$",
        r"$\href{javascript:alert(1)}{x}$")


@pytest.mark.parametrize("html", HTML)
@pytest.mark.parametrize(("file", "place"), [("lesson.md", "How fast"), ("lesson.md", "- It decays faster"),
                                             ("lesson.toml", "observer poles")])
def test_words_with_html_are_refused_alone(html: str, file: str, place: str) -> None:
    files, put = first_files("bad"), html + place if file == "lesson.md" else html.replace("\\", "\\\\")
    assert place in files[file]
    tab = OwnTab()
    tab.upload(zipped({"bad": {**files, file: files[file].replace(place, put)}, "good": first_files("good")}))
    assert tab.lesson == "good" and "may begin HTML" in tab.scolded and len(tab.view.scolded()) == 1
    lesson = tab.session._show.lessons["bad"]
    assert all("<" not in prose.introduction for prose in lesson.words.values())


@pytest.mark.parametrize("name", ['a" onclick="alert(1)', "a'b", "a>b", "x" * 200])
def test_an_id_that_would_leave_its_attribute_is_refused(name: str) -> None:
    files = first_files("bad")
    hostile = files["lesson.toml"].replace('kind = "error"', f'kind = "error"\nid = {json.dumps(name)}')
    tab = OwnTab()
    tab.upload(zipped({"bad": {**files, "lesson.toml": hostile}, "good": first_files("good")}))
    assert hostile != files["lesson.toml"] and tab.lesson == "good" and len(tab.view.scolded()) == 1


@pytest.mark.parametrize("content, name", [(7, "a.zip"), (None, "a.zip"), (b"x", 7), ("x", "a.zip")])
def test_what_is_no_file_is_refused(content: object, name: object) -> None:
    tab = OwnTab()
    tab.upload(content, name)
    assert len(tab.view.scolded()) == 1 and tab.catalogue == ["toy", "kalman"]


def test_a_file_beyond_the_bound_is_not_opened() -> None:
    tab = OwnTab()
    tab.upload(bytes(MAX_ZIP_BYTES + 1))
    assert tab.view.scolded() == [TOO_LARGE]


def test_a_lesson_that_does_not_end_is_broken_off(monkeypatch: pytest.MonkeyPatch) -> None:
    def slow(name: str, content: bytes, taken: tuple[str, ...]) -> Iterator[object]:
        end = time.monotonic() + 30
        while time.monotonic() < end:
            pass
        yield toy("never")
    monkeypatch.setattr("observer_lab.session.session.WATCHDOG", watchdog.Watchdog(longest=0.3))
    tab = OwnTab(read=slow)
    began = time.monotonic()
    tab.upload(b"x")
    assert time.monotonic() - began < 10 and "broken off" in tab.scolded and tab.catalogue == ["toy", "kalman"]


def test_there_is_room_for_as_many_files_as_a_zip_may_hold() -> None:
    files = {f"{k}.md": "x" for k in range(MAX_FILES - 2)}
    tab = OwnTab()
    tab.upload(zipped({"good": {**first_files("good"), **files}}))
    assert tab.lesson == "good"
