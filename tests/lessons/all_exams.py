"""Every exam over many seeds: its answer beside independent code, its digits, its words in every language, its derivation.

    python tests/lessons/all_exams.py [seeds] [lesson …]
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    tests = Path(__file__).resolve().parents[1]
    sys.path[:0] = [str(tests.parent), str(tests), str(tests / "lessons")]

from exam_oracles import ORACLES
from put_in import sides

from observer_lab.course.exercises.derivation import PLACE, fill_placeholders
from observer_lab.course.exercises.exam import Exam, ExamItem
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS

EQUATION = re.compile(r"\$\$(.+?)\$\$", re.S)
MARKED = re.compile(r"[_^](\{[^{}]*\}|\\?\w+)")  # indices and powers are no numbers given
NUMBER = re.compile(r"\d+(?:\.\d+)?")
CARRIED = 3e-5  # relative, of a number on the way that is printed with six digits
MAGNITUDE = re.compile(r"how (?:large|strongly|far|much|many|long|late)\b|by how", re.I)  # asks for what has no sign
IDLE = re.compile(r"(?<![\d._^{])[01]\s*(?:\\,|\\cdot)?\s*(?:[a-z](?!\w)|\\(?:hat|dot|omega|theta)\b)")  # 1 x, 0 x
ENTRY = re.compile(r"(?:matrix\}|&|\\\\)\s*\(-[\d.]+\)\s*(?:&|\\\\|\\end)")  # a bracket about an entry of a matrix
SCALE = re.compile(r"(?<![\d.])(?<!\]\]\}\{)1000|10\^6|\\frac\{180\}")  # of milliseconds, microvolts, degrees
CLOSE = 1e-6  # relative, of an answer beside its oracle and of the two sides of an equation
FEW, OF = 10, 50  # so many different answers at least over so many seeds


def wrong_item(lesson: Lesson, exam: Exam, item: ExamItem) -> Iterator[str]:
    """What is wrong with one draw."""
    values, answer, digits = {**item.given, **item.steps}, item.answer, exam.digits
    if not all(np.all(np.isfinite(v)) for v in values.values()):
        yield "a number is not finite"
    found = float(ORACLES[lesson.id, exam.id](dict(item.given)))
    if not abs(found - answer) <= CLOSE * max(1.0, abs(answer)):
        yield f"the answer is {answer!r} and independently {found!r}"
    said, unit = float(digits.written(answer)), digits.unit(answer)
    if not digits.accepts(answer, said) or any(digits.accepts(answer, said + slip * unit) for slip in (-1, 1)):
        yield f"{digits.written(answer)} for {answer!r} is judged wrongly"
    for language, prose in lesson.words.items():
        statement = fill_placeholders(prose.exams[exam.id].statement, item.given)
        shown = [float(n) for n in NUMBER.findall(MARKED.sub("", statement))]
        if any(abs(n - abs(answer)) <= unit * 0.5 for n in shown):
            yield f"{language}: the statement contains the answer {answer!r}: {statement}"
        given = [abs(float(v)) for name in PLACE.findall(prose.exams[exam.id].statement) for v in np.ravel(item.given[name])]
        if not all(any(math.isclose(v, n, rel_tol=1e-9) for n in shown) for v in given):
            yield f"{language}: the statement rounds a number: {item.given}: {statement}"
    if answer < 0 and MAGNITUDE.search(lesson.words["en"].exams[exam.id].statement):
        yield f"the statement asks how large, the answer is {answer}"
    shown = (
        fill_placeholders(lesson.words["en"].exams[exam.id].statement, item.given),
        exam.derived(lesson.words["en"].exams[exam.id].derivation, item),
    )
    yield from (f"written raw: {found[0]}" for text in shown for law in (IDLE, ENTRY) for found in law.finditer(text))
    yield from (f"printed: {line}" for line in EQUATION.findall(shown[1]) if not printed_leads(line, digits.written(answer), unit))
    for line in EQUATION.findall(lesson.words["en"].exams[exam.id].derivation):
        for equation, both in sides(line.replace(r"\approx", "="), {**values, "answer": answer}):
            scale = max((float(np.max(np.abs(v))) for v in (*values.values(), answer)), default=1.0)
            if any(np.shape(v) != np.shape(both[0]) or not np.allclose(v, both[0], rtol=CLOSE, atol=CLOSE * scale) for v in both[1:]):
                yield f"{equation} gives {both}"


def printed_leads(line: str, said: str, unit: float) -> bool:
    """Whether what is printed last in each equation follows from the numbers printed before it: the answer to its last digit."""
    for equation, both in sides(line.replace(r"\approx", "="), {}):
        answers = equation.rpartition("=")[2].strip().strip(",") == said
        if any(abs(v - both[-1]) > (0.5001 * unit if answers else CARRIED * abs(v)) for v in both[:-1]):
            return False
    return True


def wrong_words(lesson: Lesson, exam: Exam) -> Iterator[str]:
    """What is wrong with the words of an exam, whatever is drawn."""
    item = exam.item(0)
    values = exam.values(item)
    lines = {language: EQUATION.findall(prose.exams[exam.id].derivation) for language, prose in lesson.words.items()}
    if len({tuple(found) for found in lines.values()}) != 1:
        yield "the languages derive by different equations"
    for language, prose in lesson.words.items():
        words = prose.exams[exam.id]
        missing = (set(PLACE.findall(words.statement)) - set(item.given)) | (set(PLACE.findall(words.derivation)) - set(values))
        if missing:
            yield f"{language}: no number for {missing}"
        if PLACE.search(re.sub(r"\$\$?.+?\$\$?", "", words.statement + words.derivation, flags=re.S)):
            yield f"{language}: a number stands outside mathematics"
        if any(SCALE.search(line) and re.search(r"[a-z]\s*=", line) for line in lines[language]):
            yield f"{language}: a factor of units stands beside symbols that have none"
        if "[[answer]]" not in words.derivation:
            yield f"{language}: the derivation does not end in the answer"
    if not any(list(sides(line.replace(r"\approx", "="), {**item.given, **item.steps, "answer": item.answer})) for line in lines["en"]):
        yield "no equation of the derivation can be computed"


def wrong(lesson: Lesson, exam: Exam, seeds: range) -> Iterator[str]:
    """What is wrong with an exam over these seeds."""
    yield from (f"{lesson.id}/{exam.id}: {found}" for found in wrong_words(lesson, exam))
    for seed in seeds:
        yield from (f"{lesson.id}/{exam.id}, seed {seed}: {found}" for found in wrong_item(lesson, exam, exam.item(seed)))
    differing = {exam.digits.written(exam.item(seed).answer) for seed in range(OF)}
    if len(differing) < FEW:
        yield f"{lesson.id}/{exam.id}: only {len(differing)} different answers over {OF} seeds"


def main(seeds: int = 500, *ids: str) -> None:
    """A row for each exam: how many draws were wrong, the range of its answers, and the first faults."""
    total = bad = 0
    for lesson in LESSONS.values():
        for exam in lesson.exams if not ids or lesson.id in ids else ():
            found = list(wrong(lesson, exam, range(seeds)))
            answers = [exam.item(seed).answer for seed in range(seeds)]
            print(f"{lesson.id + '/' + exam.id:36s} {len(found):4d} wrong, answers {min(answers):10.4g} … {max(answers):10.4g}, "
                  f"{len(set(answers)):4d} different", *(f"\n    {line}" for line in found[:3]), flush=True)
            total, bad = total + 1, bad + bool(found)
    print(f"{total} exams over {seeds} seeds each, {bad} with faults")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 500, *sys.argv[2:])
