"""Lay out the page that all followers share: stage, card, knobs as words, figures."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import viser

from ...colours import COLOURS, rgb
from ...course.figures.veil import boards_with_beginning
from ...course.lesson import Design, Outcome
from ...course.scenes import Scene
from ...session.state.token import write_token
from ...session.state.view import Picture
from ..charts.charts import Chart
from ..charts.print_sizes import Sizes
from ..charts.style_sheet import clock, clock_decimals, sheet_of
from ..column.column_widths import Columns
from ..replay.playback import Player
from ..replay.transport import CLOCK_PLACEHOLDERS, PlaybackControls
from ..screen.page_setup import speak
from ..screen.screen import Screen
from ..stage.lighting import cast_shadows
from ..viser_private import viser_internals
from ..viser_private.shared_page import SharedPage
from ..viser_private.write_once import write_content
from ..web.html_page import APP_NAME
from . import audience_card

MAX_FIGURES = 2
SCRIPTS = ("frames", "folders", "keys", "reading", "names", "cursor", "floor", "countdown")  # what a page needs that is watched


class AudiencePanel:
    """The card, the knobs as words, and the figures; nothing in it can be moved."""

    def __init__(self, gui: viser.GuiApi, picture: Picture) -> None:
        shown = {name for scene in picture.lesson.path for name in scene.figures} if picture.guided else {
            figure.id for figure in picture.seen[:MAX_FIGURES]}
        self._head, self._typed, self._card, self._knobs, self._answer, self._way = (gui.add_html("") for _ in range(6))
        self.charts = {figure.id: Chart(gui, figure, picture.state.language, Sizes(picture.state), picture.horizon, None, 2)
                       for figure in picture.seen if figure.id in shown}
        self._token = ""

    def show(self, picture: Picture) -> None:
        """Show what changed; the link to one's own copy names what rests."""
        write_content(self._head, audience_card.head_html(picture))
        write_content(self._typed, audience_card.typed_html(picture))
        write_content(self._card, audience_card.card_html(picture))
        write_content(self._knobs, audience_card.knobs_html(picture))
        write_content(self._answer, audience_card.answer_html(picture))
        if picture.resting or not self._token:
            own = replace(picture, state=replace(picture.state, mode="guide"))
            self._token = write_token(picture.lesson, own.saved(picture.design, None))
            write_content(self._way, audience_card.way_html(self._token, picture.state.language))
        for name, chart in self.charts.items():
            chart.set_visible(picture.scene is None or name in picture.scene.figures)

    def progress(self, fraction: float | None) -> None:
        """A follower waits for no computation."""


class AudienceClock:
    """The time of the run, as a page that plays by itself writes it, and the unseen slider that it moves."""

    def __init__(self, gui: viser.GuiApi, picture: Picture) -> None:
        self._picture = picture
        self._clock = gui.add_html("")
        self._slider = gui.add_slider("", 0.0, 1.0, 0.001, 0.0, visible=False)
        self.show(picture)

    @property
    def told(self) -> dict[str, object]:
        """What a page that plays by itself must know."""
        horizon = self._picture.horizon
        return {"clock": viser_internals.node_id(self._clock), "words": clock(0.0, horizon, self._picture.rate, "", *CLOCK_PLACEHOLDERS),
                "digits": clock_decimals(horizon), "slider": viser_internals.node_id(self._slider), "step": 0.001, "horizon": horizon}

    def show(self, picture: Picture) -> None:
        """The length of the run and its speed."""
        self._picture = picture

    def pose(self, t: float, horizon: float) -> None:
        """The time."""
        write_content(self._clock, clock(t, horizon, self._picture.rate, ""))

    def forget(self) -> None:
        """The page has written the time by itself."""
        self._clock.content = ""


class EveryPagePlayer(Player):
    """Poses ahead of their time, for pages of which each plays by itself."""

    @property
    def plays(self) -> bool:
        """Each page of ours does."""
        return True


class AudienceScreen(Screen):
    """A screen that many browsers show and none acts on: pictures as their presenter's tab made them."""

    def __init__(self, page: SharedPage, language: str, window: tuple[float, float]) -> None:
        super().__init__(cast(viser.ClientHandle, page))
        self._language, self._window = language, window
        self._outcome: tuple[tuple[Outcome, Scene | None, Design | None], Outcome] | None = None  # what a picture was made of; as shown

    def build(self, picture: Picture) -> None:
        """Lay everything out anew."""
        picture, gui = self._for_followers(picture), self._client.gui
        self._stop_page_playback()
        gui.reset()
        self._client.scene.reset()
        self._boards, self._map, self._columns = {}, None, Columns()
        gui.configure_theme(show_logo=False, show_share_button=False, brand_color=rgb(COLOURS["plant"]), dark_mode=False)
        gui.set_panel_label(APP_NAME)
        self._style = gui.add_html(sheet_of(picture), order=-1e9)
        panel = AudiencePanel(gui, picture)
        self._panel, self._charts = cast(Any, panel), panel.charts  # as much of a panel as a screen calls
        self._transport = cast(PlaybackControls, AudienceClock(gui, picture))
        gui.main_panel.dock_right()
        self._columns.add(gui.main_panel, Sizes(picture.state).right)
        self._compose(picture, anew=True)
        self._stage.furnish(False)
        self._stage.build(picture.outcome.stage, self._language, self._viewpoint.letters(False))
        self._player = EveryPagePlayer(self._client, self._stage, self._transport)
        cast_shadows(self._client)
        for name in SCRIPTS:
            viser_internals.run_script(self._client, name)
        self._viewpoint.look(picture.state.camera)
        self._stage.fit(self._viewpoint.letters(False))
        speak(self._client, picture, self._language)
        self._picture = None

    def show(self, picture: Picture) -> None:
        """Show what changed since the last picture."""
        super().show(self._for_followers(picture))

    def play(self, t: float, end: float, rate: float, every: float) -> float:
        """Let every page show the run from t on by itself; a run under a moving knob is posed with each picture instead."""
        if self._player is None or self._picture is None or not self._picture.resting:
            return every
        return self._player.go_on(t, end, rate, every)

    def _for_followers(self, picture: Picture) -> Picture:
        """The picture in the followers' language and window, with boards that nobody drags and without the counts of an open vote."""
        seen = picture.outcome, picture.scene, picture.began
        if self._outcome is None or any(a is not b for a, b in zip(self._outcome[0], seen, strict=True)):
            boards = boards_with_beginning(picture.outcome.boards, picture.scene, picture.began, picture.design)
            self._outcome = seen, replace(picture.outcome, boards=tuple(replace(board, knob=None) for board in boards))
        state = replace(picture.state, language=self._language, window=self._window, lecture=False, dark=False, landscape=False)
        if state.room is not None:
            state = replace(state, room=replace(state.room, votes=tuple(vote.sealed() for vote in state.room.votes)))
        return replace(picture, outcome=self._outcome[1], state=state, pinned=())
