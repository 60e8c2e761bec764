"""What the page says is true at the knobs' stops and at random designs; the whole trial is `claim_trials.py`."""

from __future__ import annotations

import numpy as np
import pytest
from attack import random_designs
from claim_trials import TABLES, WITNESSES, aimed, extremes, tried
from hypothesis import given
from hypothesis import strategies as st
from lesson_checks import CJK, every_lesson

from observer_lab.course.figures.claims import Claim, claim, claims_in
from observer_lab.course.lesson import Lesson
from observer_lab.text import NO_WORDS, joined, text
from observer_lab.text.languages import translated

SAID, ELSE = text("It dies out."), text("It grows.")


@pytest.mark.slow
@every_lesson
def test_no_claim_lies(lesson: Lesson) -> None:
    ends = extremes(lesson)
    pick = np.random.default_rng(lesson.number).permutation(len(ends))[:4]
    found = tried(lesson, [ends[0], *(ends[k] for k in pick), *random_designs(lesson, 4, lesson.number),
                           *aimed(lesson, 12, lesson.number)])
    assert not found.lies, "\n".join(f"{said}: {'; '.join(where)}" for said, where in found.lies.items())
    assert not found.mixed, "\n".join(found.mixed)


@given(st.floats(allow_nan=True), st.floats(-1e3, 1e3))
def test_a_claim_is_made_on_its_side_of_the_edge_alone(value: float, edge: float) -> None:
    said = claim(SAID, value, below=edge, otherwise=ELSE)
    assert isinstance(said, Claim) == (value < edge) and said("en") == ("It dies out." if value < edge else "It grows.")
    if isinstance(said, Claim):
        assert said.margin >= 0 and (said.value, said.edge) == (value, edge)
    assert claim(SAID, float("nan"), above=edge) is NO_WORDS


def test_claims_are_found_inside_sentences() -> None:
    inner = claim(SAID, -1.0, below=0.0)
    assert [w for w in claims_in(joined(ELSE, text("So: {what}", what=inner))) if isinstance(w, Claim)] == [inner]


def test_every_witness_knows_a_sentence_that_a_lesson_can_say() -> None:
    assert len(WITNESSES) == sum(map(len, TABLES)), "a sentence has two witnesses"
    unknown = [said for said in WITNESSES if not CJK.search(translated(said, "", "zh"))]
    assert not unknown, unknown
