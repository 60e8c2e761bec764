"""Let all pages of a presenter do what a hand does on one of them, at this worker and at others."""

from __future__ import annotations

import json
import logging
import queue
import secrets
import threading
import time
from collections.abc import Callable
from functools import partial

import viser

from ...classroom.kept_room import KeptPages, KeptRoom
from ...session.commands.commands import Edit, Play, RunOnTabThread
from ...session.commands.guide import TurnedTo, TurnScene
from ...session.commands.room import LeadShown, PerformAnswer, Reveal
from ...session.commands.written import MIRRORED, read_edit, write_edit
from ...session.session import Session
from ..words import phrases
from .broadcast import Broadcast
from .presenter_view import PresenterScreen

POLL_S = 0.03  # s between two looks at what hands have done at other workers
LOOK_S = 0.25  # s between two questions to the store: which page leads, and what it shows
AGAIN_S = 1.5  # s after which the lead is shown again: a page under a hand does not follow at once
LEAD_S = 3.0  # s for which a worker leads without saying so again

log = logging.getLogger(__name__)


class PresenterPages:
    """The pages of who presents, at one worker. One page of all workers leads: what it shows is what the class sees.

    A hand's command goes to the other pages here at once, and through the store to those elsewhere. What the lead shows at rest
    follows it.
    """

    def __init__(self, room: KeptRoom, pages: KeptPages, woken: Callable[[], object]) -> None:
        self._room, self._pages = room, pages
        self.broadcast = Broadcast(pages, woken, self._keep_state, self._stop_leading)
        self._open: dict[int, tuple[Session, PresenterScreen]] = {}
        self._name = secrets.token_hex(8)  # of this worker, in what it writes down
        self._done: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._woken, self._closed, self._fails = threading.Event(), False, False
        self._mark: str | None = None  # up to where the others' commands are done, None while nobody presents here
        self._state = ""
        self._due = self._again = 0.0

    def start(self) -> None:
        """Begin the threads."""
        self.broadcast.start()
        threading.Thread(target=self._run, name="observer-lab presenters", daemon=True).start()

    def close(self) -> None:
        """End the threads."""
        self._closed = True
        self._woken.set()
        self.broadcast.close()

    @property
    def sessions(self) -> list[Session]:
        """The sessions of the pages that are open here."""
        return [session for session, _ in list(self._open.values())]

    # --- on the event loop -----------------------------------------------------------------------------------------
    def screen(self, client: viser.ClientHandle) -> PresenterScreen:
        """The screen of a page that presents; it leads, and those before it follow it as it follows them."""
        self._stop_leading()
        self.broadcast.lead()
        return PresenterScreen(client, self.broadcast)

    def enter(self, client_id: int, session: Session, screen: PresenterScreen) -> None:
        """A page presents."""
        self._open[client_id] = session, screen
        session.mirror = partial(self._mirror, session)
        self._woken.set()

    def leave(self, client_id: int) -> None:
        """A tab has left. If it led, the one before it leads again, here or at another worker."""
        left = self._open.pop(client_id, None)
        if left is not None and left[1].leads:
            if self._open:
                self._lead()
            else:
                self._woken.set()

    # --- leading ---------------------------------------------------------------------------------------------------
    def _lead(self) -> None:
        session, screen = next(reversed(self._open.values()))
        screen.leads = True
        self.broadcast.lead()
        session.post(RunOnTabThread(screen.lead_again))

    def _stop_leading(self) -> None:
        for session, screen in list(self._open.values()):
            if screen.leads:
                screen.leads = False
                session.post(RunOnTabThread(partial(screen.say, phrases.TWO_PAGES, False)))

    def _keep_state(self, token: str) -> None:
        self._room.keep_state(token)
        self._follow(token)

    def _follow(self, token: str) -> None:
        for session, screen in list(self._open.values()):
            if not screen.leads:
                session.post(LeadShown(token))

    # --- commands --------------------------------------------------------------------------------------------------
    def _mirror(self, one: Session, edit: Edit) -> None:
        """Let the other pages of the presenter do what a hand has done on one."""
        mine = one.picture
        if isinstance(edit, Reveal):  # the vote itself is in the store
            edit = PerformAnswer()
        if isinstance(edit, TurnScene) and mine is not None:  # a page that lags behind is not turned from where it happens to be
            edit = TurnedTo(mine.place[0])
        if not isinstance(edit, MIRRORED):
            return
        playing = mine is not None and mine.state.playing
        self._post(edit, playing, one)
        try:
            self._done.put(json.dumps([self._name, playing, write_edit(edit)]))
        except TypeError as problem:
            log.warning("a command stays at its worker: %s", problem)
        self._woken.set()

    def _post(self, edit: Edit, playing: bool, but: Session | None = None) -> None:
        """Do a command on the pages here; a run that plays on both pages is not stopped on the other."""
        for session in self.sessions:
            theirs = session.picture
            if session is not but and theirs is not None and not (isinstance(edit, Play) and theirs.state.playing == playing):
                session.post(edit, mirrored=True)

    # --- the thread ------------------------------------------------------------------------------------------------
    def _run(self) -> None:
        led = False
        while not self._closed:
            self._woken.wait(POLL_S if self._open else LOOK_S)
            self._woken.clear()
            try:
                led = self._round(led)
                self._fails = False
            except Exception:
                if not self._fails:
                    log.exception("the presenter's pages at other workers cannot be reached")
                self._fails = True
                self._woken.wait(LOOK_S)

    def _round(self, led: bool) -> bool:
        """What is due; whether a page here leads."""
        leads = any(screen.leads for _, screen in list(self._open.values()))
        if not self._open:
            self._mark = None
            if led:
                self._pages.end_lead()
            return False
        if self._mark is None:
            self._mark = self._pages.last_act()
        while not self._done.empty():
            self._pages.add_act(self._done.get())
        for mark, words in self._pages.acts_after(self._mark):
            self._mark = mark
            worker, playing, edit = json.loads(words)
            if worker != self._name:
                self._post(read_edit(edit), playing)
        if time.monotonic() >= self._due:
            self._due = time.monotonic() + LOOK_S
            if leads:
                self._pages.keep_lead(LEAD_S)
            elif not self._pages.is_led():  # the page that led has left, or its worker has ended
                self._lead()
            self._follow_again(self._room.state)
        return leads

    def _follow_again(self, state: str) -> None:
        """Show what the lead shows, when it changes and then from time to time: a page was under a hand, or has come meanwhile."""
        now = time.monotonic()
        if state and (state != self._state or self._again <= now):
            self._again, self._state = now + AGAIN_S, state
            self._follow(state)
