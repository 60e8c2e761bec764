"""The table of the five sources: every place in it exists, and no equation, figure or algorithm is left out."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from word_rules import offences
from word_sources import markdown

from observer_lab import engine
from observer_lab.lessons import LESSONS, folder
from observer_lab.published import records

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "assets" / "sources.md").read_text(encoding="utf-8")
SOURCES = ("000", "001", "002", "003", "004")
STATES = re.compile(r"works|(?:in part|not here): \S+(?: \S+){2,}")  # a reason has three words or more
NUMBERED = {  # what a source counts, and how many of each it has
    ("001", "equations"): 7, ("002", "equations"): 13, ("002", "Figure"): 2, ("002", "Remark"): 4, ("002", "Example"): 2,
    ("003", "equations"): 89, ("003", "figure"): 25, ("003", "Algorithm"): 3, ("003", "rule"): 4,
    ("004", "equations"): 24, ("004", "step"): 8, ("004", "Case"): 3}


class Row(NamedTuple):
    """A part of a source, what it says, where it is found, and its state."""

    part: str
    says: str
    places: tuple[str, ...]
    state: str


def tables(page: str) -> dict[str, list[Row]]:
    """The rows by source; a heading `## 000: …` starts each table."""
    found: dict[str, list[Row]] = {}
    for section in re.split(r"^## ", page, flags=re.M)[1:]:
        lines = [line for line in section.splitlines() if line.startswith("|")]
        cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines[2:]]
        assert lines[0] == "| part of the source | what it says | place | state |" and {len(row) for row in cells} == {4}
        found[section.partition(":")[0]] = [Row(part, says, tuple(re.findall(r"`([^`]+)`", place)), state)
                                            for part, says, place, state in cells]
    return found


@cache
def tabs(lesson: str) -> frozenset[str]:
    """Names of a lesson's tabs: strings assigned to a `…_TAB` of its folder, and the shared ones that its figures use."""
    shared = _tab_names((ROOT / "lessons" / "toolkit" / "figures.py", ROOT / "app" / "course" / "figures" / "diagram.py"))
    files = tuple(folder(lesson).glob("*.py"))
    drawn = "".join(file.read_text(encoding="utf-8") for file in files if file.stem.endswith("figures"))
    return frozenset((*_tab_names(files).values(), *(said for name, said in shared.items() if re.search(rf"\b{name}\b", drawn))))


def _tab_names(files: Iterable[Path]) -> dict[str, str]:
    found: dict[str, str] = {}
    for node in (node for file in files for node in ast.parse(file.read_text(encoding="utf-8")).body if isinstance(node, ast.Assign)):
        names = [each.id for target in node.targets for each in ast.walk(target) if isinstance(each, ast.Name)]
        said = [each.value for each in ast.walk(node.value) if isinstance(each, ast.Constant) and isinstance(each.value, str)]
        if len(names) == len(said):
            found |= {name: words for name, words in zip(names, said, strict=True) if name.endswith("_TAB") or name == "DIAGRAM"}
    return found


@cache
def parts(lesson: str) -> Mapping[str, frozenset[str]]:
    """What a lesson has of each kind, by name."""
    it = LESSONS[lesson]
    prose = it.words["en"]
    return {"task": frozenset(task.id for task in it.tasks), "exam": frozenset(exam.id for exam in it.exams),
            "step": frozenset(heading for heading, _ in prose.steps), "derive": frozenset(step.heading for step in prose.derivation),
            "tab": tabs(lesson), "knob": frozenset(knob.name for knob in it.knobs)}


@cache
def verified(source: str) -> frozenset[str]:
    """Items of a source that `verify` prints."""
    return frozenset(each.item for each in records() if each.source.startswith(source))


def exists(place: str, source: str) -> bool:
    """Whether a place is a scene, a part of a lesson, a name of the engine or a published value of this source."""
    if place.startswith("verify: "):
        return place.removeprefix("verify: ") in verified(source)
    if place.startswith("engine."):
        return place.removeprefix("engine.") in engine.__all__
    lesson, sign, name = re.fullmatch(r"([a-z-]*)([/#]?)(.*)", place, re.S).groups()  # type: ignore[union-attr]
    if lesson not in LESSONS or not sign:
        return False
    if sign == "/":
        return name in {scene.id for scene in LESSONS[lesson].path}
    kind, _, one = name.partition(" ")
    return one in parts(lesson).get(kind, ())


def counted(rows: Iterable[Row], kind: str) -> set[int]:
    """The numbers of a kind that the first column names, ranges filled."""
    said = [row.part for row in rows]
    spans = ([re.findall(r"\((\d+)[a-c]?\)(?:–\((\d+)[a-c]?\))?", part) for part in said] if kind == "equations" else
             [re.findall(rf"\b{kind}s? (\d+)(?:(?:–| and )(\d+))?", part, re.I) for part in said])
    return {number for each in spans for first, last in each for number in range(int(first), int(last or first) + 1)}


def missing(rows: Iterable[Row], source: str) -> list[str]:
    """Places that do not exist."""
    return [place for row in rows for place in row.places if not exists(place, source)]


def judged(rows: Iterable[Row]) -> None:
    """Each row has a state with its reason, and a place unless it is not here."""
    for row in rows:
        assert row.part and row.says and STATES.fullmatch(row.state), row
        assert row.places or row.state.startswith("not here"), row


def test_each_source_has_a_table_and_each_row_a_state() -> None:
    found = tables(PAGE)
    assert tuple(found) == SOURCES
    for source, rows in found.items():
        assert len(rows) > 15 and len({row.part for row in rows}) == len(rows), source
        judged(rows)


@pytest.mark.parametrize("state", ["in part", "in part:", "in part: ", "in part: later", "not here", "not here: no",
                                   "partly: because of it", "", "works: almost all of it"])
def test_a_row_in_part_or_not_here_without_its_reason_is_found_out(state: str) -> None:
    assert not STATES.fullmatch(state.strip())
    with pytest.raises(AssertionError):
        judged([Row("a part", "a fact", ("separation/meet",), state)])


def test_rows_that_are_not_whole_all_have_their_reason() -> None:
    reasons = [row.state for rows in tables(PAGE).values() for row in rows if row.state != "works"]
    assert len(reasons) >= 20 and all(STATES.fullmatch(each) for each in reasons)
    assert len(set(reasons)) > len(reasons) - 5, "a reason is that of its row, not one for all"


@pytest.mark.parametrize("source", SOURCES)
def test_every_place_exists(source: str) -> None:
    assert missing(tables(PAGE)[source], source) == []


@pytest.mark.parametrize(("source", "kind"), NUMBERED)
def test_nothing_that_a_source_numbers_is_left_out(source: str, kind: str) -> None:
    found = counted(tables(PAGE)[source], kind)
    assert found == set(range(1, NUMBERED[source, kind] + 1))


@pytest.mark.parametrize("place", [
    "separation/no-such-scene", "no-such-lesson/meet", "separation", "separation#task no-such-task", "separation#exam gentle",
    "separation#tab No such tab", "separation#knob no_such_knob", "separation#derive No such step", "separation#step No such text",
    "separation#scene meet", "engine.no_such_name", "engine.__doc__", "verify: no such item", "verify: Hankel values σ1 … σ6", ""])
def test_a_made_up_place_is_found_out(place: str) -> None:
    assert not exists(place, "001")
    assert missing([Row("a part", "a fact", (place, "separation/meet"), "works")], "001") == [place]


def test_a_missing_equation_is_found_out() -> None:
    rows = [Row("2, (1)–(3)", "", (), "works"), Row("2, (5a)–(5b) and (7)", "", (), "works"), Row("figures 2–4", "", (), "works")]
    assert counted(rows, "equations") == {1, 2, 3, 5, 7} and counted(rows, "figure") == {2, 3, 4}


def test_the_page_is_plain_and_linked_once() -> None:
    bad = {one.words: why for one in markdown(PAGE, "assets/sources.md") if (why := offences(one.words))}
    assert not bad
    assert (ROOT / "README.md").read_text(encoding="utf-8").count("](assets/sources.md)") == 1
