"""Lay out the knobs of a lesson: main ones in sight, the rest folded, key ones in large print."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import viser

from ...course.knobs import Knob, Poles
from ...course.many_seeds import TAB as SEEDS_TAB
from ...session.commands.commands import DrawByHand, Edit, RunJob, SetKnobs
from ...session.commands.room import RunSeeds
from ...session.state.view import Picture
from ..charts.seed_cloud import RUN_SEEDS, seeds_html
from ..viser_private import viser_internals
from ..viser_private.hidden_input import hidden_input
from ..viser_private.write_once import write_content
from ..words import phrases
from .knob_widgets import NumberWidget, Widget, make_widget

Post = Callable[[Edit], int]


class KnobRows:
    """One folder that stays in sight, with the lesson's long computation in it, and one for each set of poles."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Post) -> None:
        self._gui, self._post, self._lesson, self._lang = gui, post, picture.lesson, picture.state.language
        self._widgets: dict[str, tuple[Knob, Widget]] = {}
        self._folders: dict[str, viser.GuiFolderHandle] = {}
        self._groups: dict[tuple[str, bool], viser.GuiHtmlHandle] = {}
        self._more: viser.GuiFolderHandle | None = None
        self._bar: Any = None
        self._job: viser.GuiButtonHandle | None = None
        self._cloud: viser.GuiFolderHandle | None = None  # of many seeds: below the knobs, which stay in sight
        self._seeds: viser.GuiHtmlHandle | None = None
        self._hand = ""
        rows = [knob for knob in self._lesson.knobs if not knob.hidden and not isinstance(knob, Poles)]
        large, keys = picture.state.lecture, self._lesson.keys
        self._aside = [knob for knob in rows if (knob.name not in keys if large else knob.name in self._lesson.aside)]
        often = [knob for knob in rows if knob not in self._aside]
        with gui.add_folder(phrases.KNOBS(self._lang)):
            self._add_all(often, False)
            self._make_job()
            if self._aside:
                self._more = gui.add_folder((phrases.MORE_KNOBS if large else phrases.MORE)(self._lang), expand_by_default=False)
                with self._more:
                    self._add_all(self._aside, True)
        self._make_poles()
        self._make_seeds()

    @property
    def fields(self) -> dict[str, dict[str, object]]:
        """The number fields beside sliders, for `fields.js`: by the name of the slider whether it moves in decades, its unit …"""
        return {key: told for _, widget in self._widgets.values() if isinstance(widget, NumberWidget)
                for key, told in widget.field.items()}

    def _add_all(self, knobs: list[Knob], aside: bool) -> None:
        heading = None
        for knob in knobs:
            if knob.group is not None and knob.group != heading:
                self._groups[knob.group("en"), aside] = self._gui.add_html(f'<div class="ol-group">{knob.group(self._lang)}</div>')
            heading = knob.group
            self._add(knob)

    def _add(self, knob: Knob) -> None:
        widget = make_widget(self._gui, knob, self._lang,
                             lambda name, value: self._post(SetKnobs({name: value})),
                             lambda name, value: self._post(DrawByHand(name, value)))
        self._widgets[knob.name] = (knob, widget)

    def _make_poles(self) -> None:
        for knob in self._lesson.knobs:
            if isinstance(knob, Poles) and not knob.hidden:
                self._folders[knob.name] = self._gui.add_folder(knob.label(self._lang), expand_by_default=False)
                with self._folders[knob.name]:
                    self._gui.add_html(f'<p class="ol-note">{phrases.ON_STAGE(self._lang)}</p>')
                    self._add(knob)

    def _make_job(self) -> None:
        if self._lesson.job is None:
            return
        self._job = self._gui.add_button(f"{self._lesson.job.label(self._lang)}")
        self._bar = self._gui.add_progress_bar(0.0, visible=False)

        @self._job.on_click
        async def _(_: viser.GuiEvent) -> None:
            self._post(RunJob())

    def _make_seeds(self) -> None:
        if self._lesson.seeds is not None:
            self._hand = viser_internals.node_id(hidden_input(self._gui, self._heard))
            self._cloud = self._gui.add_folder(SEEDS_TAB(self._lang), expand_by_default=False)
            with self._cloud:
                self._seeds = self._gui.add_html("")

    def _heard(self, said: str) -> None:
        if said == RUN_SEEDS:
            self._post(RunSeeds())

    def show(self, picture: Picture) -> None:
        """The values that a picture accepts, in the rows that matter now."""
        for name, (knob, widget) in self._widgets.items():
            seen = self._lesson.shown(knob, picture.design)
            widget.show(picture.design[name], seen, picture)
            if name in self._folders:
                _reveal(self._folders[name], seen)
        standing = {(knob.group("en"), knob in self._aside) for knob, _ in self._widgets.values()
                    if knob.group is not None and self._lesson.shown(knob, picture.design)}
        for place, heading in self._groups.items():
            _reveal(heading, place in standing)
        if self._seeds is not None and (picture.resting or picture.many is None):
            written = seeds_html(picture, self._hand)
            write_content(self._seeds, written)
            if self._cloud is not None:
                _reveal(self._cloud, bool(written))
        if self._more is not None:
            _reveal(self._more, any(self._lesson.shown(knob, picture.design) for knob in self._aside))

    def progress(self, fraction: float | None) -> None:
        """The bar of the long job, and what its button does now."""
        if self._bar is None or self._job is None or self._lesson.job is None:
            return
        running = fraction is not None
        if self._bar.visible != running:
            self._bar.visible = running
            self._job.label = phrases.CANCEL_JOB(self._lang) if running else self._lesson.job.label(self._lang)
        if fraction is not None:
            self._bar.value = 100.0 * min(max(fraction, 0.0), 1.0)


def _reveal(handle: viser.GuiFolderHandle | viser.GuiHtmlHandle, seen: bool) -> None:
    if handle.visible != seen:
        handle.visible = seen
