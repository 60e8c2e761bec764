"""Write a prediction as HTML for guide, lab, audience and votes: options, verdict, refutation."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...course.guiding.predictions import LETTERS, Prediction
from ...text import Text, joined
from . import phrases
from .prose import judged_html, render_markdown


def options_html(options: Sequence[str], press: Callable[[int], str] | None, marks: Callable[[int], str] = lambda k: "") -> str:
    """The options, HTML each, as sentences to press: `press` gives the attributes of each, None where none can be pressed.

    `marks` gives further classes: of the one that was chosen, of the right one.
    """
    return "".join(f'<button type="button" class="ol-option{marks(k)}"{" disabled" if press is None else f" {press(k)}"}>'
                   f"<b>{LETTERS[k]}</b> {words}</button>" for k, words in enumerate(options))


def verdict_html(asked: Prediction, chosen: int, language: str, in_guide: bool = False) -> str:
    """What was chosen and what is right, with a sign and a colour where something was chosen."""
    if in_guide:
        said = phrases.YOU_CHOSE_RIGHT if chosen == asked.answer else phrases.YOU_CHOSE.format(
            letter=LETTERS[chosen], answer=LETTERS[asked.answer])
    else:
        said = joined(chosen_words(chosen), phrases.WAS_RIGHT if chosen == asked.answer
                      else phrases.WAS_WRONG.format(letter=LETTERS[asked.answer]))
    return said(language) if chosen < 0 else judged_html(chosen == asked.answer, said(language))


def chosen_words(chosen: int) -> Text:
    """That a prediction was made, or skipped."""
    return phrases.SKIPPED if chosen < 0 else phrases.YOU_PREDICTED.format(letter=LETTERS[chosen])


def answer_markdown(asked: Prediction, chosen: int, language: str) -> str:
    """What is said to a prediction: the verdict, to a wrong one what refutes it, then what is so."""
    told = (verdict_html(asked, chosen, language), render_markdown(asked.refutation(chosen)), render_markdown(asked.reveal))
    return "\n\n".join(filter(None, told))


def other_refutations_html(asked: Prediction, chosen: int | None, language: str) -> str:
    """What refutes the wrong options that were not chosen, folded."""
    told = "".join(f"<p><b>{letter}</b> {render_markdown(words)}</p>" for letter, words in asked.others(chosen))
    return f'<details class="ol-note ol-others"><summary>{phrases.WHY_NOT(language)}</summary>{told}</details>' if told else ""
