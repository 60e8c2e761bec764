"""Serve the app: one session with its own screen for every tab."""

from __future__ import annotations

import logging
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from importlib import import_module
from urllib.parse import parse_qs

import viser
from PIL import Image

from ...classroom.room import VoteDesk
from ...course.handin.learner import Learner
from ...course.handin.served_course import ServedCourse
from ...course.lectures import Lecture
from ...course.lesson import Lesson
from ...course.scenes import Mode
from ...session.commands.commands import Refuse, RunOnTabThread
from ...session.commands.files import LessonsChanged
from ...session.session import WATCHDOG, Session
from ...session.state.own_lessons import ReadLessons
from ..access.access_policy import AccessPolicy, Refusal
from ..access.addresses import is_public, listen, url
from ..access.connection import Connection
from ..access.handshake import RETRY_AFTER_S, AdmissionControl
from ..access.memory_arena import resident_bytes, share_one_arena
from ..access.page_headers import PageHeaders
from ..access.places import Visitor
from ..access.proxies import TrustedProxies
from ..access.shared_counters import SharedCounters, WorkerSlot
from ..access.tokens import AccessToken
from ..column.plant_picker import MOST_BYTES
from ..viser_private import viser_internals
from ..web.html_page import server_full_page, token_required_page, version
from ..words import phrases
from .screen import Screen
from .server_parts import LaunchDoors, Room
from .tab_places import TabPlaces

log = logging.getLogger(__name__)

NEEDED = ("imageio.v3", "babel.numbers")  # by which viser packs pictures, and a language its decimal sign
STOP_TIMEOUT_S = 5.0  # s within which a server has stopped, whatever its tabs are doing
SWITCH_INTERVAL_S = 5e-4  # s that a computing thread keeps the interpreter for, while the one that talks to all browsers waits
LAST_MESSAGE_S = 0.5  # s in which the last word goes out
OWN, FOLLOW = "own", "follow"  # of an address: a copy of one's own, and the lecture also for who presents
END_POLL_S = 0.1  # s within which it hears of its end
HEALTH_INTERVAL_S = 5.0  # s between two times that other workers are told how this one is


class LabServer:
    """Observer Lab on a port: every tab that connects gets a session, every tab that leaves takes it away."""

    def __init__(self, lessons: Mapping[str, Lesson], host: str = "127.0.0.1", port: int = 8080,
                 lesson: str = "separation", language: str = "en", max_sessions: int = 200, plant: str = "",
                 names: Iterable[str] = (), state: str = "", insists: bool = False, sealed: bool = False, access: AccessToken | None = None,
                 frames: Iterable[str] = (), listener: socket.socket | None = None, slot: WorkerSlot | None = None,
                 mode: Mode = "lab", talk: Lecture | None = None, course: ServedCourse | None = None,
                 room: Room | None = None, presenter: AccessToken | None = None, doors: LaunchDoors | None = None,
                 proxies: TrustedProxies | None = None, idle: float = float("inf"), read_lessons: ReadLessons | None = None) -> None:
        """`state` is what a tab opens with that brings none, as a token or the words of a file. A new tab goes on where the last one
        of its browser was, unless the server `insists` on its lesson or has a state. `sealed` offers no practice of exams.
        `frames` are the sites that may show the page inside theirs.

        `mode` is how a tab shows a lesson that has a path: scene by scene, or all at once.

        `course` draws the numbers of exams and signs hand-ins.

        `listener` stands in the place of host and port where one listens already, `slot` in that of `max_sessions` where several
        processes count together.

        In a `room` a tab follows unless it knows the word of `presenter` or asks to work on its own.

        `doors` let learning platforms open lessons. `proxies` may say for whom they ask.

        A tab gives its place back after `idle` seconds in which nobody has touched it; who presents keeps theirs.

        `read_lessons` reads the .zip of lessons that a page brings for its own tab, None where none may; who presents to a room has
        those of the server.

        Raises OSError where it cannot listen, ValueError at a name that is none.
        """
        sys.setswitchinterval(SWITCH_INTERVAL_S)
        share_one_arena()
        self._lessons = lessons
        self._lesson, self._language, self._plant, self._state = lesson, language, plant, state
        self._insists, self._sealed, self._talk, self._course = insists, sealed, talk, course
        self._mode: Mode = mode
        self._read_lessons = read_lessons
        self._lag = 0.0  # s that the event loop took to answer when it was asked last
        self._sessions: dict[int, Session] = {}
        self._screens: dict[int, Screen] = {}
        self._slot = slot or WorkerSlot(SharedCounters(1, max_sessions), 0)
        self._host, self._room, self._presenter, self._doors = host, room, presenter, doors
        admission = AdmissionControl(AccessPolicy.of(host, is_public(host), names), access, self._write_down, self.health, self._full,
                                     token_required_page(language), PageHeaders(tuple(frames)), presenter, doors,
                                     proxies or TrustedProxies(), self._slot.tally.places.key_of)
        self._server = viser_internals.open_server(listener or listen(host, port), admission, language)
        self._places = TabPlaces(self._slot, self._server, admission.visitor, idle)
        if room is not None:
            room.start(self._server.get_event_loop())
        self._server.on_client_connect(self._enter)
        self._server.on_client_disconnect(self._leave)

    @property
    def url(self) -> str:
        """Where the page is: the port may differ from the one asked for, when that was taken."""
        return url(self._host, self._server.get_port())

    @property
    def sessions(self) -> Mapping[int, Session]:
        """The open tabs' sessions."""
        return self._sessions

    def replace_lessons(self, lessons: Mapping[str, Lesson]) -> None:
        """Offer these lessons too, in place of those of the same id; open tabs take them over."""
        self._lessons = {**self._lessons, **lessons}
        for session in list(self._sessions.values()):
            session.post(LessonsChanged(lessons))

    def health(self) -> Mapping[str, object]:
        """What `GET /health` answers: nothing of any person."""
        self._note()
        kept = [each for each in (self._room, None if self._course is None else self._course.signed) if each is not None]
        store = {"store": "failing" if any(each.failing for each in kept) else "ok"} if kept else {}
        status = "degraded" if "failing" in store.values() else "ok"
        return {"status": status, "version": version(), **self._slot.health(), **store}

    def _note(self) -> None:
        self._slot.note(WATCHDOG.stuck, resident_bytes(), self._lag)

    def _full(self, visitor: Visitor) -> str:
        """The page for whoever comes while there is no place for them, else nothing."""
        return server_full_page(self._language, self._slot.most, RETRY_AFTER_S) if self._slot.full(visitor) else ""

    @staticmethod
    def _write_down(refusal: Refusal) -> None:
        log.warning("refused: %s", refusal.words)

    async def _enter(self, client: viser.ClientHandle) -> None:
        if not self._places.enter(client):
            client.add_notification("Observer Lab", f"This server is full ({self._slot.most} tabs). Close one and reload.",
                                    color="red")
            return
        try:
            self._open(client)
        except BaseException:
            self._places.leave(client.client_id)
            raise

    def _open(self, client: viser.ClientHandle) -> None:
        connection, room, number = viser_internals.open_tab(self._server, client.client_id), self._room, client.client_id
        if room is None or connection is None:
            self._begin_launched(client, connection)
            return
        role = self._role(connection)
        if role == FOLLOW:
            viser_internals.accept_values_only(client, lambda: None)
            viser_internals.accept_small_files_only(client, 0, lambda: None)
            room.follow(client, connection)
        elif role == "present":
            screen = room.presenter_screen(client)
            room.present(number, self._work(client, screen, room.state, room), screen)
        else:
            room.work_alone(number, self._work(client, room.own_screen(client)))

    def _begin_launched(self, client: viser.ClientHandle, connection: Connection | None) -> None:
        """Begin a session for whom a learning platform has sent, or for anybody."""
        request = None if connection is None else connection.request
        if self._doors is None or request is None or not self._doors.asked(request.path):
            self._work(client, Screen(client))
            return
        learner = self._doors.learner(request.path, request.headers)
        session = self._work(client, Screen(client), learner=learner)
        if learner is None:
            session.post(Refuse(phrases.LAUNCH_OVER))

    def _role(self, connection: Connection) -> str:
        """What a tab of a room is for, by its address and the word that it shows."""
        request = connection.request
        if request is None:
            return FOLLOW
        asked = parse_qs(request.path.partition("?")[2])
        if OWN in asked:
            return OWN
        knows = self._presenter is not None and self._presenter.knows_token(request.headers, "")
        return "present" if knows and FOLLOW not in asked else FOLLOW

    def _work(self, client: viser.ClientHandle, screen: Screen, state: str = "", desk: VoteDesk | None = None,
              learner: Learner | None = None) -> Session:
        """Begin a session on a screen."""
        session = Session(self._lessons, screen, self._lesson, self._language, plant=self._plant, state=state or self._state,
                          insists=self._insists, sealed=self._sealed, mode=self._mode, talk=self._talk, course=self._course,
                          desk=desk, learner=learner, read_lessons=self._read_lessons if desk is None else None)
        screen.attach(session.post)
        viser_internals.tell_what_came_too_late(client)
        viser_internals.accept_values_only(client, lambda: session.post(Refuse(phrases.NONSENSE)))
        viser_internals.accept_small_files_only(client, MOST_BYTES, lambda: session.post(Refuse(phrases.TOO_LARGE)))
        viser_internals.hear_beats(client, lambda edit: session.post(RunOnTabThread(partial(screen.acknowledge, edit))),
                                   lambda edit: session.post(RunOnTabThread(partial(screen.expect, edit))))
        self._sessions[client.client_id], self._screens[client.client_id] = session, screen
        session.start(lambda: viser_internals.hang_up(self._server, client.client_id))
        return session

    async def _leave(self, client: viser.ClientHandle) -> None:
        self._screens.pop(client.client_id, None)
        session = self._sessions.pop(client.client_id, None)
        if self._room is not None:
            self._room.leave(client.client_id)
        self._places.leave(client.client_id)
        if session is not None:
            session.close()

    def prepare(self) -> None:
        """Load what the first scene needs, before anybody waits for it."""
        for module in NEEDED:
            with suppress(ImportError):  # then the first tab finds out
                import_module(module)
        Image.init()

    def wait(self, ended: Callable[[], bool], period: float = HEALTH_INTERVAL_S) -> None:
        """Serve until `ended` says so; every `period` seconds other processes learn how this one is.

        The heartbeat runs on the event loop: a process whose loop is blocked serves nobody and must not seem alive.
        """
        loop, due = self._server.get_event_loop(), 0.0
        while not ended():
            if time.monotonic() >= due:
                self._note()
                loop.call_soon_threadsafe(self._beat, time.monotonic())
                loop.call_soon_threadsafe(self._places.look)
                due = time.monotonic() + period
            time.sleep(min(END_POLL_S, period))

    def _beat(self, asked: float) -> None:
        """The loop lives; it has answered so long after it was asked."""
        self._lag = time.monotonic() - asked
        self._slot.beat()

    def stop(self) -> None:
        """Tell the tabs, close every session and the server; at most STOP_TIMEOUT_S seconds."""
        ending = threading.Thread(target=self._end, name="observer-lab end", daemon=True)
        ending.start()
        ending.join(STOP_TIMEOUT_S)

    def _end(self) -> None:
        if self._room is not None:
            self._room.close()
        for session in list(self._sessions.values()):
            session.close()
        for screen in list(self._screens.values()):
            screen.say(phrases.STOPPED, True)
        if self._screens:
            time.sleep(LAST_MESSAGE_S)
        self._server.stop()
