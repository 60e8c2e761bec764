"""The queue of all tabs: in order, hands first, nobody for ever."""

from __future__ import annotations

import threading
import time

from fakes import Clock
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.session.runtime.scheduler import BACKGROUND_SHARE_S, MAX_TURN_S, Scheduler

TURN = BACKGROUND_SHARE_S / 2.5  # s that a turn takes here


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
def test_hands_come_first_in_order_and_leave_room_for_three_short_turns(ranks: list[bool]) -> None:
    clock, served = Clock(), list[int]()
    turns = Scheduler(clock=clock)
    with turns.turn(True):
        threads = queued(turns, clock, ranks, served)
    for thread in threads:
        thread.join()
    hands, others = ([k for k, hand in enumerate(ranks) if hand is rank] for rank in (True, False))
    wanted: list[int] = []
    while hands or others:  # the turn that all waited for was a hand's
        wanted += others[:3] + hands[:1]
        hands, others = hands[1:], others[3:]
    assert served == wanted and not turns.waiting


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
