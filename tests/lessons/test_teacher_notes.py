"""The notes for teachers: each lesson has them in every language, in one form, and they call things as the page does."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

from laws import holds_for_all
from teacher_facts import FACTS, GIVEN

from observer_lab.course.knobs import Choice
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_notes
from observer_lab.lessons import LESSONS, folder
from observer_lab.text.languages import LOCALE_FOLDER
from observer_lab.text.message import label_in_language

TRANSLATED = sorted(path.name for path in LOCALE_FOLDER.iterdir() if path.is_dir())
SECTIONS = ("Aim", "Time", "Ask before the reveal", "Misconceptions", "What goes wrong in class", "For the blackboard",
            "What comes next", "References")
# what counts as one: a Chinese sign, as in a Chinese word processor, or whatever else stands between spaces and such signs
COUNTED = re.compile(r"[\u3000-\u303f\u4e00-\u9fff\uff00-\uffef]|[^\s\u3000-\u303f\u4e00-\u9fff\uff00-\uffef]+")
LONGEST = {"zh": 700}
NAME = "{} ({})".format


def notes() -> Iterator[tuple[str, str]]:
    """Every lesson in every language."""
    return ((id, language) for id in LESSONS for language in ("en", *TRANSLATED))


def headings(words: str) -> tuple[str, ...]:
    return tuple(re.findall(r"^## (.+)$", words, re.MULTILINE))


def sections(words: str) -> list[str]:
    """What stands under each heading."""
    return [part.partition("\n")[2].strip() for part in words.split("\n## ")[1:]]


@lru_cache(maxsize=1)
def named() -> dict[tuple[str, str], tuple[set[str], set[str]]]:
    """By lesson and language: what its knobs and their options are called, and what its tabs are."""
    return {(lesson.id, language): (set(_knobs(lesson, language)), tabs[language])
            for lesson in LESSONS.values() for tabs in (_tabs(lesson),) for language in ("en", *TRANSLATED)}


def _knobs(lesson: Lesson, language: str) -> Iterator[str]:
    for knob in lesson.knobs:
        if not knob.hidden:
            yield label_in_language(knob.label, language)
        if isinstance(knob, Choice):
            yield from (label_in_language(option, language) for _, option in knob.options)


def _tabs(lesson: Lesson) -> dict[str, set[str]]:
    from observer_lab.page.words.phrases import MORE
    figures = lesson.figures(lesson.compute(lesson.start()))
    return {
        language: {label_in_language(figure.tab, language) for figure in figures} | {MORE(language)} for language in ("en", *TRANSLATED)
    }


def test_every_lesson_has_notes_in_every_language() -> None:
    def law(id: str, language: str) -> None:
        place = folder(id) / "teacher.md" if language == "en" else LOCALE_FOLDER / language / f"{id}.teacher.md"
        assert place.is_file() and read_notes(folder(id), language) == place.read_text(encoding="utf-8")
    holds_for_all(notes(), law, NAME)


def test_notes_that_a_language_lacks_are_english(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setattr("observer_lab.course.prose.folder_of", lambda language: tmp_path)
    assert read_notes(folder("kalman"), "xx") == read_notes(folder("kalman"), "en") != ""


def test_no_page_of_students_names_the_notes() -> None:
    root = folder("kalman").parents[1]
    speaking = [path for path in (*(root / "app").rglob("*"), *(root / "lessons").rglob("*.py")) if path.suffix in {".py", ".js", ".html"}]
    naming = {path.relative_to(root).as_posix() for path in speaking
              if re.search(r"read_notes|teacher\.md", path.read_text(encoding="utf-8"))}
    assert naming == {"app/cli/commands/teach.py", "app/course/prose.py"}


def test_all_notes_of_a_language_have_the_same_headings_and_nothing_under_them_is_empty() -> None:
    of = {language: headings(read_notes(folder("separation"), language)) for language in ("en", *TRANSLATED)}
    assert of["en"] == SECTIONS

    def law(id: str, language: str) -> None:
        words = read_notes(folder(id), language)
        title = LESSONS[id].words[language].title
        assert re.match(rf"# {re.escape(title)}[:：]", words), "title"
        assert headings(words) == of[language] and len(of[language]) == len(SECTIONS) and all(sections(words))
        assert words.count("“") == words.count("”") and "$" not in words, "quotes pair, and a terminal shows no LaTeX"
        counts = [len(re.findall(r"^- ", body, re.MULTILINE)) for body in sections(words)]
        assert 2 <= counts[3] <= 4 and 2 <= counts[7] <= 4, "two to four misconceptions, and references"
        english = [len(re.findall(r"^- ", body, re.MULTILINE)) for body in sections(read_notes(folder(id), "en"))]
        assert counts == english, f"{counts}, in English {english}"
    holds_for_all(notes(), law, NAME)


def test_notes_are_short_and_the_minutes_add_up() -> None:
    def law(id: str, language: str) -> None:
        words = read_notes(folder(id), language)
        long = len(COUNTED.findall(words.rpartition("\n## ")[0]))  # without the references
        assert long <= LONGEST.get(language, 350), f"{long} words"
        whole, _, parts = re.split(r"([:：])", sections(words)[1], maxsplit=1)
        minutes = [int(found) for found in re.findall(r"(\d+)(?=[,，.。]|$)", parts)]
        assert sum(minutes) == int(re.findall(r"\d+", whole)[0]), minutes
    holds_for_all(notes(), law, NAME)


def test_notes_say_what_fits_into_15_45_and_90_minutes() -> None:
    def law(id: str, language: str) -> None:
        told = {int(found) for found in re.findall(r"(\d+)(?= minutes| 分钟)", sections(read_notes(folder(id), language))[1])}
        assert told >= {15, 45, 90}, told
    holds_for_all(notes(), law, NAME)
    for lesson in LESSONS.values():
        core, whole = sum(scene.minutes for scene in lesson.path if scene.core), sum(scene.minutes for scene in lesson.path)
        assert core <= 17 < whole + 10 <= 45, f"{lesson.id}: {core:g} and {whole:g} minutes"


def test_what_notes_quote_is_a_knob_or_an_option_and_what_they_stress_a_tab() -> None:
    def law(id: str, language: str) -> None:
        words, (knobs, tabs) = read_notes(folder(id), language), named()[id, language]
        quoted = set(re.findall(r"“([^”]+)”", words))
        assert quoted and quoted <= knobs, f"no knob: {sorted(quoted - knobs)}"
        stressed = set(re.findall(r"(?<![\w*])\*([^*\n]+)\*", words))
        assert stressed <= tabs, f"no tab: {sorted(stressed - tabs)}"
    holds_for_all(notes(), law, NAME)


def test_languages_give_the_same_numbers() -> None:
    """What has a decimal point, the references aside, which need not be the same."""
    def law(id: str, language: str) -> None:
        said = [" ".join(sections(read_notes(folder(id), code))[:-1]) for code in ("en", language)]
        english, other = (set(re.findall(r"\d+\.\d+", words)) for words in said)
        assert english == other, english ^ other
    holds_for_all(((id, language) for id, language in notes() if language != "en"), law, NAME)


def test_every_number_with_a_point_is_what_the_lesson_computes() -> None:
    """Or it stands in GIVEN: a setting, a pencil's result, a number that a caption says."""
    printed: dict[str, set[str]] = {id: set(GIVEN.get(id, ())) for id in LESSONS}

    def law(id: str, changes: dict[str, Any], said: dict[str, str], unit: float) -> None:
        lesson = LESSONS[id]
        metrics = lesson.compute(lesson.apply(lesson.start(), changes)).metrics
        for name, words in said.items():
            last = 10.0 ** -len(words.partition(".")[2])
            assert abs(abs(metrics[name]) / unit - float(words)) <= 0.5001 * last, f"{name} is {metrics[name]}, the notes say {words}"
            printed[id].add(words)
    facts = [(*fact, unit) for unit, group in FACTS for fact in group]
    holds_for_all(facts, law, lambda id, changes, *_: f"{id} at {changes}")

    def known(id: str) -> None:
        found = set(re.findall(r"\d+\.\d+", " ".join(sections(read_notes(folder(id), "en"))[:-1])))
        assert found <= printed[id], f"from where: {sorted(found - printed[id])}"
        assert {w for w in printed[id] if "." in w} <= found, f"not in the notes: {sorted(printed[id] - found)}"
    holds_for_all(LESSONS, known)


# what a reference names: a document of this lab, a data sheet, or authors and a year; and of an article where it stands
OURS = re.compile(r"\b00[0-4]\b|（00[0-4]）|\b148867\b|^Lessons 1 to 10|^第 1 至 10 课")
BOOK = re.compile(r"[(（][^()（）]*\b(?:19|20)\d\d[)）]")
PLACE = re.compile(r"\d+ \((?:19|20)\d\d\) \d+–\d+|[(（](?:19|20)\d\d[)）] ?\d+–\d+")
DOI = re.compile(r"doi:(10\.\d{4,}/[^\s，。;；]+?)(?=[.。]$)")


def test_a_reference_can_be_found_and_stands_on_the_page() -> None:
    """Authors, title and year; a DOI at the end of its item or none, the same ones in every language."""
    def law(id: str, language: str) -> None:
        listed = LESSONS[id].words[language].references
        assert len(listed) >= 2 and all(item in read_notes(folder(id), language) for item in listed)
        for item in listed:
            assert OURS.search(item) or PLACE.search(item) or BOOK.search(item), item
            assert ("doi:" in item) == bool(DOI.search(item)), item
            if "doi:" in item:
                assert PLACE.search(item) and len(re.split("[,，]", item)) >= 4, item
        assert {m for item in listed for m in DOI.findall(item)} == {
            m for item in LESSONS[id].words["en"].references for m in DOI.findall(item)}
    holds_for_all(notes(), law)
