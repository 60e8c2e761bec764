"""Show the two predictions in the left column: options, then why one is wrong and what is true."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ...course.guiding.predictions import LETTERS, Prediction, first_prediction, second_prediction
from ...session.commands.commands import Edit, Predict, PredictAgain, Reveal, ShowAgain
from ...session.state.view import Picture
from ...text import Text, joined
from ..charts.print_sizes import Sizes
from ..viser_private import viser_internals
from ..viser_private.write_once import write_content
from ..words import phrases
from ..words.prediction import answer_markdown, chosen_words, options_html, other_refutations_html
from ..words.prose import render_markdown

Post = Callable[[Edit], int]


class PredictionFolder:
    """A question, its options as sentences to press, what is said to the choice, and a button."""

    def __init__(self, gui: viser.GuiApi, asked: Prediction, lang: str, post: Post, *, head: Text, lead: str, visible: bool,
                 choose: Callable[[int], Edit], button: Text, press: Callable[[], Edit], button_first: bool, folded: bool = False) -> None:
        self._asked, self._lang = asked, lang
        letters, skip = tuple(LETTERS[: len(asked.options)]), phrases.SKIP(lang)
        with gui.add_folder(head(lang), visible=visible, expand_by_default=not folded) as self._folder:
            gui.add_markdown(f"{lead}{render_markdown(asked.question)}")
            self._letters = gui.add_button_group("", (*letters, skip), visible=False)
            self._options = gui.add_html("")
            if button_first:
                self._button = gui.add_button(button(lang), visible=False)
            self._answer = gui.add_markdown("")
            self._others = gui.add_html("")
            if not button_first:
                self._button = gui.add_button(button(lang), visible=False)

        @self._letters.on_click
        async def _(event: viser.GuiEvent) -> None:
            word = event.target.value
            post(choose(letters.index(word) if word in letters else -1))

        @self._button.on_click
        async def _(_: viser.GuiEvent) -> None:
            post(press())

    def show(self, visible: bool, chosen: int | None, answer: str, others: str, button: bool, frame: str = "") -> None:
        """What may be pressed now, and what is said to the choice; `frame` is the class around options that wait."""
        for handle, now in ((self._folder, visible), (self._button, button)):
            if handle.visible != now:
                handle.visible = now
        options = self._pressable(chosen)
        write_content(self._options, f'<div class="{frame}">{options}</div>' if frame and chosen is None else options)
        write_content(self._answer, answer)
        write_content(self._others, others)

    def _pressable(self, chosen: int | None) -> str:
        """The options as sentences to press; afterwards the chosen one is marked and none can be pressed."""
        hand, skip = viser_internals.node_id(self._letters), phrases.SKIP(self._lang)
        options = options_html([render_markdown(words) for words in self._asked.options],
                               None if chosen is not None else lambda k: f'data-value="{LETTERS[k]}" data-to="{hand}"',
                               lambda k: " ol-chosen" if k == chosen else "")
        if chosen is None:
            options += f'<button type="button" class="ol-option" data-value="{skip}" data-to="{hand}">{skip}</button>'
        return options


class PredictionPanel:
    """The first prediction: beside a stage one line until somebody opens it, so that the knobs are in sight."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Post) -> None:
        lang = picture.state.language
        asked = first_prediction(picture.lesson, lang)
        self._stands, self._lang = bool(asked.options), lang
        self._note = gui.add_html("")
        self._folder = PredictionFolder(gui, asked, lang, post, head=phrases.PREDICTION, lead="", visible=self._stands, choose=Predict,
                                        button=phrases.REVEAL, press=Reveal, button_first=True, folded=not Sizes(picture.state).below)

    def show(self, picture: Picture) -> None:
        """What may be pressed now, and what has been answered."""
        state = picture.state
        write_content(self._note, f'<p class="ol-veil">{phrases.VEILED(self._lang)}</p>' if picture.veiled else "")
        self._folder.show(self._stands, state.predicted, answer_words(picture), other_refutations(picture),
                          state.predicted is not None and not state.revealed)


class SecondPredictionPanel:
    """The second prediction: there while the question waits, once its knob has been moved, and after it is answered."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Post) -> None:
        lang = picture.state.language
        self._asked, self._lang, self._shown = second_prediction(picture.lesson, lang), lang, _second_stands(picture)
        if self._asked is not None:
            self._folder = PredictionFolder(gui, self._asked, lang, post, head=phrases.PREDICT_AGAIN, lead=f"*{phrases.AS_OPENED(lang)}* ",
                                            visible=self._shown, choose=PredictAgain, button=phrases.TRY_IT, press=ShowAgain,
                                            button_first=False)

    def show(self, picture: Picture) -> None:
        """The question while it waits, what is said to the choice after it."""
        stands, chosen = _second_stands(picture), picture.state.again
        if self._asked is None or not (stands or self._shown):
            return
        self._shown = stands
        others = "" if chosen is None else other_refutations_html(self._asked, chosen, self._lang)
        self._folder.show(stands, chosen, second_answer(picture), others, chosen is not None, "ol-again")


def _second_stands(picture: Picture) -> bool:
    return picture.asks_second_prediction or picture.state.again is not None


def answer_words(picture: Picture) -> str:
    """What is said to the first prediction, once the run has been seen or is revealed."""
    state, lang = picture.state, picture.state.language
    if state.predicted is None:
        return ""
    if not state.revealed:
        return joined(chosen_words(state.predicted), phrases.WATCH_FIRST)(lang)
    return answer_markdown(first_prediction(picture.lesson, lang), state.predicted, lang)


def other_refutations(picture: Picture) -> str:
    """What refutes the wrong options that were not chosen; nothing before the answer is revealed."""
    state, lang = picture.state, picture.state.language
    shown = state.predicted is not None and state.revealed
    return other_refutations_html(first_prediction(picture.lesson, lang), state.predicted, lang) if shown else ""


def second_answer(picture: Picture) -> str:
    """What is said to the second prediction, once an option is chosen or the question skipped."""
    chosen, lang = picture.state.again, picture.state.language
    asked = second_prediction(picture.lesson, lang)
    return "" if chosen is None or asked is None else answer_markdown(asked, chosen, lang)
