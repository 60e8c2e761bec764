"""Write sheets for print: a lesson with figures and tasks, or problems with a student's numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO

from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure as Page
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D

from ...colours import COLOURS
from ...course.design_differences import describe_design
from ...course.figures.records import Figure
from ...course.lesson import Lesson, Outcome
from ...text import text
from ..figures.figure import CELL, MARGIN, Cell, cell_of, letter_of, place
from ..figures.fonts import families
from ..figures.style import INK_COLOUR, RULE_COLOUR, SMALL_PT, export_style
from .typeset import Piece, lines_of, set_line

__all__ = ["Problem", "problem_sheet", "sheet"]

PAGE_WIDTH_IN, PAGE_HEIGHT_IN = 8.27, 11.69  # A4, in inches
SIDE_IN, TOP_IN, BOTTOM_IN = (PAGE_WIDTH_IN - 2 * CELL) / 2, 0.5, 0.62  # edges of the page, in inches
TITLE_PT, QUESTION_PT, BODY_PT = 17.0, 12.5, 9.5  # pt
LEADING = 1.42  # from one line to the next, in sizes of its letters
FORMULA_GAP_EM = 0.1  # of the size of its letters: room beside a formula
RULED, ANSWER_LINE_GAP_IN = 6, 0.3  # lines for an answer, and inches between them
DPI = 288.0  # at which letters are measured
FIGURES_NOW = text("Figures, as they are now")
TASKS = text("Tasks")
NAME_FIELD, SOLUTIONS = text("Name"), text("answers and derivations")
PAGE = text("page {number} of {count}")


def sheet(lesson: Lesson, outcome: Outcome, figures: Sequence[Figure], token: str, language: str = "en") -> bytes:
    """The sheet as a PDF on A4, with the token of its state at the foot. The same records give the same bytes."""
    words = lesson.words[language]
    with export_style(language):
        paper = _Paper(language, f"Observer Lab · {words.title}", token)
        paper.say(words.title, TITLE_PT, weight="bold")
        paper.gap(0.06)
        paper.say(words.question, QUESTION_PT, weight="bold", color=COLOURS["outline"])
        paper.gap(0.1)
        paper.say(f"{NAME_FIELD(language)}:", BODY_PT)
        paper.rule(0.55, -0.02)
        paper.gap(0.18)
        paper.say(words.introduction, BODY_PT)
        paper.gap(0.16)
        paper.head(FIGURES_NOW(language))
        paper.say(describe_design(lesson, outcome.design)(language), BODY_PT)
        paper.say(outcome.live(language), BODY_PT)
        paper.gap(0.1)
        paper.figures(figures)
        paper.head(TASKS(language))
        for number, task in enumerate(lesson.tasks, 1):
            said = words.tasks[task.id]
            paper.ask(f"{number}.  {said.title}", said.statement)
        return paper.bound()


@dataclass(frozen=True)
class Problem:
    """An exam with numbers: what is asked, and answer and derivation in Markdown."""

    title: str
    statement: str
    solution: str


def problem_sheet(title: str, key: str, problems: Sequence[Problem], solved: bool, language: str = "en") -> bytes:
    """Problems as a PDF on A4 with lines for the answers, or `solved`; `key` says whose numbers these are."""
    with export_style(language):
        paper = _Paper(language, f"Observer Lab · {title}", key)
        paper.say(f"{title} · {SOLUTIONS(language)}" if solved else title, TITLE_PT, weight="bold")
        paper.gap(0.1)
        if not solved:
            paper.say(f"{NAME_FIELD(language)}:", BODY_PT)
            paper.rule(0.55, -0.02)
            paper.gap(0.18)
        for number, problem in enumerate(problems, 1):
            if solved:
                paper.head(f"{number}.  {problem.title}")
                paper.say(problem.statement, BODY_PT)
                paper.gap(0.06)
                paper.say(problem.solution, BODY_PT)
                paper.gap(0.18)
            else:
                paper.ask(f"{number}.  {problem.title}", problem.statement)
        return paper.bound()


class _Paper:
    """Pages that are filled from the top; what does not fit goes to the next."""

    def __init__(self, language: str, foot: str, token: str) -> None:
        self._language, self._foot, self._token = language, foot, token
        self._pages: list[Page] = []
        self._family = families(language)
        self._pen = RendererAgg(8, 8, DPI)
        self._down = 0.0  # inches from the upper edge
        self._turn()

    def _turn(self) -> None:
        page = Page(figsize=(PAGE_WIDTH_IN, PAGE_HEIGHT_IN), dpi=DPI, facecolor="white")
        FigureCanvasAgg(page)
        self._pages.append(page)
        self._down = TOP_IN

    def _room(self, inches: float) -> None:
        """Turn the page if there is less room than that."""
        if self._down + inches > PAGE_HEIGHT_IN - BOTTOM_IN and self._down > TOP_IN:
            self._turn()

    def gap(self, inches: float) -> None:
        """Leave some room."""
        self._down += inches

    def _measure(self, size: float, weight: str) -> Callable[[str, bool], float]:
        font = FontProperties(family=self._family, size=size, weight=weight)

        def ink(said: str, maths: bool = False) -> float:
            return self._pen.get_text_width_height_descent(said, font, maths)[0] / DPI
        posts = ink("nn")  # between two letters a word takes its whole width, a space too
        return lambda said, maths: ink(said, True) + FORMULA_GAP_EM * size / 72 if maths else ink(f"n{said}n") - posts

    def _set(self, said: str, size: float, weight: str) -> list[tuple[Piece, ...]]:
        return list(lines_of(said, PAGE_WIDTH_IN - 2 * SIDE_IN, self._measure(size, weight)))

    def say(self, said: str, size: float, weight: str = "normal", color: str = INK_COLOUR) -> None:
        """Words over the whole width."""
        for line in self._set(said, size, weight):
            step = size * LEADING / 72 * (1.0 if line else 0.5)
            self._room(step)
            self._down += step
            set_line(self._pages[-1], line, SIDE_IN, PAGE_HEIGHT_IN - self._down, size, weight=weight, color=color)

    def head(self, said: str) -> None:
        """A heading, never the last line of a page."""
        self._room(1.2)
        self.say(said, QUESTION_PT, weight="bold")
        self.gap(0.06)

    def rule(self, left: float = 0.0, down: float = 0.0, colour: str = RULE_COLOUR) -> None:
        """A line across the page to write on."""
        y = 1 - (self._down + down) / PAGE_HEIGHT_IN
        page = self._pages[-1]
        page.add_artist(_line(page, (SIDE_IN + left) / PAGE_WIDTH_IN, 1 - SIDE_IN / PAGE_WIDTH_IN, y, colour))

    def figures(self, figures: Sequence[Figure]) -> None:
        """All figures, two in a row."""
        cells = [cell_of(figure, self._language) for figure in figures]
        for i in range(0, len(cells), 2):
            self._row(cells[i:i + 2], i)

    def _row(self, row: Sequence[Cell], first: int) -> None:
        tallest = max(cell.height for cell in row)
        self._room(tallest)
        for k, cell in enumerate(row):
            place(self._pages[-1], (PAGE_WIDTH_IN, PAGE_HEIGHT_IN), cell, SIDE_IN + k * CELL, PAGE_HEIGHT_IN - self._down - MARGIN / 2,
                  f"({letter_of(first + k)})  ", self._language)
        self.gap(tallest)

    def ask(self, title: str, statement: str) -> None:
        """A task with lines to answer on; both stay on one page."""
        self._room(0.4 + len(self._set(statement, BODY_PT, "normal")) * BODY_PT * LEADING / 72 + RULED * ANSWER_LINE_GAP_IN)
        self.gap(0.08)
        self.say(title, BODY_PT + 1, weight="bold")
        self.say(statement, BODY_PT)
        for _ in range(RULED):
            self.gap(ANSWER_LINE_GAP_IN)
            self.rule(colour=COLOURS["print-line"])
        self.gap(0.2)

    def bound(self) -> bytes:
        """All pages as one file."""
        out = BytesIO()
        facts = {"CreationDate": None, "Creator": "Observer Lab", "Producer": None, "Subject": self._token}
        with PdfPages(out, metadata=facts) as book:
            for number, page in enumerate(self._pages, 1):
                shown = f"{self._foot} · {PAGE.format(number=number, count=len(self._pages))(self._language)}"
                set_line(page, (Piece(shown, False, 0.0),), SIDE_IN, 0.42, SMALL_PT, color=RULE_COLOUR)
                if len(self._token) <= 150:
                    set_line(
                        page, (Piece(self._token, False, 0.0),), SIDE_IN, 0.29, SMALL_PT - 1, color=RULE_COLOUR, family="DejaVu Sans Mono"
                    )
                book.savefig(page)
        return out.getvalue()


def _line(page: Page, left: float, right: float, y: float, colour: str) -> Line2D:
    return Line2D((left, right), (y, y), linewidth=0.5, color=colour, transform=page.transFigure, figure=page)
