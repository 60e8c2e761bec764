"""The sampled laws exist, each keeps a case, and `--whole` leaves nothing out."""

from __future__ import annotations

from pathlib import Path

from laws import each
from sampling import SAMPLED, left_out, taken

HERE = Path(__file__).parent


@each("law", SAMPLED)
def test_a_law_that_is_sampled_exists(law: str) -> None:
    file, _, name = law.partition("::")
    assert f"def {name}(" in (HERE / file).read_text(encoding="utf-8")


@each("count", range(1, 30))
def test_every_law_keeps_a_case_and_laws_take_turns(count: int) -> None:
    for every in (2, 3, 4):
        kept = [set(taken(f"law {k}", range(count), every)) for k in range(40)]
        assert all(kept) and all(len(some) <= -(-count // every) for some in kept)
        assert set().union(*kept) == set(range(count)), "a case that no law meets"


def test_what_is_left_out_is_every_case_but_those_of_the_turn_and_no_case_of_another_law() -> None:
    law = next(iter(SAMPLED))
    names = ["another::law"] * 5 + [law] * 9 + ["another::law"]
    out = left_out(names, str)
    assert out < set(range(5, 14)) and 14 - 5 - len(out) == len(taken(law, range(9), SAMPLED[law].every))
