"""Show the derivation in the left column, step by step, with the present numbers."""

from __future__ import annotations

from collections.abc import Mapping

import viser

from ...course.exercises.derivation import DerivationStep, Value, insert_numbers
from ...course.lesson import Outcome
from ...session.state.view import Picture
from ..words import phrases
from ..words.prose import equation_html, render_markdown


class DerivationPanel:
    """A folder with one for each step; not there until a prediction is made, since formulas would answer it.

    The numbers stand in parts of their own, so that new ones leave open what was opened.
    """

    def __init__(self, gui: viser.GuiApi, picture: Picture) -> None:
        self._lang = picture.state.language
        self._steps: tuple[DerivationStep, ...] = picture.lesson.words[self._lang].derivation
        self._now: list[viser.GuiHtmlHandle] = []
        self._folder: viser.GuiFolderHandle | None = None
        self._shown: Outcome | None = None
        if not self._steps:
            return
        self._folder = gui.add_folder(phrases.DERIVE(self._lang), expand_by_default=False, visible=picture.state.predicted is not None)
        with self._folder:
            for count, step in enumerate(self._steps, 1):
                with gui.add_folder(f"{count} {step.heading}", expand_by_default=False):
                    gui.add_html(self._told(step))
                    self._now.append(gui.add_html(""))

    def _told(self, step: DerivationStep) -> str:
        return (f'{equation_html(step.equation)}<p class="ol-note">{render_markdown(step.text)}</p>'
                f'<details class="ol-note ol-why"><summary>{phrases.WHY(self._lang)}</summary>{render_markdown(step.why)}</details>')

    def show(self, picture: Picture) -> None:
        """The folder where a prediction was made, and the present numbers of a picture at rest."""
        open_now = picture.state.predicted is not None
        if self._folder is None or (not open_now and not self._folder.visible):
            return
        if self._folder.visible != open_now:
            self._folder.visible = open_now
        if not open_now or not picture.resting or self._shown is picture.outcome:
            return
        self._shown = picture.outcome
        values = picture.lesson.derived(picture.outcome)
        for handle, step in zip(self._now, self._steps, strict=True):
            content = numbers_of_step(step, values, picture.lesson.origin is not None, self._lang)
            if handle.content != content:
                handle.content = content


def numbers_of_step(step: DerivationStep, values: Mapping[str, Value], theirs: bool, lang: str) -> str:
    """The present numbers of a step; on a person's own plant (`theirs`) a sentence where it puts none in."""
    line = insert_numbers(step, values)
    if line:
        return f'<p class="ol-caption">{phrases.PUT_IN(lang)}</p>{equation_html(line)}'
    return f'<p class="ol-caption">{phrases.NOT_YOURS(lang)}</p>' if theirs else ""
