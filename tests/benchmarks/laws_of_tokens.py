"""Random states of every lesson through their tokens, and torn tokens: `python tests/benchmarks/laws_of_tokens.py [COUNT]`.

The suite tries a few of each; this tries COUNT (1,000) and prints what it tried and the longest token.
"""

from __future__ import annotations

import random
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parents[1]), str(Path(__file__).parents[1] / "tab")]

from hypothesis import HealthCheck, Phase, given, settings  # noqa: E402
from test_token import mutated, one_sentence, saves  # noqa: E402

from observer_lab.course.lesson import Lesson  # noqa: E402
from observer_lab.lessons import LESSONS  # noqa: E402
from observer_lab.session.state.token import read_token, write_token  # noqa: E402


def law(lesson: Lesson, count: int) -> None:
    """Try `count` states of a lesson, and as many torn tokens."""
    lengths: list[int] = []
    refused: list[bool] = []
    chance = random.Random(1)

    @settings(max_examples=count, deadline=None, database=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
    @given(saves(lesson))
    def survives(saved: object) -> None:
        token = write_token(lesson, saved)
        assert read_token(token, LESSONS) == saved
        lengths.append(len(token))
        refused.append(one_sentence(mutated(token, chance)))

    survives()
    print(f"{lesson.id}: {len(lengths)} states survive, the longest token has {max(lengths)} characters; "
          f"{sum(refused)} of {len(refused)} torn tokens refused in one sentence", flush=True)


if __name__ == "__main__":
    for each in LESSONS.values():
        law(each, int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
