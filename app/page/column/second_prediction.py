"""Show the second prediction in the left column once its knob has been moved."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ...session.commands.commands import Edit, PredictAgain, ShowAgain
from ...session.state.view import Picture
from ..viser_private import viser_internals
from ..words import phrases
from ..words.prose import render_markdown
from .prediction_panel import LETTERS, folded_refutations, second_answer, sentences


class SecondPredictionPanel:
    """A folder that is there while the question waits and after it is answered."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Callable[[Edit], int]) -> None:
        self._lang = picture.state.language
        asked = picture.lesson.words[self._lang].again
        self._folder: viser.GuiFolderHandle | None = None
        if picture.lesson.again is None or asked is None:
            return
        self._asked = asked
        self._folder = gui.add_folder(phrases.PREDICT_AGAIN(self._lang), visible=self._stands(picture))
        with self._folder:
            gui.add_markdown(f"*{phrases.AS_OPENED(self._lang)}* {render_markdown(asked.question)}")
            letters = tuple(LETTERS[: len(asked.options)])
            self._letters = gui.add_button_group("", (*letters, phrases.SKIP(self._lang)), visible=False)
            self._options = gui.add_html("")
            self._answer = gui.add_markdown("")
            self._others = gui.add_html("")
            self._trial = gui.add_button(phrases.TRY_IT(self._lang), visible=False)

        @self._letters.on_click
        async def _(event: viser.GuiEvent) -> None:
            word = event.target.value
            post(PredictAgain(letters.index(word) if word in letters else -1))

        @self._trial.on_click
        async def _(_: viser.GuiEvent) -> None:
            post(ShowAgain())

    def _stands(self, picture: Picture) -> bool:
        return picture.asks_second_prediction or picture.state.again is not None

    def show(self, picture: Picture) -> None:
        """The question while it waits, what is said to the choice after it."""
        stands, chosen = self._stands(picture), picture.state.again
        if self._folder is None or not (stands or self._folder.visible):
            return
        if self._folder.visible != stands:
            self._folder.visible = stands
        folded = "" if chosen is None else folded_refutations(self._asked.refutations, chosen, self._lang)
        options = sentences(self._asked.options, chosen, viser_internals.node_id(self._letters), self._lang)
        for handle, content in ((self._options, f'<div class="ol-again">{options}</div>' if chosen is None else options),
                                (self._answer, second_answer(picture)), (self._others, folded)):
            if handle.content != content:
                handle.content = content
        if self._trial.visible != (chosen is not None):
            self._trial.visible = chosen is not None
