"""Draw the numbers of an exam from a student's key, compute the answer, judge what is typed."""

from __future__ import annotations

import hashlib
import math
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TypeVar

import numpy as np

from ...text import Text, text
from .derivation import Value, fill_placeholders
from .typed_answers import evaluate_typed

T = TypeVar("T")
MAX_DRAWS = 500  # after so many unfit ones a generator is wrong
LONGEST_KEY = 60  # characters of a key that count
TIE_DISTANCE = 0.01  # of a digit: no answer lies nearer to where rounding turns from one digit to the next
TRIVIAL = (0.0, 1.0, 2.0)  # answers that need no work, and stand in most statements
WORKING_DIGITS = 6  # digits of the numbers on the way: put in as printed, they lead to the answer as printed
DIGIT_ROUNDING = 1e-6  # of a digit, what floating point may add to a rounded answer


@dataclass(frozen=True)
class Digits:
    """How many digits the text asks for: the sentence that says so, and the answers that pass, follow from it."""

    kind: str  # "whole", "decimals" or "significant"
    count: int = 0

    @property
    def asked(self) -> Text:
        """The sentence under the statement."""
        if self.kind == "whole":
            return text("The answer is exactly a whole number: do not round on the way.")
        if self.kind == "significant":
            return text("Give {count} significant figures.", count=self.count)
        if self.count == 0:
            return text("Round to a whole number.")
        return text("Give one decimal.") if self.count == 1 else text("Give {count} decimals.", count=self.count)

    def unit(self, answer: float) -> float:
        """The worth of the last digit that is asked for."""
        if self.kind != "significant":
            return 10.0 ** -self.count
        return 10.0 ** (math.floor(math.log10(abs(answer))) - self.count + 1) if answer else 1.0

    def accepts(self, answer: float, said: float) -> bool:
        """Whether `said` is the answer to the digits asked for: half the last digit off at most; a whole number exactly."""
        half = 0.0 if self.kind == "whole" else 0.5
        return abs(said - answer) <= (half + DIGIT_ROUNDING) * self.unit(answer)  # false for NaN

    def nearly(self, answer: float, said: float) -> bool:
        """Whether `said` may be the answer rounded too much or on the way: near it by the last digits asked for."""
        return self.kind != "whole" and abs(said - answer) <= min(5 * self.unit(answer), 0.05 * abs(answer))

    def fair(self, answer: float) -> bool:
        """Whether the answer is finite and every way of rounding it leads to the same digits."""
        if not math.isfinite(answer):
            return False
        rest = answer / self.unit(answer) % 1.0
        return min(rest, 1 - rest) <= DIGIT_ROUNDING if self.kind == "whole" else abs(rest - 0.5) >= TIE_DISTANCE

    def telling(self, answer: float) -> bool:
        """Whether at least two of the digits asked for say something: 0.03 would pass for anything from 0.025 to 0.035."""
        return self.kind != "decimals" or self.count == 0 or abs(answer) >= 9.5 * self.unit(answer)

    def written(self, answer: float) -> str:
        """The answer with the digits asked for."""
        near = round(answer, self._places(answer)) + 0.0
        return f"{near:.{max(self._places(near), 0)}f}"

    def _places(self, answer: float) -> int:
        return -round(math.log10(self.unit(answer)))


WHOLE_NUMBER = Digits("whole")


def decimals(count: int) -> Digits:
    """So many digits behind the decimal point."""
    return Digits("decimals", count)


def significant(count: int) -> Digits:
    """So many digits from the first that is not 0."""
    return Digits("significant", count)


class SeededDraws:
    """Draws that are the same on every machine and with every version of a library: SHA-256 of the seed and a count."""

    def __init__(self, seed: object) -> None:
        self._seed, self._count = str(seed), 0

    def whole(self, low: int, high: int) -> int:
        """A whole number from low to high, both among them."""
        self._count += 1
        drawn = hashlib.sha256(f"{self._seed}/{self._count}".encode()).digest()
        return low + int.from_bytes(drawn[:8], "big") % (high - low + 1)

    def part(self, low: int, high: int, parts: int = 10) -> float:
        """A whole number from low to high over `parts`, in tenths unless told otherwise."""
        return self.whole(low, high) / parts

    def one(self, values: Sequence[T]) -> T:
        """One of the values."""
        return values[self.whole(0, len(values) - 1)]

    def some(self, values: Sequence[T], count: int) -> tuple[T, ...]:
        """So many of the values, no place twice."""
        left = list(values)
        return tuple(left.pop(self.whole(0, len(left) - 1)) for _ in range(count))


@dataclass(frozen=True)
class ExamItem:
    """One draw: the numbers that the statement gives, the right answer, and further numbers for the derivation."""

    given: Mapping[str, Value]
    answer: float
    steps: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True)
class Exam:
    """One exam of a lesson: its words stand under `## exam <id>`. `draw` gives None, or an unfit item, to be drawn again."""

    id: str
    digits: Digits
    draw: Callable[[SeededDraws], ExamItem | None]

    def item(self, seed: object) -> ExamItem:
        """The item of a seed: the first drawn whose answer is fair, not trivial, has two digits to give and is no number given."""
        return _item(self, str(seed))

    def values(self, item: ExamItem) -> dict[str, Value | str]:
        """The numbers for the places of the derivation; `answer` bears the digits asked for."""
        return {**item.given, **item.steps, "answer": self.digits.written(item.answer)}

    def derived(self, words: str, item: ExamItem) -> str:
        """The derivation with the numbers of this item."""
        return fill_placeholders(words, self.values(item), WORKING_DIGITS)

    def _fit(self, item: ExamItem | None) -> bool:
        if item is None or not self.digits.fair(item.answer):
            return False
        if not self.digits.telling(item.answer):
            return False
        near = self.digits.unit(item.answer) * (0.5 + DIGIT_ROUNDING)
        shown = (*TRIVIAL, *(abs(float(v)) for value in item.given.values() for v in np.ravel(value)))
        return all(abs(v - abs(item.answer)) > near for v in shown)


@lru_cache(maxsize=512)
def _item(exam: Exam, seed: str) -> ExamItem:
    for attempt in range(MAX_DRAWS):
        item = exam.draw(SeededDraws(f"{seed}#{attempt}"))
        if item is not None and exam._fit(item):
            return item
    raise RuntimeError(f"exam {exam.id} draws nothing fit with seed {seed}")


def canonical_key(student: str) -> str:
    """A student's key without what does not count: capitals, widths of letters, blanks at its ends and runs of blanks."""
    return " ".join(unicodedata.normalize("NFKC", student).casefold().split())[:LONGEST_KEY]


def seed_of(student: str, lesson: str, exam: str, variant: int) -> str:
    """The seed for a student's key where no course draws the numbers. Variant 0 is the withheld one."""
    key = canonical_key(student)
    return hashlib.sha256("\n".join((key, lesson, exam, str(variant))).encode("utf-8", "surrogatepass")).hexdigest()


def number_of(said: str) -> float:
    """A number as a person writes it: 0.05, −1.2, 0,05, 5e-2, 5·10⁻², 1/3, √2. Raises Unreadable."""
    return evaluate_typed(said, {})
