"""Every promise of the threat model names the tests that hold it, and they exist."""

from __future__ import annotations

import re
from pathlib import Path

from laws import each

TESTS = Path(__file__).parent
MODEL = TESTS.parent / "assets" / "threat-model.md"
ROWS = [[cell.strip() for cell in line.strip("|\n").split(" | ")] for line in MODEL.read_text(encoding="utf-8").splitlines()
        if line.startswith("| ") and not line.startswith("| door ")]
CODE = {path.relative_to(TESTS).as_posix(): path.read_text(encoding="utf-8") for path in TESTS.rglob("*.py")}
ALL = "\n".join(CODE.values())


def named(cell: str) -> list[str]:
    """The files and functions that a cell names."""
    return re.findall(r"`([\w/]+(?:\.py)?)`", cell)


def missing(name: str) -> bool:
    """Whether no test has that name; a file must hold a test of its own or be a benchmark with a verdict."""
    if name.endswith(".py"):
        words = CODE.get(name, "")
        return not (re.search(r"^\s*def test_", words, re.MULTILINE) or (name.startswith("benchmarks/") and "__main__" in words))
    return re.search(rf"^\s*def {name}\(", ALL, re.MULTILINE) is None


@each("row", ROWS)
def test_a_promise_names_the_tests_that_hold_it(row: list[str]) -> None:
    door, who, lock, tests = row
    assert door and who and lock, row
    found = named(tests)
    assert found or tests.startswith("same"), f"no test holds: {door}"
    assert not [name for name in found if missing(name)], door


def test_a_promise_without_a_test_is_found() -> None:
    assert missing("test_that_nobody_wrote") and missing("wire/test_none.py") and not missing("test_gate.py")


def test_the_numbers_that_the_model_states_are_those_of_the_code() -> None:
    from observer_lab.page.access import connection, flood_guard, handshake

    words = MODEL.read_text(encoding="utf-8")
    for said in (f"gone out for {connection.SEND_TIMEOUT_S:.0f} s", f"{connection.TAB_TIMEOUT_S:.0f} s for a tab",
                 f"{flood_guard.MAX_WAITING} of them for one address", f"at most {handshake.MAX_MESSAGE_BYTES // 1024} KB each"):
        assert said in words, said
    assert flood_guard.DROP_BURST == 5 and flood_guard.DROPS_PER_S == 0.1, "six in a minute, ten seconds"
