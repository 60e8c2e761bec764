"""The queue of all tabs: in order, hands first, nobody for ever."""

from __future__ import annotations

import threading
import time

from fakes import Clock
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.session.runtime.scheduler import BACKGROUND_SHARE_S, MAX_TURN_S, Scheduler

TURN = 0.501 * BACKGROUND_SHARE_S  # s that a turn takes here: two of them are a share


def queued(turns: Scheduler, clock: Clock, ranks: list[bool], served: list[int]) -> list[threading.Thread]:
    """Threads that wait in this order."""
    def work(number: int, hand: bool) -> None:
        with turns.turn(hand):
            clock.advance(TURN)
            served.append(number)
    threads = []
    for number, hand in enumerate(ranks):
        threads.append(threading.Thread(target=work, args=(number, hand)))
        threads[-1].start()
        while turns.waiting <= number:
            time.sleep(0)
    return threads


@settings(max_examples=20)
@given(st.lists(st.booleans(), max_size=14))
def test_hands_come_first_in_order_and_leave_room_for_two_short_turns(ranks: list[bool]) -> None:
    clock, served = Clock(), list[int]()
    turns = Scheduler(clock=clock)
    with turns.turn(True):
        threads = queued(turns, clock, ranks, served)
    for thread in threads:
        thread.join()
    hands, others = ([k for k, hand in enumerate(ranks) if hand is rank] for rank in (True, False))
    wanted: list[int] = []
    while hands or others:  # the turn that all waited for was a hand's
        wanted += others[:2] + hands[:1]
        hands, others = hands[1:], others[2:]
    assert served == wanted and not turns.waiting


def test_a_long_turn_nobody_asked_for_is_paid_back_by_the_next_ones() -> None:
    clock, served = Clock(), list[bool]()
    turns = Scheduler(clock=clock)

    def work(hand: bool) -> None:
        with turns.turn(hand):
            clock.advance(TURN if hand else 4 * BACKGROUND_SHARE_S)
            served.append(hand)
    with turns.turn(True):
        threads = []
        for number, hand in enumerate([True] * 8 + [False] * 3):
            threads.append(threading.Thread(target=work, args=(hand,)))
            threads[-1].start()
            while turns.waiting <= number:
                time.sleep(0)
    for thread in threads:
        thread.join()
    assert served == [False, *[True] * 4, False, *[True] * 4, False], "four turns of a hand for one of four shares"


def test_whoever_works_too_long_is_not_waited_for() -> None:
    clock, served = Clock(), list[int]()
    turns = Scheduler(lease=0.01, clock=clock)
    with turns.turn(True):
        first, second = queued(turns, clock, [True, False], served)
        assert not served
        clock.advance(MAX_TURN_S)
        first.join()
        second.join()
        assert sorted(served) == [0, 1]
    with turns.turn(False):  # whose lease had ended takes nobody's turn away when it comes to an end
        assert not turns.waiting
