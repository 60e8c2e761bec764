"""Compute the sizes of the page's parts in usual and in large print."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import viser

from ...session.commands.commands import Edit, WindowChanged
from ...session.state.view import USUAL, State
from ..viser_private import page_scripts
from .axes import H, W
from .text_layout import WORDS_PX

LEFT_COLUMN_PX, RIGHT_COLUMN_PX, RUN_PANEL_PX = 345.0, 395.0, 600.0  # px of the columns and of the panel of the run
LEAST_RUN = 250.0  # px of that panel, where its buttons stand in more rows
LARGE_LEFT, LARGE_RIGHT = 22.0, 25.0  # the same in large print, in letters
LARGE_PRINT_SHARE = 0.021  # of the window's height: a letter's size in large print; `lecture.css` says the same
PHONE, HELD_ACROSS = 576.0, 480.0  # px of a window's width or height below which there are no keys
SHEET_MAX_WIDTH_PX = (
    896.0  # px of a window's width up to which a sheet takes the place of the columns; `page.css` and `breadth.js` say the same
)
ASIDE = 0.54  # of the window's width that the sheet takes beside the stage, where the window is wider than high; likewise
NARROWEST = 250.0, 270.0  # px of the columns in a window that just has room for them
LEGIBLE = 10.0  # px of the words in a drawing
BAR = 12.0  # px between the panel of the run and the columns
WIDE_SHARE = 0.38  # of the window's width: the figures, where somebody wants them large
GUIDE_SHARE = 0.32  # of the window's width: the guide's column
FRAME_PX = 36.0  # px of a column of figures beside its charts and drawings
QUESTION_HEIGHT = 300.0  # of a question's figure, whose width is `axes.W`
ANSWERED_SHARE = 0.31  # of the window's height: the most that it takes beside a verdict, so that its letters stay large enough
ASKED_IN_HALL, ANSWERED_IN_HALL = 0.75, 0.56  # of that width: its height in a hall, above which stand the options, then the verdict
LEAST_CHART, CHARTS = 180, MappingProxyType({1: 320, 2: 230})  # px of a chart's height, and where it stands alone or with one figure more
FILLS, TALLEST = 0.72, 1.4  # of a lone drawing in large print: its share of the window's height, its height over its width
LEAST_FILLED = 0.26  # of the window's height: a chart in large print is no lower; `fill.js` has it as a share of the column


@dataclass(frozen=True)
class Sizes:
    """The sizes for one state of a tab; the letters of the stage are `viewpoint.letters`."""

    state: State

    @property
    def letter(self) -> float:
        """px of a letter in large print."""
        return LARGE_PRINT_SHARE * self.state.window[1]

    @property
    def sheet(self) -> bool:
        """Whether a sheet takes the place of the columns."""
        return self.state.window[0] <= SHEET_MAX_WIDTH_PX

    @property
    def below(self) -> bool:
        """Whether that sheet lies over the lower half of the stage."""
        return self.sheet and self.state.window[1] >= self.state.window[0]

    @property
    def left(self) -> float:
        """px of the column with the question and the knobs; the guide has none."""
        if self.state.guided and not self.sheet:
            return 0.0
        if self.state.lecture:
            return min(LARGE_LEFT * self.letter, 0.28 * self.state.window[0])
        return min(LEFT_COLUMN_PX, max(NARROWEST[0], LEFT_COLUMN_PX * self.state.window[0] / USUAL[0]))

    @property
    def right(self) -> float:
        """px of the column with the figures, or of the guide, or of the sheet."""
        if self.sheet:
            return self.state.window[0] * (1.0 if self.below else ASIDE)
        if self.state.guided:
            return GUIDE_SHARE * self.state.window[0]
        if self.state.lecture:
            return min(LARGE_RIGHT * self.letter, 0.3 * self.state.window[0])
        return min(RIGHT_COLUMN_PX, max(NARROWEST[1], RIGHT_COLUMN_PX * self.state.window[0] / USUAL[0]))

    @property
    def widened(self) -> float:
        """px of the column with the figures after a double click on its head."""
        return max(WIDE_SHARE * self.state.window[0], self.right)

    @property
    def run(self) -> float:
        """px of the panel of the run: all the stage has in large print and in the guide, so that it stands in one row."""
        stage = self.state.window[0] - self.left - self.right - 2 * BAR
        if self.state.guided and not self.sheet:
            return stage
        return max(stage, 300.0) if self.state.lecture else min(RUN_PANEL_PX, max(stage, LEAST_RUN))

    @property
    def lists_keys(self) -> bool:
        """Whether the menu of the lab has the list of keys: in a hall a key opens it; a phone has no keys."""
        return not self.state.lecture and self.state.window[0] >= PHONE and self.state.window[1] >= HELD_ACROSS

    @property
    def chart_letter(self) -> int:
        """px of the words in a chart."""
        return round(self.letter) if self.state.lecture else 12

    def chart(self, figures: int) -> int:
        """px of a chart's height in a tab of so many figures: in a hall one is looked at, and `fill.js` gives it what is left."""
        return round(0.5 * self.state.window[1]) if self.state.lecture else CHARTS.get(figures, LEAST_CHART)

    def drawing(self, figures: int) -> float:
        """The height of a plane or a map, whose width is `axes.W`: one that stands alone in its tab is a square, and fills the column
        in a hall; in a sheet none takes more than others."""
        if figures > 1 or self.sheet:
            return float(H)
        return min(FILLS * self.state.window[1] * W / self.right, TALLEST * W) if self.state.lecture else float(W)

    def question(self, answered: bool = False) -> float:
        """The height of a question's figure: room is left for the verdict above it; `fill.js` makes it smaller where that is long."""
        if self.state.lecture and not self.sheet:
            return W * (ANSWERED_IN_HALL if answered else ASKED_IN_HALL)
        if self.sheet:
            return self.drawing(1)
        return min(QUESTION_HEIGHT, ANSWERED_SHARE * self.state.window[1]) if answered else QUESTION_HEIGHT

    @property
    def large_words(self) -> bool:
        """Whether the words of drawings are those of large print: in a hall, and where a narrow column makes drawings small."""
        return self.state.lecture or (self.right - FRAME_PX) / W * WORDS_PX < LEGIBLE

    def upright(self, figures: int) -> float:
        """px along a chart's vertical axis that its name may take, however little of the column is left to the chart."""
        least = LEAST_FILLED * self.state.window[1] if self.state.lecture else self.chart(figures)
        return least - self.chart_letter - 26.0


def listen_to_the_window(client: viser.ClientHandle, post: Callable[[Edit], int]) -> None:
    """Hear how large a browser's window is, and whether its owner likes the dark."""
    told = client.gui.add_vector3("", (0.0, 0.0, 0.0), visible=False)

    @told.on_update
    async def _(event: viser.GuiEvent) -> None:
        post(WindowChanged(*event.target.value))
    page_scripts.tell_the_window(client, told)
