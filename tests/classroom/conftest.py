"""Stores of one room, as several workers have them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from observer_lab.classroom.kept_room import KeptPages, KeptRoom, Place, open_pages, open_room


@pytest.fixture
def room(place: Place) -> Iterator[Callable[[], KeptRoom]]:
    """One more store of the same room each time, as another worker has it."""
    made: list[KeptRoom] = []

    def make() -> KeptRoom:
        made.append(open_room(place))
        return made[-1]
    yield make
    for each in made:
        each.close()


@pytest.fixture
def pages(place: Place) -> Iterator[Callable[[], KeptPages]]:
    """One more store of the same pages each time."""
    made: list[KeptPages] = []

    def make() -> KeptPages:
        made.append(open_pages(place))
        return made[-1]
    yield make
    for each in made:
        each.close()


@pytest.fixture
def store(room: Callable[[], KeptRoom]) -> KeptRoom:
    return room()
