"""A tab's thread may ring for the loop: whoever waits is woken by the loop alone, and by every ring."""

from __future__ import annotations

import asyncio
import threading
from typing import Any

from observer_lab.page.viser_private.adapter import TabBuffer
from observer_lab.page.viser_private.thread_event import LoopEvent


def in_a_thread(call: Any) -> None:
    thread = threading.Thread(target=call)
    thread.start()
    thread.join()


def test_a_ring_from_a_thread_touches_nobody_who_waits_and_the_loop_wakes_them_all() -> None:
    async def waits() -> None:
        bell = LoopEvent()
        waiting = [asyncio.create_task(bell.wait()) for _ in range(3)]
        await asyncio.sleep(0)
        in_a_thread(bell.set)
        assert bell.is_set()
        for _ in range(5):
            await asyncio.sleep(0)
        assert not any(task.done() for task in waiting), "another thread has woken them"
        bell.set()
        assert await asyncio.wait_for(asyncio.gather(*waiting), 30) == [True] * 3
        bell.clear()
        assert not bell.is_set()
        in_a_thread(bell.set)
        assert await bell.wait()  # at once
    asyncio.run(waits())


def test_what_a_tab_writes_to_rings_so() -> None:
    async def writes() -> None:
        assert type(TabBuffer(asyncio.get_running_loop(), persistent=False).message_event) is LoopEvent
    asyncio.run(writes())
