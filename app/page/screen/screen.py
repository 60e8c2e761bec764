"""Put panels, stage, boards and charts of one tab together; implement the session's View."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

import viser

from ...colours import COLOURS, rgb
from ...course.course_map import Progress
from ...course.figures.records import figure_below, tab_names
from ...course.lesson import Board, Stage
from ...session.commands.commands import Edit, PickPoint, RunOnTabThread, SetKnobs
from ...session.state.view import Picture
from ...text import Text
from ..charts.charts import Chart, only_completes, stale_figures
from ..charts.print_sizes import Sizes, listen_to_the_window
from ..charts.style_sheet import sheet_of
from ..column.answer_mark import AnsweredMark
from ..column.column_widths import Columns
from ..column.dialogs import Dialogs
from ..column.left_column import Panel
from ..guide.guide_panel import GuidePanel
from ..replay.playback import Player
from ..replay.transport import PlaybackControls
from ..stage.body_extent import reach
from ..stage.map_board import MapBoard, map_of
from ..stage.pole_boards import BoardView
from ..stage.screen_size import ScreenSized, follow_camera
from ..stage.stage import StageView
from ..viser_private import page_scripts, viser_internals
from ..viser_private.write_once import write_content
from .browser import Browser
from .page_setup import bind_shortcuts, run_page_scripts, speak, watch_page_visibility
from .palette import fill_palette

Post = Callable[[Edit], int]
BATCH_GAP_S = 0.002  # s between two batches, so that the server's loop sends the first by itself


class Screen(Browser):
    """Everything that one browser shows. All methods are called by the session's worker."""

    def __init__(self, client: viser.ClientHandle) -> None:
        super().__init__(client)
        self._post: Post = lambda edit: 0
        self._stage = StageView(client, True, lambda knob, hand, grip: self._post(SetKnobs({knob: hand}, grip)), self._viewpoint.nearness)
        self._boards: dict[str, BoardView] = {}
        self._charts: dict[str, Chart] = {}
        self._map: MapBoard | None = None
        self._panel: Panel | GuidePanel | None = None
        self._transport: PlaybackControls | None = None
        self._style: viser.GuiHtmlHandle | None = None
        self._picture: Picture | None = None
        self._notes: list[Any] = []
        self._looked = False
        self._columns = Columns()
        self._dialogs: Dialogs | None = None
        self._player: Player | None = None

    def attach(self, post: Post) -> None:
        """Where edits go."""
        self._post = post

    # --- View ------------------------------------------------------------------------------------------------------
    def build(self, picture: Picture) -> None:
        """Lay everything out anew for a lesson or a language."""
        gui, language, sizes = self._client.gui, picture.state.language, Sizes(picture.state)
        with self._client.atomic():
            self._stop_page_playback()
            viser_internals.run_script(self._client, "keep", lesson=picture.lesson.id, large=picture.state.lecture)
            gui.reset()
            self._client.scene.reset()
            self._boards, self._charts, self._map, self._columns = {}, {}, None, Columns()
            gui.configure_theme(show_logo=False, show_share_button=False, brand_color=rgb(COLOURS["plant"]),
                                dark_mode=picture.state.is_dark)
            gui.set_panel_label("Observer Lab")
            self._style = gui.add_html(sheet_of(picture), order=-1e9)
            self._panel = GuidePanel(self._client, picture, self._post) if picture.guided else Panel(self._client, picture, self._post)
            viser_internals.run_script(self._client, "fields", fields=self._panel.fields)
            viser_internals.run_script(self._client, "fill", large=picture.state.lecture)
            viser_internals.run_script(self._client, "tabrow")
            if isinstance(self._panel, GuidePanel):
                self._charts = self._panel.charts
            else:
                self._right_panel(picture)
            self._transport = PlaybackControls(gui, picture, self._post)
            self._mark = AnsweredMark(gui, self._post)
            self._dialogs = Dialogs(self._client, picture, self._post, self._home)
            (gui.main_panel.dock_right if picture.guided else gui.main_panel.dock_left)()
            self._columns.add(gui.main_panel, sizes.right if picture.guided else sizes.left)
            self._columns.watch(self._client, self._post, sizes.widened)
            bind_shortcuts(self._client, self._post, language)
            fill_palette(self._client, picture, self._post, self.open_figure)
            self._stage.charted = map_of(picture) is not None
            self._compose(picture, anew=True)
            self._stage.furnish(picture.state.is_dark)
            self._stage.build(picture.outcome.stage, language, self._viewpoint.letters(picture.state.lecture))
            self._player = Player(self._client, self._stage, self._transport)
            if not self._looked:
                run_page_scripts(self._client)
                self._viewpoint.begin(picture.state.camera, None if picture.scene is None else picture.scene.view)
                self._stage.fit(self._viewpoint.letters(picture.state.lecture))
                follow_camera(self._client, self._post, self._viewpoint.heard, self._em, self._fitted)
                self._looked = True
            watch_page_visibility(self._client, self._post)
            listen_to_the_window(self._client, self._post)
            speak(self._client, picture, language)
        self._picture = None

    def show(self, picture: Picture) -> None:
        """Show what changed since the last picture: first the curves, then the stage at its time, then all that is read.

        A browser draws a batch that touches only panels at once; one that touches the scene waits for a frame.
        """
        before, self._picture = self._picture, picture
        anew = before is None or before.outcome is not picture.outcome
        charts = [(self._charts[f.id], f, None if picture.guided else figure_below(picture.seen, f))  # each has its axis in the guide
                  for f in stale_figures(picture, before) if f.id in self._charts]
        with self._client.atomic():
            for chart, figure, under in charts:
                chart.show_curves(figure, picture.resting, picture.horizon, under)
        self._client.flush()
        if not only_completes(picture, before):
            time.sleep(BATCH_GAP_S)
            self._show_scene(picture, anew)
        with self._client.atomic():
            if before is not None and before.state.window != picture.state.window:
                self._take_room(picture)
            for part in filter(None, (self._panel, self._transport)):
                part.show(picture)
            self._show_style(picture)
            for chart, figure, under in charts:
                chart.show_words(figure, under)
            if self._mark is not None:
                self._mark.show(picture)
        self._client.flush()

    def _looks_from_elsewhere(self) -> None:
        """Words on the stage are as large as is read from there."""
        self._stage.fit(self._em())

    def _compose(self, picture: Picture, anew: bool = False) -> None:
        charted, stage = map_of(picture) is not None, picture.outcome.stage if anew else None
        charted |= picture.state.landscape  # a surface that lies in front of the stage as well
        sizes, body = Sizes(picture.state), None if stage is None else reach(stage)
        self._viewpoint.compose(bool(picture.boards) or charted, charted, picture.state.lecture, sizes.below, body,
                                not picture.guided and not sizes.sheet)

    def _take_room(self, picture: Picture) -> None:
        """The window has another size; in large print the page is laid out anew instead."""
        sizes = Sizes(picture.state)
        widths = (sizes.right,) if picture.guided else (*((sizes.right,) if picture.seen else ()), sizes.left)
        self._columns.resize(*widths)
        for chart in self._charts.values():
            chart.take_room(sizes)
        self._compose(picture)

    def _show_scene(self, picture: Picture, anew: bool) -> None:
        with self._client.atomic():
            self._stop_page_playback()
            if anew:
                self._stage.show(picture.outcome.stage, picture.state.language, self._viewpoint.letters(picture.state.lecture))
            for board in picture.boards:
                view = self._board(board, picture)
                view.show(board, picture.covers(board), picture.veiled, picture.state.calm, picture.resting)
                view.stand_among(None if picture.scene is None else picture.scene.boards)
                if board.landscape is not None:
                    view.show_landscape(picture.state.landscape)
            self._show_map(picture)
            self._compose(picture)
            self._stage.calm(picture.state.calm)
            self._stage.name_parts(picture.named, picture.state.language)
            self._stage.show_pin_ghosts(picture.ghosts)
            self._stage.pose(picture.state.t)
        self._client.flush()

    def play(self, t: float, end: float, rate: float, every: float) -> float:
        """Show the run from t on: by the page itself where it can and the knobs rest, else one pose, and none while one is unsent."""
        if self._player is not None and self._player.plays and self._picture is not None and self._picture.resting:
            return self._player.go_on(t, end, rate, every)
        if not viser_internals.unsent(self._client):
            self.pose(t)
        return every

    def _stop_page_playback(self) -> None:
        """Take over from a page that plays by itself."""
        if self._player is not None:
            self._player.stop()

    def pose(self, t: float) -> None:
        """Stage and cursors at time t."""
        if self._picture is not None:
            with self._client.atomic():
                self._stop_page_playback()
                self._stage.pose(t)
                if self._transport is not None:
                    self._transport.pose(t, self._picture.horizon)
            self._client.flush()

    def follow(self, stage: Stage) -> None:
        """The stage alone at the end of another run of its body; nothing is given to a browser that is behind."""
        if self._picture is not None and not viser_internals.unsent(self._client):
            with self._client.atomic():
                self._stop_page_playback()
                self._stage.follow(stage)
            self._client.flush()

    def progress(self, fraction: float | None, label: Text | None) -> None:
        """A long job's progress."""
        if self._panel is not None and self._mark is not None:
            self._panel.progress(fraction)
            self._mark.works(fraction is not None)
            self._client.flush()

    def say(self, words: Text, bad: bool) -> None:
        """One sentence as a notification; the last two stay, older ones go."""
        language = self._picture.state.language if self._picture is not None else "en"
        self._notes.append(self._client.add_notification("Observer Lab", words(language), color="red" if bad else "blue",
                                                         auto_close_seconds=9.0 if bad else 5.0))
        while len(self._notes) > 2:
            self._notes.pop(0).remove()
        self._client.flush()

    def open_figure(self, figure: str) -> None:
        """Bring the tab of a figure to the front."""
        picture = self._picture
        found = next((f for f in picture.seen if f.id == figure), None) if picture is not None else None
        if found is not None and picture is not None:
            page_scripts.open_tab(self._client, found.tab(picture.state.language), figure)
            self._client.flush()

    def open_glossary(self) -> None:
        """The page of all terms; asked for again it closes."""
        if self._dialogs is not None and self._picture is not None:
            self._dialogs.glossary(self._picture)

    def open_help(self) -> None:
        """The list of keys; the same key closes it."""
        if self._dialogs is not None and self._picture is not None:
            self._dialogs.help(self._picture)

    def open_course(self, progress: Mapping[str, Progress]) -> None:
        """The page of all lessons; the same key closes it."""
        if self._dialogs is not None and self._picture is not None:
            self._dialogs.course(self._picture, progress)
            self._client.flush()

    def offer(self, token: str) -> None:
        """Open the dialog in which a state can be taken away, or close it."""
        if self._dialogs is not None and self._picture is not None:
            self._dialogs.take(self._picture, token)
            self._client.flush()

    # --- parts -----------------------------------------------------------------------------------------------------
    def _right_panel(self, picture: Picture) -> None:
        if not picture.seen:
            return
        language = picture.state.language
        panel = self._client.gui.add_panel()
        panel.expand()
        panel.dock_right()
        self._columns.add(panel, Sizes(picture.state).right)
        for tab in tab_names(picture.seen):
            with panel.add_tab(tab(language)):
                for figure in picture.seen:
                    if figure.tab == tab:
                        self._charts[figure.id] = Chart(self._client.gui, figure, language, Sizes(picture.state), picture.horizon,
                                                       figure_below(picture.seen, figure), sum(f.tab == tab for f in picture.seen),
                                                       self._post)

    def _show_style(self, picture: Picture) -> None:
        if self._style is not None:
            write_content(self._style, sheet_of(picture))

    def _board(self, board: Board, picture: Picture) -> BoardView:
        if board.id not in self._boards:
            self._boards[board.id] = BoardView(
                self._client, board, picture.state.language, self._viewpoint.letters(picture.state.lecture), picture.state.is_dark,
                self._viewpoint.composed.foot, lambda values, grip: self._post(SetKnobs(values, grip)),
                lambda words: self._post(RunOnTabThread(lambda: self.say(words, False))))
        return self._boards[board.id]

    def _em(self) -> float:
        """How large letters of the stage are, in stage units."""
        return self._viewpoint.letters(self._picture is not None and self._picture.state.lecture)

    def _fitted(self) -> tuple[ScreenSized, ...]:
        """What is as large as the camera asks for."""
        return self._viewpoint, self._stage, *self._boards.values(), *filter(None, (self._map,))

    def _show_map(self, picture: Picture) -> None:
        figure = map_of(picture)
        if self._map is None and figure is not None:
            self._map = MapBoard(self._client, picture.state.language, self._viewpoint.letters(picture.state.lecture),
                                 picture.state.is_dark, lambda x, y: self._post(PickPoint(x, y)))
        if self._map is not None:
            self._map.show(figure)
