"""Say whose hand-ins lie where: by the names of folders, or by a table of places and keys."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..course.exercises.exam import canonical_key
from .inputs import read_text
from .options import CommandError

MOODLE_TAIL = "_assignsubmission"  # of the names in Moodle's archive of submissions: what follows is the same for all
MAP_HELP = "give a CSV file with two columns, the name of a folder or file and a student's key"
DELIMITERS = ",;\t"


@dataclass(frozen=True)
class HandInPlaces:
    """The folders that `grade` was given. With `folders` each student's has the key for its name; a table says whose a place is."""

    given: tuple[Path, ...]
    folders: bool = False
    table: dict[str, frozenset[str]] | None = None

    @classmethod
    def of(cls, given: Sequence[str], folders: bool = False, table: str | None = None) -> HandInPlaces:
        """Those of the words of a command line. Raises CommandError at a table that cannot be read."""
        return cls(tuple(Path(word) for word in given), folders, None if table is None else _table(table))

    def place(self, source: str) -> str:
        """What tells the sources of two students apart: the first folder below a given one, else the file."""
        return self._parts(source)[0].partition(MOODLE_TAIL)[0]

    def stranger(self, source: str, student: str) -> str | None:
        """Why a hand-in of a student cannot come from that source, None where it can."""
        place, key = self.place(source), canonical_key(student)
        if self.folders and (len(self._parts(source)) == 1 or canonical_key(place) != key):
            return f"it does not lie in a folder with the name {student}"
        if self.table is None or key in (owners := self._owners(place)):
            return None
        return f"the table gives {place[:80]} to {', '.join(sorted(owners))}" if owners else f"the table does not name {place[:80]}"

    def _parts(self, source: str) -> tuple[str, ...]:
        path = Path(source)
        root = next((folder for folder in self.given if path != folder and path.is_relative_to(folder)), path.parent)
        return path.relative_to(root).parts or (source,)

    def _owners(self, place: str) -> frozenset[str]:
        """Of the names that the table has: the place itself, else the longest that the place continues with an underscore."""
        assert self.table is not None
        names = [name for name in self.table if place == name or place.startswith(f"{name}_")]
        return self.table[max(names, key=len)] if names else frozenset()


def _table(name: str) -> dict[str, frozenset[str]]:
    words = read_text(name, "map", MAP_HELP).removeprefix("\ufeff")
    delimiter = next((sign for sign in words.partition("\n")[0] if sign in DELIMITERS), ",")
    found: dict[str, frozenset[str]] = {}
    try:
        rows = list(csv.reader(words.splitlines(), delimiter=delimiter))
    except csv.Error as problem:
        raise CommandError(f"The map file {name[:80]} is no CSV ({problem}); {MAP_HELP}.") from problem
    for number, row in enumerate(rows, 1):
        if not row:
            continue
        if len(row) != 2 or not all(part.strip() for part in row):
            raise CommandError(f"Line {number} of the map file {name[:80]} has no two columns; {MAP_HELP}.")
        place, key = row[0].strip().partition(MOODLE_TAIL)[0], canonical_key(row[1])
        found[place] = found.get(place, frozenset()) | {key}
    return found
