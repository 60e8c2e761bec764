"""Nothing English on the Chinese page: every word of every lesson, also on the example plants, in Chinese or a known name."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Mapping
from typing import Any

import pytest
from laws import holds_for_all

from observer_lab.course.figures.records import MapFigure
from observer_lab.course.lesson import Design, Lesson
from observer_lab.lessons import LESSONS
from observer_lab.plants.examples import EXAMPLES, example
from observer_lab.plants.own_plant import plant_of, read_plant_file
from observer_lab.plants.signal_names import SIGNALS, in_unit, signal_name, title_of, with_unit
from observer_lab.text import Text, languages, same, symbol

WORD = re.compile(r"(?<![A-Za-z\\_])[A-Za-z]{3,}")
FORMULA = re.compile(r"\[\[\w+(?::[^\]]*)?\]\]|"  # live numbers; mathematics, code, places for numbers
                     r"\$+[^$]*\$+|`[^`]*`|\{\w+\}|\\[A-Za-z]+|<[^>]*>|[A-Za-z]+\([^)]*\)")
CODES = frozenset({"id", "role", "mark", "dash", "colour", "scale", "kind", "side", "knob", "also", "name", "symbol", "default", "when",
                   "value", "parts", "source", "plant",  # fields of plain text that no page shows
                   "equation", "now", "press"})  # and mathematics
# What Chinese control literature writes in Latin letters: units, functions, people, methods.
FUNCTIONS = frozenset(WORD.findall("min max log eig rank det diag cos sin exp cov vec tr"))  # of something; alone they are words
KNOWN = FUNCTIONS | frozenset(WORD.findall("""
    mrad rad rpm kHz dB
    Cramér Rao Box Jenkins Padé
    LQR LQG LQE PBH NIS NEES EKF UKF RLO ADC SISO MIMO RMS LTR CRLB
    Riccati Gram Hankel Nyquist Joseph Doyle Lyapunov Bode Kalman Tustin windup Luenberger Duan Athans Wishner Bertolini
    Julier Uhlmann sigma maxon
    Observer Lab Hautus Popov Belevitch Page"""))

TERM = re.compile(r"(?<=[\u4e00-\u9fff])（[A-Za-z][A-Za-z ]*）")


def shown(record: Any, field: str = "", language: str = "zh") -> Iterator[str]:
    """Every text that a record brings to the page, in a language; plain strings where they are not codes."""
    if isinstance(record, Text):
        yield symbol(record(language))
    elif isinstance(record, str):
        if field not in CODES:
            yield symbol(record)
    elif isinstance(record, MapFigure):
        yield from shown((record.title, record.x_label, record.y_label, record.caption, [name for name, _ in record.categories]),
                         language=language)
    elif dataclasses.is_dataclass(record):
        for item in dataclasses.fields(record):
            yield from shown(getattr(record, item.name), item.name, language)
    elif isinstance(record, Mapping):
        for value in record.values():
            yield from shown(value, field, language)
    elif isinstance(record, (tuple, list)):
        for value in record:
            yield from shown(value, field, language)


def page(lesson: Lesson, design: Design, language: str = "zh") -> Iterator[str]:
    """What the page shows of a design: figures, boards, stage, numbers, knobs, verdicts."""
    outcome = lesson.compute(design)
    body = outcome.stage.body if outcome.stage is not None else None
    knobs = [(knob.label, knob.hint, knob.group, [words for _, words in getattr(knob, "options", ())]) for knob in lesson.knobs]
    yield from shown((lesson.figures(outcome), outcome.live, outcome.checks, outcome.boards, knobs,
                      None if body is None else (body.caption, [words for words, _ in body.labels], [name.words for name in body.names]),
                      tuple(task.check(outcome).text for task in lesson.tasks),
                      None if lesson.job is None else lesson.job.label), language=language)


def english(texts: Iterator[str]) -> dict[str, list[str]]:
    """Texts with words that are not known names, but for a term in brackets behind the Chinese one, to look it up by."""
    found = {text: [w for w in WORD.findall(TERM.sub(" ", FORMULA.sub(" ", text)))
                    if w not in KNOWN or (w in FUNCTIONS and text.strip() == w)] for text in texts}
    return {text: words for text, words in found.items() if words}


@pytest.mark.parametrize("lesson", LESSONS.values(), ids=list(LESSONS))
def test_a_lesson(lesson: Lesson) -> None:
    assert not english(page(lesson, lesson.start()))
    assert not english(shown(dataclasses.replace(lesson.words["zh"], source="", references=())))  # titles are found in their own language


@pytest.mark.parametrize("lesson", [it for it in LESSONS.values() if it.adapt is not None],
                         ids=[k for k, it in LESSONS.items() if it.adapt is not None])
def test_a_lesson_on_the_examples(lesson: Lesson) -> None:
    def law(key: str) -> None:
        fitted = lesson.fit(example(key))
        assert not english(page(fitted, fitted.start()))
        assert not english(shown(fitted.words["zh"].introduction))
    holds_for_all(EXAMPLES, law)


def test_every_name_of_an_example_is_known_in_both_languages() -> None:
    def law(key: str) -> None:
        plant = plant_of(example(key))
        names = {n for n in (*plant.state_names, *plant.input_names, *plant.output_names) if not re.fullmatch(r"[a-z]\d+", n)}
        assert set(SIGNALS[plant.name]) == names
        assert all(signal_name(plant, n)("en") == n != signal_name(plant, n)("zh") for n in names)
        assert title_of(plant)("en") == plant.name and EXAMPLES[key].label("zh").startswith(title_of(plant)("zh"))
    holds_for_all(EXAMPLES, law)


def test_the_names_of_a_persons_own_plant_stay_as_they_are() -> None:
    plant = plant_of(
        read_plant_file("mine.json", b'{"A": [[-1]], "B": [[1]], "C": [[1]], "states": ["current"], "units": {"current": "A"}}')
    )
    assert with_unit(plant, "current")("zh") == "current [A]"
    assert signal_name(plant, "current") == same("current") and with_unit(plant, "current") == in_unit(same("current"), "A")
    assert title_of(plant)("zh") == "你的对象" and languages() == ("en", "zh")


def test_an_english_word_would_be_seen() -> None:
    assert english(iter(["输出 yaw gyro", "滞后 [采样]", "eig(A − BK)", "$x=\\mathrm{lag}$"])) == {"输出 yaw gyro": ["yaw", "gyro"]}
