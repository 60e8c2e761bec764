"""The table of fifty kinds of plant file: which are read, which are refused, each by one sentence."""

from __future__ import annotations

from plant_files_table import files, row

REFUSED = frozenset((
    "JSON, Ts = −1", "JSON, Ts and dt differ", "JSON, h = 0.1", "JSON, fs = 10", "JSON, TimeUnit minutes",
    "JSON, E singular", "JSON, InputDelay 0.5 samples", "JSON, InternalDelay", "JSON, A and a",
    "JSON, a key nobody knows", "JSON, a key twice", "JSON, improper fraction", "JSON, one lonely complex pole", "complex",
    "an object alone", "two structs", "201 states", "version 7.3", "a picture"))


def test_fifty_kinds_of_file_are_read_or_refused_as_the_table_says() -> None:
    said = {title: row(*file) for title, file in files()}
    assert len(said) >= 50
    assert {title for title, words in said.items() if words.startswith("refused: ")} == REFUSED
    assert all("\n" not in words and words.endswith(".") for words in said.values())
