"""Write what a lecture has shown on one sheet: its votes, and where people worked."""

from __future__ import annotations

import csv
import html
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

from ...classroom.room import UNSOLVED
from ...classroom.votes import HIDDEN_BELOW, Vote
from ...course.guiding.predictions import prediction_of
from ...course.lesson import Lesson
from ...text import format_number
from .. import web
from ..words import phrases
from ..words.prose import render_markdown
from .histogram import LETTERS, question_words
from .pole_plane import pole_words

FORMULA_SIGNS = ("=", "+", "-", "@", "\t", "\r")  # with which a spreadsheet would begin a formula


@dataclass(frozen=True)
class SheetRow:
    """One count: of which lesson and scene, of what (a question with its round, or work of one's own), and of which answer."""

    lesson: str
    scene: str
    what: str
    answer: str
    count: int


def sheet_rows(votes: Sequence[Vote], seen: Mapping[str, int], lessons: Mapping[str, Lesson], language: str) -> list[SheetRow]:
    """The rows in the order of lessons and scenes. Counts of fewer than five people are left out, and their votes with them."""
    rows = [row for vote in votes if not vote.open and vote.total >= HIDDEN_BELOW for row in _vote_rows(vote, lessons, language)]
    for place, count in seen.items():
        lesson, _, part = place.removeprefix(UNSOLVED).partition("/")
        words = phrases.SHEET_TRIED if place.startswith(UNSOLVED) else phrases.SHEET_HERE
        if count >= HIDDEN_BELOW and lesson in lessons:
            rows.append(SheetRow(lesson, part, words(language), "", count))
    places = {(lesson.id, scene.id): (lesson.number, k) for lesson in lessons.values() for k, scene in enumerate(lesson.path)}
    return sorted(rows, key=lambda row: (*places.get((row.lesson, row.scene), (lessons[row.lesson].number, len(places))), row.what))


def _vote_rows(vote: Vote, lessons: Mapping[str, Lesson], language: str) -> Iterator[SheetRow]:
    lesson = lessons.get(vote.lesson)
    if lesson is None:
        return
    question = phrases.SHEET_QUESTION(language) if vote.asked is None else question_words(vote.asked, language)
    what = f"{question} ({phrases.VOTE_ROUND.format(number=vote.round)(language)})"
    if vote.kind == "sketch":
        yield SheetRow(vote.lesson, vote.scene, what, phrases.CLASS_DRAWINGS(language), vote.total)
        return
    for answer, count in zip(_answers(vote, lesson, language), vote.counts, strict=False):
        if count or vote.kind == "choice":
            yield SheetRow(vote.lesson, vote.scene, what, answer, count)


def _answers(vote: Vote, lesson: Lesson, language: str) -> Sequence[str]:
    """What each count of a vote is of."""
    if vote.asked is not None and vote.asked.grid is not None:
        return [pole_words(vote.asked.grid.pole_at(cell)) for cell in range(len(vote.counts))]
    if vote.kind == "number":
        return [f"{format_number(low, '.6g', language)} – {format_number(high, '.6g', language)}" for low, high in pairwise(vote.edges)]
    scene = next((scene for scene in lesson.path if scene.id == vote.scene), None)
    own = vote.asked.options if vote.asked is not None else prediction_of(lesson, scene, language).options if scene is not None else ()
    return [f"{letter} {option}" for letter, option in zip(LETTERS, own, strict=False)] or list(LETTERS[:len(vote.counts)])


def sheet_csv(rows: Sequence[SheetRow], lessons: Mapping[str, Lesson], language: str) -> str:
    """The rows as a table for a spreadsheet; no cell is a formula there."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([words(language) for words in phrases.SHEET_COLUMNS])
    for row in rows:
        cells = [*_titles(row, lessons, language), row.what, row.answer]
        writer.writerow([f"'{cell}" if cell.startswith(FORMULA_SIGNS) else cell for cell in cells] + [row.count])
    return out.getvalue()


def sheet_html(rows: Sequence[SheetRow], lessons: Mapping[str, Lesson], language: str) -> str:
    """The rows as a page that stands alone: a table for each scene."""
    title, parts = html.escape(phrases.SHEET_TITLE(language)), []
    for (lesson, scene), found in groupby(rows, key=lambda row: _titles(row, lessons, language)):
        lines = "".join(f'<tr><td>{html.escape(row.what)}</td><td>{render_markdown(html.escape(row.answer))}</td>'
                        f'<td class="n">{row.count}</td></tr>' for row in found)
        parts.append(f"<h2>{html.escape(lesson)}{f': {html.escape(scene)}' if scene else ''}</h2><table>{lines}</table>")
    few = html.escape(phrases.SHEET_FEW.format(least=HIDDEN_BELOW)(language))
    style = web.style_rules("lecture_sheet.css")
    return (f'<!doctype html><html lang="{language}"><head><meta charset="utf-8"><title>{title}</title><style>{style}</style></head>'
            f'<body><h1>{title}</h1><p>{few}</p>{"".join(parts)}</body></html>\n')


def _titles(row: SheetRow, lessons: Mapping[str, Lesson], language: str) -> tuple[str, str]:
    words = lessons[row.lesson].words[language]
    titles = {name: scene.title for name, scene in words.scenes.items()} | {name: task.title for name, task in words.tasks.items()}
    return words.title, titles.get(row.scene, row.scene)
