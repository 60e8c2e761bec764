"""Show the prediction in the left column: options, then why an option is wrong and what is true."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ...session.commands.commands import Edit, Predict, Reveal
from ...session.state.view import Picture
from ...text import Text, joined
from ..viser_private import viser_internals
from ..words import phrases
from ..words.prose import judged_html, render_markdown

Post = Callable[[Edit], int]
LETTERS = "ABCDEFGH"


class PredictionPanel:
    """A folder with the question and its options as sentences to press, and with the answer below."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Post) -> None:
        lang = picture.state.language
        self._words = picture.lesson.words[lang]
        with gui.add_folder(phrases.PREDICTION(lang), visible=bool(self._words.options)):
            gui.add_markdown(render_markdown(self._words.predict))
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
        for handle, content in ((self._options, self._sentences(picture)), (self._answer, answer_words(picture)),
                                (self._others, other_refutations(picture))):
            if handle.content != content:
                handle.content = content

    def _sentences(self, picture: Picture) -> str:
        """The options as sentences to press; afterwards the chosen one is marked and none can be pressed."""
        return sentences(self._words.options, picture.state.predicted, viser_internals.node_id(self._letters), picture.state.language)


def sentences(options: tuple[str, ...], chosen: int | None, hand: str, lang: str) -> str:
    """Options as sentences to press for the buttons `hand`; once one is chosen it is marked and none can be pressed."""
    skip = phrases.SKIP(lang)
    said = [(letter, f"<b>{letter}</b> {render_markdown(words)}") for letter, words in zip(LETTERS, options, strict=False)]
    said += [(skip, skip)] if chosen is None else []
    return "".join(
        f'<button type="button" class="ol-option{" ol-chosen" if i == chosen else ""}" data-value="{value}" '
        f'data-to="{hand}"{"" if chosen is None else " disabled"}>{words}</button>' for i, (value, words) in enumerate(said))


def answer_words(picture: Picture) -> str:
    """What is said to a prediction: to a wrong one first what refutes it, then what is so."""
    state, lang = picture.state, picture.state.language
    if state.predicted is None:
        return f'<div class="ol-veil">{phrases.VEILED(lang)}</div>'
    said = phrases.SKIPPED if state.predicted < 0 else phrases.YOU_PREDICTED.format(letter=LETTERS[state.predicted])
    if not state.revealed:
        return joined(said, phrases.WATCH_FIRST)(lang)
    words = picture.lesson.words[lang]
    refuted = words.refutations[state.predicted] if state.predicted >= 0 else ""
    told = _told(said, state.predicted, picture.lesson.answer, lang)
    return "\n\n".join(part for part in (told, render_markdown(refuted), render_markdown(words.reveal)) if part)


def other_refutations(picture: Picture) -> str:
    """What refutes the wrong options that were not chosen, folded; nothing before the answer is revealed."""
    state, lang = picture.state, picture.state.language
    shown = state.predicted is not None and state.revealed
    return folded_refutations(picture.lesson.words[lang].refutations, state.predicted, lang) if shown else ""


def folded_refutations(refutations: tuple[str, ...], chosen: int | None, lang: str) -> str:
    """What refutes the wrong options but the chosen one, folded."""
    told = [f"<p><b>{letter}</b> {render_markdown(words)}</p>" for i, (letter, words)
            in enumerate(zip(LETTERS, refutations, strict=False)) if words and i != chosen]
    return f'<details class="ol-note ol-others"><summary>{phrases.WHY_NOT(lang)}</summary>{"".join(told)}</details>' if told else ""


def second_answer(picture: Picture) -> str:
    """What is said to the second prediction, once an option is chosen or the question skipped."""
    state, lang, asked = picture.state, picture.state.language, picture.lesson.words[picture.state.language].again
    if state.again is None or asked is None or picture.lesson.again is None:
        return ""
    said = phrases.SKIPPED if state.again < 0 else phrases.YOU_PREDICTED.format(letter=LETTERS[state.again])
    refuted = asked.refutations[state.again] if state.again >= 0 else ""
    told = _told(said, state.again, picture.lesson.again.answer, lang)
    return "\n\n".join(part for part in (told, render_markdown(refuted), render_markdown(asked.reveal)) if part)


def _told(said: Text, chosen: int, answer: int, lang: str) -> str:
    """What was predicted and what the run says, with a sign and a colour where something was predicted."""
    says = phrases.WAS_RIGHT if chosen == answer else phrases.WAS_WRONG.format(letter=LETTERS[answer])
    words = joined(said, says)(lang)
    return words if chosen < 0 else judged_html(chosen == answer, words)
