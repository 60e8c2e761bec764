"""What a prediction is told: veiled, then waiting, then what refutes it and what is so."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from fakes import Tab, toy

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.guiding.predictions import LETTERS
from observer_lab.course.prose import PredictionWords
from observer_lab.page.charts.style_sheet import sheet_of
from observer_lab.page.column.prediction_panel import answer_words, other_refutations, second_answer
from observer_lab.page.words import phrases
from observer_lab.session.commands.commands import Play, Predict, PredictAgain, Reveal, SetLanguage, ShowAgain, Undo
from observer_lab.session.handlers.design import ASKS_AGAIN
from observer_lab.session.state.tab_memory import read_lesson_state

REFUTED = ("never this", "", "one of them")


@pytest.mark.parametrize("choice", [0, 1, 2, -1])
def test_the_refutation_of_the_chosen_option_stands_first_and_the_others_are_folded(choice: int) -> None:
    tab = Tab()
    answer = tab.picture.lesson.answer
    assert not [words for words in REFUTED if words and words in answer_words(tab.picture) + other_refutations(tab.picture)]
    tab.do(Predict(choice))
    if not tab.shown.state.revealed:
        assert not [words for words in REFUTED if words and words in answer_words(tab.shown) + other_refutations(tab.shown)]
        tab.do(Reveal())
    verdict, *told = answer_words(tab.shown).split("\n\n")
    assert told == [*([REFUTED[choice]] if choice in (0, 2) else []), tab.shown.lesson.words["en"].reveal]
    assert ("✓" in verdict, "✗" in verdict) == (choice == answer, choice in (0, 2))
    folded = other_refutations(tab.shown)
    for i, words in enumerate(REFUTED):
        assert (f"<b>{LETTERS[i]}</b> {words}" in folded) == (bool(words) and i != choice)


def test_what_is_told_speaks_the_language_of_the_tab() -> None:
    tab = Tab()
    tab.do(Predict(0))
    tab.do(Reveal())
    tab.do(SetLanguage("zh"))
    assert phrases.WHY_NOT("zh") in other_refutations(tab.picture) and phrases.WHY_NOT("zh") != phrases.WHY_NOT("en")
    assert phrases.WAS_WRONG.format(letter="B")("zh") in answer_words(tab.picture)


def test_a_second_prediction_waits_once_its_knob_has_moved_and_can_be_chosen_skipped_and_shown() -> None:
    asking = SecondPrediction(("gain",), 1, {"gain": 6.0}, ("response",))
    words = {language: replace(prose, again=PredictionWords("again?", ("this", "that", "neither"), REFUTED, "so it is"))
             for language, prose in toy("first").words.items()}
    tab = Tab({"first": toy("first", again=asking, words=words)})
    tab.set(gain=2.0)
    assert not tab.picture.asks_second_prediction, "the first prediction comes first"
    tab.do(PredictAgain(0))
    assert tab.picture.state.again is None
    tab.do(Predict(1))
    assert not tab.picture.asks_second_prediction, "what was moved before is no question now"
    tab.set(gain=3.0)
    assert tab.picture.asks_second_prediction and ":response:" in sheet_of(tab.picture) and not second_answer(tab.picture)
    tab.do(Undo())
    tab.do(Undo())
    assert not tab.picture.asks_second_prediction and ":response:" not in sheet_of(tab.picture)
    tab.do(Play())
    tab.run_for(0.5)
    assert tab.picture.state.t > 0
    tab.set(gain=2.0)
    assert tab.picture.state.t == 0 and not tab.picture.state.moving, "the stage would answer"
    assert tab.view.sentences()[-1] == ASKS_AGAIN
    tab.do(PredictAgain(7))
    tab.do(ShowAgain())
    assert tab.picture.asks_second_prediction and tab.picture.design["gain"] == 2.0
    tab.do(PredictAgain(2))
    verdict, *told = second_answer(tab.picture).split("\n\n")
    assert "✗" in verdict and told == [REFUTED[2], "so it is"]
    assert not tab.picture.asks_second_prediction and ":response:" not in sheet_of(tab.picture) and tab.picture.state.playing
    tab.do(ShowAgain())
    assert tab.picture.design["gain"] == 6.0 and not tab.picture.asks_second_prediction
    tab.rest()
    assert read_lesson_state(json.loads(tab.view.kept)["desks"]["first"], "first", tab.lessons).again == 2
