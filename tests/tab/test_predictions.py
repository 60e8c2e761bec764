"""What a prediction is told: veiled, then waiting, then what refutes it and what is so."""

from __future__ import annotations

import pytest
from fakes import Tab

from app.tab.commands import Predict, Reveal, SetLanguage
from app.view import phrases
from app.view.prediction import LETTERS, answered, others

REFUTED = ("never this", "", "one of them")


@pytest.mark.parametrize("choice", [0, 1, 2, -1])
def test_the_refutation_of_the_chosen_option_stands_first_and_the_others_are_folded(choice: int) -> None:
    tab = Tab()
    answer = tab.picture.lesson.answer
    assert not [words for words in REFUTED if words and words in answered(tab.picture) + others(tab.picture)]
    tab.do(Predict(choice))
    if not tab.shown.state.revealed:
        assert not [words for words in REFUTED if words and words in answered(tab.shown) + others(tab.shown)]
        tab.do(Reveal())
    verdict, *told = answered(tab.shown).split("\n\n")
    assert told == [*([REFUTED[choice]] if choice in (0, 2) else []), tab.shown.lesson.words["en"].reveal]
    assert ("✓" in verdict, "✗" in verdict) == (choice == answer, choice in (0, 2))
    folded = others(tab.shown)
    for i, words in enumerate(REFUTED):
        assert (f"<b>{LETTERS[i]}</b> {words}" in folded) == (bool(words) and i != choice)


def test_what_is_told_speaks_the_language_of_the_tab() -> None:
    tab = Tab()
    tab.do(Predict(0))
    tab.do(Reveal())
    tab.do(SetLanguage("zh"))
    assert phrases.WHY_NOT("zh") in others(tab.picture) and phrases.WHY_NOT("zh") != phrases.WHY_NOT("en")
    assert phrases.WAS_WRONG.format(letter="B")("zh") in answered(tab.picture)
