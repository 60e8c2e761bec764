"""What one connection and one address may send: an honest page always passes, a flood never costs more than its bound."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from observer_lab.page.access.flood_guard import (
    BYTE_BURST,
    BYTES_PER_S,
    DROP_BURST,
    DROPS_PER_S,
    EARLY_BURST,
    MAX_ADDRESSES,
    MAX_FRAGMENTS,
    MAX_WAITING,
    MESSAGE_BURST,
    MESSAGES_PER_S,
    AddressBook,
    ConnectionMeter,
    TokenBucket,
)
from observer_lab.page.access.handshake import MAX_MESSAGE_BYTES


class Clock:
    """Time that a test lets pass."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def with_tab(clock: Clock) -> ConnectionMeter:
    meter = ConnectionMeter(clock)
    meter.open_tab()
    return meter


@given(st.lists(st.tuples(st.floats(0, 5), st.integers(0, 400)), min_size=1, max_size=60))
def test_no_pattern_of_sending_gets_more_than_the_burst_and_the_rate(pattern: list[tuple[float, int]]) -> None:
    clock = Clock()
    bucket, passed = TokenBucket(10.0, 50.0, clock), 0
    for pause, count in pattern:
        clock.now += pause
        passed += sum(bucket.take(1.0) for _ in range(count))
        assert passed <= 50.0 + 10.0 * clock.now + 1e-6


@pytest.mark.parametrize("per_s", [20.0, 50.0, 100.0])
def test_a_page_in_use_is_never_dropped(per_s: float) -> None:
    clock = Clock()
    meter = with_tab(clock)
    for _ in range(int(600 * per_s)):
        clock.now += 1 / per_s
        assert meter.excess(300, False) is None


def test_an_upload_in_pieces_as_a_browser_cuts_it_passes() -> None:
    clock = Clock()
    meter = with_tab(clock)
    for _ in range(3):
        assert meter.excess(16_384, False) is None
        for _ in range(MAX_MESSAGE_BYTES // 16_384):
            assert meter.excess(16_384, True) is None


@pytest.mark.parametrize("size_bytes", [0, 5, 125])
def test_a_flood_of_small_messages_is_dropped_at_the_bound(size_bytes: int) -> None:
    clock = Clock()
    meter = with_tab(clock)
    sent = 0
    while meter.excess(size_bytes, False) is None:
        clock.now += 1e-5
        sent += 1
    assert MESSAGE_BURST <= sent <= MESSAGE_BURST + MESSAGES_PER_S * clock.now + 1


def test_a_connection_without_a_tab_may_send_little() -> None:
    meter = ConnectionMeter(Clock())
    sent = 0
    while meter.excess(10, False) is None:
        sent += 1
    assert sent == EARLY_BURST


def test_a_flood_of_bytes_is_dropped_at_the_bound() -> None:
    clock = Clock()
    meter = with_tab(clock)
    sent = 0
    while meter.excess(500_000, False) is None:
        clock.now += 0.01
        sent += 500_000
    assert sent <= BYTE_BURST + BYTES_PER_S * clock.now


@pytest.mark.parametrize("size_bytes", [0, 2000])
def test_a_message_in_endless_pieces_is_dropped(size_bytes: int) -> None:
    clock = Clock()
    meter = with_tab(clock)
    assert meter.excess(1, False) is None
    pieces = 0
    while meter.excess(size_bytes, True) is None:
        clock.now += 1.0
        pieces += 1
    assert pieces == MAX_FRAGMENTS
    assert meter.excess(1, False) is None, "the next message begins to count anew"


def test_an_address_has_a_bound_of_connections_without_a_tab_and_gets_room_back() -> None:
    book = AddressBook(Clock())
    assert all(book.arrive("a") for _ in range(MAX_WAITING)) and not book.arrive("a") and book.arrive("b")
    book.leave("a")
    book.leave("a")
    assert book.arrive("a")


def test_an_address_of_which_many_are_dropped_must_wait_and_no_other() -> None:
    clock = Clock()
    book = AddressBook(clock)
    for _ in range(int(DROP_BURST)):
        book.drop("a")
    assert not book.must_wait("a")
    book.drop("a")
    assert book.must_wait("a") and not book.must_wait("b")
    clock.now += 1.0 / DROPS_PER_S
    assert not book.must_wait("a")


def test_no_number_of_addresses_fills_the_memory() -> None:
    book = AddressBook(Clock())
    for k in range(3 * MAX_ADDRESSES):
        book.arrive(str(k))
        book.leave(str(k))
    assert len(book._records) <= MAX_ADDRESSES
