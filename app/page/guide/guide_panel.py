"""Build the guide's panel: the card of a scene, its knobs, its verdict and its figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import viser

from ...course.knobs import Knob
from ...course.scenes import Move, Press, Scene, Solve, knobs_of, minutes_of
from ...session.commands.commands import DrawByHand, Edit, OpenLesson, SetKnobs, ToggleCourse
from ...session.commands.guide import (
    AnswerByHand,
    ChooseOption,
    EndLecture,
    GoToScene,
    RecordStop,
    RestartScene,
    SaveLecture,
    SetMode,
    ShowKeptRun,
    TurnScene,
)
from ...session.commands.room import RunSeeds
from ...session.state.view import Picture
from ..charts.charts import Chart
from ..charts.print_sizes import Sizes
from ..charts.seed_cloud import RUN_SEEDS, seeds_html
from ..column.knob_widgets import NumberWidget, Widget, make_widget
from ..column.pole_sliders import PoleSliders
from ..replay.pull_sliders import PullSliders
from ..viser_private import viser_internals
from ..viser_private.hidden_input import hidden_input
from ..viser_private.write_once import write_content
from ..votes.room_card import RoomPanel, room_command
from ..words import phrases
from ..words.menu import menu_edit
from .figure_room import room_for_drawing
from .scene_card import card_html, formulas_html, mode_row, question_html, verdict_html

Post = Callable[[Edit], int]
NOWHERE = MappingProxyType({"scene": "", "node": "", "widget": "", "button": ""})
BUTTONS = MappingProxyType({"kick": phrases.KICK, "play": phrases.PLAY})


class GuidePanel:
    """One panel for all scenes of a path; what a scene does not show is hidden."""

    def __init__(self, client: viser.ClientHandle, picture: Picture, post: Post) -> None:
        gui, self._client, self._told = client.gui, client, tuple[object, ...]()
        self._pointed: Mapping[str, str] = {}
        self._post, self._sizes = post, Sizes(picture.state)
        self._hand = viser_internals.node_id(hidden_input(gui, self._heard))
        self._head = gui.add_html(mode_row(picture, self._hand))
        self._card = gui.add_html("")
        self._widgets: dict[str, tuple[Knob, Widget]] = {}
        offered = {name for scene in picture.lesson.path for name in scene.knobs} & knobs_of(picture.lesson.path)
        for knob in picture.lesson.knobs:
            if knob.name in offered:
                self._widgets[knob.name] = knob, make_widget(
                    gui, knob, picture.state.language, lambda name, value: post(SetKnobs({name: value})),
                    lambda name, value: post(DrawByHand(name, value)))
        self._pulls = PullSliders(client, picture, post)
        self._poles = PoleSliders(client, picture, post)
        self._formulas = gui.add_html("")
        self._verdict = gui.add_html("")
        self._question = gui.add_html("")
        viser_internals.run_script(client, "sketch")
        self._room = RoomPanel(client, picture, self._hand)
        self._seeds = gui.add_html("") if picture.state.room is not None else None
        shown = {name for scene in picture.lesson.path for name in scene.figures}
        least = 2 if self._sizes.sheet else 3  # charts grow into what their card leaves, in a column
        self.charts = {figure.id: Chart(gui, figure, picture.state.language, self._sizes, picture.horizon, None, least, post)
                       for figure in picture.seen if figure.id in shown}

    @property
    def fields(self) -> dict[str, dict[str, object]]:
        """The number fields beside the sliders, as the lab's rows have them."""
        return {key: told for _, widget in self._widgets.values() if isinstance(widget, NumberWidget)
                for key, told in widget.field.items()}

    def _heard(self, said: str) -> None:
        """What a button of the card asks for: a word and a value."""
        kind, _, value = said.partition(":")
        edits: dict[str, Callable[[], Edit]] = {
            "mode": lambda: SetMode(value), "scene": lambda: GoToScene(_whole(value)), "turn": lambda: TurnScene(_whole(value)),
            "option": lambda: ChooseOption(_whole(value)), "course": ToggleCourse, "reset": RestartScene,
            "sketch": lambda: AnswerByHand(value), "kept": ShowKeptRun,
            "end": EndLecture, "record": RecordStop, "save": SaveLecture, "lesson": lambda: OpenLesson(value),
            RUN_SEEDS: RunSeeds}
        edit = edits[kind]() if kind in edits else menu_edit(kind, value) or room_command(kind, value)
        if edit is not None:
            self._post(edit)

    def show(self, picture: Picture) -> None:
        """Show the scene of a picture."""
        scene = picture.scene
        if scene is None:
            return
        write_content(self._head, mode_row(picture, self._hand))
        write_content(self._card, card_html(picture, self._hand))
        for name, (_, widget) in self._widgets.items():
            widget.show(picture.design[name], name in scene.knobs, picture)
        self._pulls.show(picture)
        self._poles.show(picture)
        if picture.resting:
            write_content(self._formulas, formulas_html(picture))
        write_content(self._verdict, verdict_html(picture, self._hand))
        write_content(self._question, question_html(picture, self._sizes, self._hand))
        self._room.show(picture)
        if self._seeds is not None and (picture.resting or picture.many is None):
            write_content(self._seeds, seeds_html(picture, self._hand))
        self._tell_notes(picture)
        self._point(picture)
        for name, chart in self.charts.items():
            if name in scene.figures:
                chart.draw_as_high_as(room_for_drawing(picture, Sizes(picture.state)))
            chart.set_visible(name in scene.figures)

    def _point(self, picture: Picture) -> None:
        """Show once where the scene wants a hand."""
        told = hand_target(picture, {name: widget for name, (_, widget) in self._widgets.items()})
        if told != self._pointed:
            self._pointed = told
            viser_internals.run_script(self._client, "hand", scene=told["scene"], node=told["node"], widget=told["widget"],
                                       button=told["button"])

    def _tell_notes(self, picture: Picture) -> None:
        """Give the speaker's window the notes of the scene, what comes next, and when the plan begins and ends it."""
        lang, talk, state = picture.state.language, picture.state.talk, picture.state
        stops, at = (picture.lesson.path, state.scene) if talk is None else (talk.stops, state.stop)
        begin = sum(stop.minutes for stop in stops[:at])
        minutes = round(minutes_of(picture.lesson.path, False) if talk is None else talk.minutes)
        words = {"notes": phrases.NOTES(lang), "next": phrases.NEXT_IS(lang), "onTime": phrases.ON_TIME(lang),
                 "behind": phrases.BEHIND.format(minutes="#")(lang), "ahead": phrases.AHEAD.format(minutes="#")(lang)}
        told = (picture.note, picture.scene_words.title, picture.next_title, begin, stops[at].minutes, minutes, lang)
        if told != self._told:
            self._told = told
            viser_internals.run_script(self._client, "presenter", hand=self._hand, note=picture.note, title=picture.scene_words.title,
                                       next=picture.next_title, begin=begin, end=begin + stops[at].minutes, minutes=minutes, words=words)

    def progress(self, fraction: float | None) -> None:
        """The guide starts no long computation."""


def _whole(value: str) -> int:
    return int(value) if value.lstrip("-").isdigit() and len(value) < 6 else -1


def hand_target(picture: Picture, widgets: Mapping[str, Widget]) -> Mapping[str, str]:
    """The scene by its lesson and id, and what of the page its action needs; all is "" where nothing is to be shown."""
    scene = picture.scene
    if scene is None or scene.id in picture.state.done or picture.state.performance is not None or not picture.resting:
        return NOWHERE
    said = {**NOWHERE, "scene": f"{picture.lesson.id}/{scene.id}"}
    if isinstance(scene.do, Press) and scene.do.button == "pull":
        return {**said, "node": _grip(picture)} if _grip(picture) else NOWHERE
    if isinstance(scene.do, Press):
        return {**said, "button": BUTTONS[scene.do.button](picture.state.language)}
    knobs = scene.do.knobs if isinstance(scene.do, Move) else scene.knobs if isinstance(scene.do, Solve) else ()
    for knob in knobs:
        if node := _cross(picture, scene, knob):
            return {**said, "node": node}
        if knob in widgets and knob in scene.knobs:
            return {**said, "widget": widgets[knob].node}
    return NOWHERE


def _grip(picture: Picture) -> str:
    """The part of the plant that can be taken hold of first, by the name of its node; "" where there is none."""
    stage = picture.outcome.stage
    return f"/plant/{stage.held[0][0].parts[0]}" if stage is not None and stage.held else ""


def _cross(picture: Picture, scene: Scene, knob: str) -> str:
    """The slowest pole that a hand moves on a board of the scene, by the name of its node; "" where there is none."""
    board = next((each for each in picture.boards if each.knob == knob and each.id in scene.boards and each.poles), None)
    if board is None:
        return ""
    slowest = max(range(len(board.poles)), key=lambda k: board.poles[k].real)
    return f"/board/{board.id}/pole{slowest}"
