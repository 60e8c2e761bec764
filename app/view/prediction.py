"""The prediction in the left column: its options, and once it is revealed what refutes the chosen one and what is so."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ..tab.commands import Edit, Predict, Reveal
from ..tab.picture import Picture
from ..text import Text, joined
from . import phrases, quirks
from .prose import judged, render

Post = Callable[[Edit], int]
LETTERS = "ABCDEFGH"


class Prediction:
    """A folder with the question and its options as sentences to press, and with the answer below."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Post) -> None:
        lang = picture.state.language
        self._words = picture.lesson.words[lang]
        with gui.add_folder(phrases.PREDICTION(lang)):
            gui.add_markdown(render(self._words.predict))
            letters = tuple(LETTERS[: len(self._words.options)])
            self._letters = gui.add_button_group("", (*letters, phrases.SKIP(lang)), visible=False)
            self._options = gui.add_html("")
            self._unveil = gui.add_button(phrases.REVEAL(lang), visible=False)
            self._answer = gui.add_markdown("")
            self._others = gui.add_html("")

        @self._letters.on_click
        async def _(event: viser.GuiEvent) -> None:
            word = event.target.value
            post(Predict(letters.index(word) if word in letters else -1))

        @self._unveil.on_click
        async def _(_: viser.GuiEvent) -> None:
            post(Reveal())

    def show(self, picture: Picture) -> None:
        """What may be pressed now, and what has been answered."""
        state = picture.state
        waiting = state.predicted is not None and not state.revealed
        if self._unveil.visible != waiting:
            self._unveil.visible = waiting
        for handle, content in ((self._options, self._sentences(picture)), (self._answer, answered(picture)),
                                (self._others, others(picture))):
            if handle.content != content:
                handle.content = content

    def _sentences(self, picture: Picture) -> str:
        """The options as sentences to press; afterwards the chosen one is marked and none can be pressed."""
        predicted, skip = picture.state.predicted, phrases.SKIP(picture.state.language)
        said = [(letter, f"<b>{letter}</b> {render(words)}") for letter, words in zip(LETTERS, self._words.options, strict=False)]
        said += [(skip, skip)] if predicted is None else []
        return "".join(
            f'<button type="button" class="ol-option{" ol-chosen" if i == predicted else ""}" data-value="{value}" '
            f'data-to="{quirks.id_of(self._letters)}"{"" if predicted is None else " disabled"}>{words}</button>'
            for i, (value, words) in enumerate(said))


def answered(picture: Picture) -> str:
    """What is said to a prediction: to a wrong one first what refutes it, then what is so."""
    state, lang = picture.state, picture.state.language
    if state.predicted is None:
        return f'<div class="ol-veil">{phrases.VEILED(lang)}</div>'
    said = phrases.SKIPPED if state.predicted < 0 else phrases.YOU_PREDICTED.format(letter=LETTERS[state.predicted])
    if not state.revealed:
        return joined(said, phrases.WATCH_FIRST)(lang)
    words = picture.lesson.words[lang]
    refuted = words.refutations[state.predicted] if state.predicted >= 0 else ""
    return "\n\n".join(part for part in (_told(picture, said), render(refuted), render(words.reveal)) if part)


def others(picture: Picture) -> str:
    """What refutes the wrong options that were not chosen, folded; nothing before the answer is revealed."""
    state, lang = picture.state, picture.state.language
    if state.predicted is None or not state.revealed:
        return ""
    told = [f"<p><b>{letter}</b> {render(words)}</p>" for i, (letter, words)
            in enumerate(zip(LETTERS, picture.lesson.words[lang].refutations, strict=False)) if words and i != state.predicted]
    return f'<details class="ol-note ol-others"><summary>{phrases.WHY_NOT(lang)}</summary>{"".join(told)}</details>' if told else ""


def _told(picture: Picture, said: Text) -> str:
    """What was predicted and what the run says, with a sign and a colour where something was predicted."""
    predicted, answer = picture.state.predicted, picture.lesson.answer
    says = phrases.WAS_RIGHT if predicted == answer else phrases.WAS_WRONG.format(letter=LETTERS[answer])
    words = joined(said, says)(picture.state.language)
    return words if predicted is None or predicted < 0 else judged(predicted == answer, words)
