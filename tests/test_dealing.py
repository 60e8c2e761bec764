"""What takes long begins first on every worker, nothing is lost, and files that share something stay together."""

from __future__ import annotations

import random

from dealing import HOUSE, dealt
from laws import each

FILES = [("e2e", f"test_page{k}.py", 5) for k in range(12)] + [("engine", f"test_engine{k}.py", 40) for k in range(20)] + [
    (name, name, 10) for name in ("test_kernels.py", "test_package.py", *sorted(HOUSE))]
TESTS = [(folder, file, k) for folder, file, count in FILES for k in range(count)]


def where(test: tuple[str, str, int]) -> tuple[str, str]:
    return test[:2]


@each("workers", [1, 2, 3, 4, 7])
def test_every_worker_begins_with_what_takes_long_and_ends_with_what_is_short(workers: int) -> None:
    found, given = dealt(TESTS, workers, where), 0
    assert sorted(found) == sorted(TESTS)
    for k in range(workers):  # as `--dist worksteal` gives them
        size = (len(found) - given) // (workers - k)
        short = [folder == "engine" for folder, _, _ in found[given:given + size]]
        assert not short[0] and short[-1] and short == sorted(short), f"worker {k}"
        given += size
    files = [file for k, (_, file, _) in enumerate(found) if k == 0 or found[k - 1][1] != file]
    for name in {file for folder, file, _ in TESTS if folder != "engine"}:
        assert files.count(name) == 1, f"{name} is divided"
    at = sorted(files.index(name) for name in HOUSE)
    assert at == list(range(at[0], at[0] + len(HOUSE)))


@each("seed", range(20))
def test_a_choice_of_tests_is_dealt_whole(seed: int) -> None:
    """Fewer tests than workers, long ones alone, short ones alone."""
    rng = random.Random(seed)
    some = [test for test in TESTS if rng.random() < rng.choice((0.005, 0.3))] if seed else []
    for workers in (1, 3):
        assert sorted(dealt(some, workers, where)) == sorted(some)
