"""Keep each tab's place until it leaves, or until nobody has touched it for long."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import viser
from websockets.http11 import Request

from ..access.connection import Connection
from ..access.places import Place, Visitor
from ..access.shared_counters import WorkerSlot
from ..viser_private import page_scripts, viser_internals
from ..web.html_page import REST


@dataclass
class Tab:
    """A tab with its place; `presents` keeps it, however long nobody touches it."""

    place: Place
    connection: Connection | None
    presents: bool
    rests: bool = False


class TabPlaces:
    """The places of one worker's tabs. The event loop alone calls it."""

    def __init__(self, slot: WorkerSlot, server: viser.ViserServer, visitor: Callable[[Request, str], Visitor], idle: float,
                 clock: Callable[[], float] = time.monotonic) -> None:
        """`idle` is the time in s after which a tab that nobody touches gives its place back."""
        self._slot, self._server, self._visitor, self._idle, self._clock = slot, server, visitor, idle, clock
        self._tabs: dict[int, Tab] = {}

    def enter(self, client: viser.ClientHandle) -> bool:
        """Give a tab its place and the ticket by which it finds it again; False where there is none."""
        connection = viser_internals.connection_of(self._server, client.client_id)
        asked = connection.request if connection is not None else None
        visitor = Visitor() if connection is None or asked is None else self._visitor(asked, connection.address)
        place = self._slot.enter(visitor)
        if place is None:
            return False
        before = [number for number, tab in self._tabs.items() if tab.place.key == place.key]
        self._tabs[client.client_id] = Tab(place, connection, visitor.presents)
        for number in before:
            viser_internals.hang_up(self._server, number)
        page_scripts.give_ticket(client, self._slot.tally.places.ticket(place.key))
        return True

    def leave(self, client_id: int) -> None:
        """A tab has left."""
        tab = self._tabs.pop(client_id, None)
        if tab is not None:
            again = any(other.place.key == tab.place.key for other in self._tabs.values())
            broke = tab.connection is not None and tab.connection.broke
            self._slot.leave(tab.place, broke and not tab.rests and not again)

    def look(self) -> None:
        """End the connections of tabs that have come back elsewhere, and let those rest that nobody has touched for long."""
        now = self._clock()
        for number, tab in list(self._tabs.items()):
            if self._slot.overtaken(tab.place):
                viser_internals.hang_up(self._server, number)
            elif not (tab.presents or tab.rests) and tab.connection is not None and now - tab.connection.touched >= self._idle:
                tab.rests = True
                viser_internals.hang_up(self._server, number, REST)
