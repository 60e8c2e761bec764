"""Law B, a sample: every verdict word on cards, captions, checks and tasks is true by a witness that uses no lesson's code.

The whole, 3 × 100 designs of each lesson and own plants: `python tests/lessons/verdict_law.py --whole [LESSON …]`.
"""

from __future__ import annotations

import pytest
from lesson_checks import every_lesson
from verdict_law import every_design, table, tried
from verdict_words import VERDICT_WORDS, words_in

from observer_lab.course.lesson import Lesson

# lessons none of whose verdict words is without a witness
JUDGED = frozenset({"saturation", "duality", "virtual-sensor", "error-dynamics", "separation", "hidden-modes"})
SAMPLED = 1


@every_lesson
def test_no_verdict_word_is_false(lesson: Lesson) -> None:
    found = tried(every_design(lesson, SAMPLED, 0, lesson.number))
    told = table({lesson.id: found})
    assert not found.false, "\n".join([told, *(f"{word}: {lies[0]}" for word, lies in found.false.items())])
    assert lesson.id not in JUDGED or not found.unseen, "\n".join([told, *found.unseen])
    assert found.designs > found.refused


@pytest.mark.parametrize("word", VERDICT_WORDS)
def test_a_verdict_word_says_what_it_needs_and_what_voids_it(word: str) -> None:
    entry = VERDICT_WORDS[word]
    assert len(entry.condition.split()) > 3 and entry.voided_by
    assert word in words_in(SAID[word]) and not words_in("The force is 3 N.")


SAID = {
    "unstable": "The loop is unstable.", "stable": "The loop is stable.", "grows": "The error grows.", "decays": "The error decays.",
    "settles": "The error settles.", "recovers": "The pole recovers.", "lost": "This start is lost.",
    "not decided": "It is not decided within 3 s.",
    "bounded": "The mean that the filter expects stays bounded.", "consistent": "The filter is consistent.",
    "over-confident": "The filter is over-confident.", "under-confident": "The filter is under-confident.",
    "white": "The innovations are white.", "follows": "The error follows ė = (A − LC)e.", "least": "Least RMS velocity: LQE.",
    "identified": "VL is correctly identified.", "found": "The load is found to 5 %.", "unaffected": "The estimate is unaffected.",
    "observable": "The plant is not observable.", "tolerated": "Up to 69 % can be tolerated."}
