"""Run the room of one worker: presenter, followers, copies of their own, votes and counts."""

from __future__ import annotations

import asyncio
import logging
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace

import viser

from ...classroom.kept_room import Place, VoteWriter, open_pages, open_room
from ...classroom.room import LECTURE, UNSOLVED, ClassRuns, RoomView, overview, seeds_of
from ...classroom.votes import Asked, Vote
from ...session.commands.room import Freeze, RoomChanged
from ...session.session import Session
from ..access.connection import Connection, ConnectionClosed
from ..charts.print_sizes import SHEET_MAX_WIDTH_PX
from .class_seats import ClassSeats
from .follower import Ballot, Follower, preferred_language
from .presenter_pages import PresenterPages
from .presenter_view import OwnScreen, PresenterScreen
from .relay import Relay

COUNT_S = 0.25  # s between two counts of the room
REPORT_S = 20.0  # s after which a worker reports its counts again where nothing has changed
log = logging.getLogger(__name__)


class LectureRoom:
    """A room in a folder or a Redis server, as one worker has it. The loop calls what begins and ends tabs; a thread counts."""

    def __init__(self, place: Place, worker: int, language: str, audience: str = "") -> None:
        """`audience` is the address of those who follow. Raises what `open_room` raises."""
        self._audience = audience
        self._store, self._pages, self._worker, self._language = open_room(place), open_pages(place), worker, language
        self._writer = VoteWriter(self._store)
        self._relay: Relay | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._presenters = PresenterPages(self._store, self._pages, self._wake)
        self._seats = ClassSeats(self._store, worker)
        self._followers: dict[int, Follower] = {}
        self._tasks: dict[int, asyncio.Task[None]] = {}
        self._alone: dict[int, Session] = {}
        self._ended = threading.Event()
        self._told: RoomView | None = None
        self._shows_runs = True  # whether the pages may show runs of which the presenter's page knows
        self._reported: tuple[Mapping[str, int], int] | None = None
        self._report_due = 0.0
        self._hands, self._paused, self._failing = self._store.hands, self._store.paused, False

    def start(self, loop: asyncio.AbstractEventLoop) -> None:
        """Begin; followers come on this event loop."""
        self._loop, self._relay = loop, Relay(self._pages, loop)
        for part in (self._relay, self._presenters, self._writer):
            part.start()
        threading.Thread(target=self._count, name="observer-lab room", daemon=True).start()

    def close(self) -> None:
        """End all threads; what was voted is on the disk."""
        self._ended.set()
        self._presenters.close()
        self._writer.close()
        if self._relay is not None:
            self._relay.close()

    def _wake(self) -> None:
        if self._relay is not None:
            self._relay.wake()

    @property
    def audience(self) -> str:
        """The address of those who follow."""
        return self._audience

    @property
    def failing(self) -> bool:
        """Whether the room's store cannot be read or written."""
        return self._failing or self._writer.failing

    # --- tabs ------------------------------------------------------------------------------------------------------
    @property
    def state(self) -> str:
        """The token of what the lecture showed last; "" before its beginning."""
        return self._store.state

    def presenter_screen(self, client: viser.ClientHandle) -> PresenterScreen:
        """The screen of a tab that presents; it leads."""
        return self._presenters.screen(client)

    def own_screen(self, client: viser.ClientHandle) -> OwnScreen:
        """The screen of a tab that works on its own."""
        return OwnScreen(client)

    def present(self, client_id: int, session: Session, screen: PresenterScreen) -> None:
        """A tab presents."""
        self._told, self._shows_runs = None, False
        self._presenters.enter(client_id, session, screen)

    def work_alone(self, client_id: int, session: Session) -> None:
        """A tab works on its own."""
        self._alone[client_id] = session
        session.post(Freeze(self._paused))

    def follow(self, client: viser.ClientHandle, connection: Connection) -> None:
        """A tab follows the lecture; called on the event loop."""
        assert self._relay is not None
        asked = next(iter(connection.request.headers.get_all("Accept-Language")), "") if connection.request else ""
        language = preferred_language(asked, self._language)
        kind = f"{language}-{'phone' if 0 < client.camera.image_width <= SHEET_MAX_WIDTH_PX else 'wide'}"
        follower = Follower(client, language, self)
        self._followers[client.client_id] = follower
        follower.freeze(self._paused)
        self._tasks[client.client_id] = asyncio.get_running_loop().create_task(self._send(kind, connection, follower))

    async def _send(self, kind: str, connection: Connection, follower: Follower) -> None:
        assert self._relay is not None
        await asyncio.to_thread(self._pages.want, kind)
        self._presenters.broadcast.notice()
        try:
            await self._relay.follow(kind, connection, follower.begin)
        except (ConnectionError, TimeoutError):
            await connection.close()
        except asyncio.CancelledError:
            raise
        except ConnectionClosed:  # it has left while it was sent something
            pass
        except Exception as problem:
            log.warning("a follower was left: %s", type(problem).__name__)

    def leave(self, client_id: int) -> bool:
        """A tab has left; whether it followed."""
        self._presenters.leave(client_id)
        self._alone.pop(client_id, None)
        task = self._tasks.pop(client_id, None)
        if task is not None:
            task.cancel()
        return self._followers.pop(client_id, None) is not None

    # --- votes -----------------------------------------------------------------------------------------------------
    def cast(self, ballot: Ballot, told: Callable[[bool], object]) -> None:
        """Take a vote; `told` is called on the event loop once it is written down."""
        assert self._loop is not None
        loop = self._loop
        self._writer.cast(ballot.vote, ballot.ballot, ballot.answer, lambda counted: loop.call_soon_threadsafe(told, counted))

    def open_vote(self, lesson: str, scene: str, options: int, asked: Asked | None = None) -> RoomView:
        """Ask the class the question of a scene, or what was typed there."""
        self._store.open_vote(lesson, scene, options, asked)
        return self._view()

    def close_vote(self) -> RoomView:
        """Take no more votes."""
        self._store.close_vote()
        return self._view()

    def show_counts(self, vote: Vote, shown: bool) -> RoomView:
        """Show the counts of a closed vote to everybody, or hide them."""
        return self._mark(replace(vote, counts_out=shown))

    def discuss(self, vote: Vote) -> RoomView:
        """Let the class discuss a closed vote for a while."""
        return self._mark(replace(vote, talks=vote.talks + 1))

    def reveal(self, vote: Vote) -> RoomView:
        """Tell the answer to a closed vote, with its counts and those of the votes before on the same question."""
        for before in self._store.votes():
            if (before.lesson, before.scene, before.asked) == (vote.lesson, vote.scene, vote.asked) and before.number < vote.number:
                self._store.mark_vote(replace(before, counts_out=True))
        return self._mark(replace(vote, counts_out=True, revealed=True, talks=0))

    def _mark(self, vote: Vote) -> RoomView:
        self._store.mark_vote(vote)
        return self._view()

    def lower_hands(self) -> RoomView:
        """Every raised hand is lowered."""
        self._store.lower_hands()
        return self._view()

    def pause(self, on: bool) -> RoomView:
        """Pause the pages of the class, or let them go on."""
        self._store.pause(on)
        return self._view()

    def _pause_here(self, on: bool) -> None:
        self._paused = on
        for session in list(self._alone.values()):
            session.post(Freeze(on))
        for follower in list(self._followers.values()):
            if self._loop is not None and not self._loop.is_closed():
                self._loop.call_soon_threadsafe(follower.freeze, on)

    # --- a run for each follower ---------------------------------------------------------------------------------------
    def draw_seeds(self) -> Mapping[int, int]:
        """The seed of each follower by the follower's number."""
        seats = self._store.seats()
        return dict(zip(seats, seeds_of(self._store.seed, seats), strict=True))

    def show_runs(self, runs: ClassRuns | None) -> None:
        """Show each follower their own run, or take it away from all."""
        self._shows_runs = True
        self._store.keep_runs("" if runs is None else runs.write())

    # --- counts ----------------------------------------------------------------------------------------------------
    def _view(self) -> RoomView:
        people, slower = self._store.presence()
        return replace(overview(people, slower, self._store.votes()), audience=self._audience, paused=self._store.paused)

    def _count(self) -> None:
        while not self._ended.wait(COUNT_S):
            try:
                self._report()
                self._tell(replace(self._view(), failing=self._writer.failing) if self._presenters.sessions else None)
                self._failing = False
            except Exception:
                if not self._failing:
                    log.exception("the room's store cannot be used")
                self._failing = True
                self._tell(replace(self._told or RoomView(), failing=True))

    def _report(self) -> None:
        if (hands := self._store.hands) != self._hands:
            self._hands = hands
            for follower in list(self._followers.values()):
                follower.raised = False
        if (paused := self._store.paused) is not self._paused:
            self._pause_here(paused)
        if not self._shows_runs:  # a page that presents has begun anew and shows no cloud
            self.show_runs(None)
        if self._loop is not None:
            self._seats.update(self._followers, self._loop)
        people = Counter({LECTURE: len(self._followers)})
        for session in list(self._alone.values()):
            picture = session.picture
            if picture is not None:
                people[picture.lesson.id + (f"/{picture.scene.id}" if picture.scene else "")] += 1
                people.update(f"{UNSOLVED}{picture.lesson.id}/{name}" for name, task in picture.state.tasks.items()
                              if task.verdict is not None and not task.verdict.solved)
        now = dict(people), sum(follower.raised for follower in list(self._followers.values()))
        if now != self._reported or time.monotonic() >= self._report_due:
            self._reported, self._report_due = now, time.monotonic() + REPORT_S
            self._store.report(self._worker, *now)

    def _tell(self, view: RoomView | None) -> None:
        if view is not None and view != self._told:
            self._told = view
            for session in self._presenters.sessions:
                session.post(RoomChanged(view))
