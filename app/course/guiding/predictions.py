"""Give each question with options as one record: what is right, what refutes the others, what is so."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..lesson import Lesson
from ..scenes import Choose, Question, Scene

LETTERS = "ABCDEFGH"  # of the options, as everybody reads them


@dataclass(frozen=True)
class Prediction:
    """A question to be answered before the run: its options, the index of the right one, and what is said to a choice.

    A choice is the index of an option, −1 where the question was skipped.
    """

    question: str
    options: tuple[str, ...]
    refutations: tuple[str, ...]
    answer: int
    reveal: str = ""

    def refutation(self, chosen: int) -> str:
        """What breaks a wrong choice, "" for the right one and where the question was skipped."""
        return self.refutations[chosen] if 0 <= chosen < len(self.refutations) and chosen != self.answer else ""

    def others(self, chosen: int | None) -> Iterator[tuple[str, str]]:
        """The letters of the wrong options but the chosen one, and what refutes each."""
        yield from ((letter, words) for k, (letter, words) in enumerate(zip(LETTERS, self.refutations, strict=False))
                    if words and k != chosen)


NOTHING_ASKED = Prediction("", (), (), 0)


def first_prediction(lesson: Lesson, language: str) -> Prediction:
    """The question with which a lesson begins."""
    words = lesson.words[language]
    return Prediction(words.predict, words.options, words.refutations, lesson.answer, words.reveal)


def second_prediction(lesson: Lesson, language: str) -> Prediction | None:
    """The question that a knob of the lesson opens, None where it has none."""
    words = lesson.words[language].again
    if words is None or lesson.again is None:
        return None
    return Prediction(words.question, words.options, words.refutations, lesson.again.answer, words.reveal)


def prediction_of(lesson: Lesson, scene: Scene, language: str) -> Prediction:
    """The question that a scene asks, one without options where it asks none."""
    if not isinstance(scene.do, Choose):
        return NOTHING_ASKED
    if scene.do.question is Question.FIRST:
        return first_prediction(lesson, language)
    if scene.do.question is Question.SECOND:
        return second_prediction(lesson, language) or NOTHING_ASKED
    own = lesson.words[language].scenes[scene.id]
    return Prediction(own.text, own.options, own.refutations, scene.do.answer, own.say)
