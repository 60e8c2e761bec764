"""Turn what the presenter's tab shows into shared pages, one of each kind, on a thread of its own."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from types import MappingProxyType

from ...classroom.kept_room import KeptPages
from ...session.state.token import write_token
from ...session.state.view import Picture
from ..viser_private.shared_page import SharedPage
from .audience_screen import AudienceScreen

MIN_BATCH_GAP_S = 0.06  # s between two pictures of a moving knob: what all followers get must be little
STAND_AFTER_S, MAX_STAND_GAP_S = 0.3, 2.0  # s of quiet after which the whole page is kept, and the most between two such
LOOK_S = 0.5  # s between two looks at which kinds of pages are wanted
WINDOWS = MappingProxyType({"wide": ((1366.0, 768.0), (929, 768)), "phone": ((390.0, 844.0), (390, 844))})  # px: window, canvas

log = logging.getLogger(__name__)


@dataclass
class KindOfPage:
    """One shared page: where it stands in its series, and whether its whole has been kept since it changed."""

    screen: AudienceScreen
    page: SharedPage
    batch: int = 0
    kept: int = -1
    built: bool = False
    changed: float = 0.0
    stood: float = 0.0


@dataclass
class Waiting:
    """The latest picture, pose and camera that the presenter's tab has shown since the last round."""

    picture: Picture | None = None
    rebuild: bool = False
    motion: Callable[[AudienceScreen], object] | None = None
    look: Callable[[AudienceScreen], object] | None = None


@dataclass
class Broadcast:
    """All shared pages of a room, made where its presenter is.

    `woken` is called when there is something to send, `lost` when a presenter of another worker leads.
    """

    store: KeptPages
    woken: Callable[[], object]
    keep_state: Callable[[str], object]
    lost: Callable[[], object]
    _kinds: dict[str, KindOfPage] = field(default_factory=dict)
    _series: int = -1
    _claims: bool = False  # whether a presenter has come here to lead
    _waiting: Waiting = field(default_factory=Waiting)
    _ready: threading.Condition = field(default_factory=threading.Condition)
    _picture: Picture | None = None
    _state: str = ""
    _closed: bool = False

    def start(self) -> None:
        """Begin the thread."""
        threading.Thread(target=self._run, name="observer-lab broadcast", daemon=True).start()

    def close(self) -> None:
        """End the thread."""
        with self._ready:
            self._closed = True
            self._ready.notify()

    def lead(self) -> None:
        """A presenter of this worker leads from now on."""
        with self._ready:
            self._claims = True

    # --- from the presenter's tab ----------------------------------------------------------------------------------
    def build(self, picture: Picture) -> None:
        """The page was laid out anew."""
        with self._ready:
            self._waiting.picture, self._waiting.rebuild, self._waiting.motion = picture, True, None
            self._ready.notify()

    def show(self, picture: Picture) -> None:
        """A picture was shown."""
        with self._ready:
            self._waiting.picture = picture
            self._ready.notify()

    def move(self, motion: Callable[[AudienceScreen], object]) -> None:
        """The run was posed, or goes on by itself."""
        with self._ready:
            self._waiting.motion = motion
            self._ready.notify()

    def look(self, look: Callable[[AudienceScreen], object]) -> None:
        """The presenter looks from elsewhere."""
        with self._ready:
            self._waiting.look = look
            self._ready.notify()

    def notice(self) -> None:
        """Somebody came who may need another kind of page."""
        with self._ready:
            self._ready.notify()

    # --- the thread ------------------------------------------------------------------------------------------------
    def _run(self) -> None:
        while not self._closed:
            with self._ready:
                if self._waiting == Waiting():
                    self._ready.wait(LOOK_S if self._all_kept() else STAND_AFTER_S)
                waiting, self._waiting = self._waiting, Waiting()
            try:
                self._round(waiting)
            except Exception:
                log.exception("the page of the room could not be brought up to date")
                for kind in self._kinds.values():  # half of a picture may stand there
                    kind.built = False
            if waiting.picture is not None and not waiting.picture.resting:
                time.sleep(MIN_BATCH_GAP_S)

    def _all_kept(self) -> bool:
        return all(kind.kept == kind.batch for kind in self._kinds.values())

    def _round(self, waiting: Waiting) -> None:
        self._picture = picture = waiting.picture or self._picture
        if picture is None:
            return
        if self._series != self.store.series:  # another worker leads, or none has yet
            if not self._claims:
                self._picture = None
                self.lost()
                return
            self._series, self._kinds = self.store.begin_series(), {}
        self._claims = False
        for name in self.store.wanted():
            kind = self._kinds.get(name) or self._open(name)
            fresh = not kind.built
            if waiting.rebuild or fresh:
                kind.screen.build(picture)
                kind.built = True
            if waiting.picture is not None or fresh:
                kind.screen.show(picture)
            for change in (waiting.look, waiting.motion):
                if change is not None:
                    change(kind.screen)
            kind.page.flush()
            self._stand(name, kind, fresh)
        if picture.resting and waiting.picture is not None:
            token = write_token(picture.lesson, picture.saved(picture.design, None))
            if token != self._state:
                self._state = token
                self.keep_state(token)

    def _open(self, name: str) -> KindOfPage:
        language, _, width = name.partition("-")
        window, canvas = WINDOWS[width]
        kind: KindOfPage

        def send(data: bytes) -> None:
            kind.batch, kind.changed = kind.batch + 1, time.monotonic()
            self.store.append(name, self._series, kind.batch, data)
            if kind.kept >= 0:  # until the whole page is kept nobody follows it
                self.woken()
        page = SharedPage(*canvas, send)
        self._kinds[name] = kind = KindOfPage(AudienceScreen(page, language, window), page)
        return kind

    def _stand(self, name: str, kind: KindOfPage, fresh: bool) -> None:
        now = time.monotonic()
        quiet = now - kind.changed >= STAND_AFTER_S or now - kind.stood >= MAX_STAND_GAP_S
        if fresh or (kind.kept != kind.batch and quiet):
            self.store.stand(name, self._series, kind.batch, kind.page.standing())
            kind.kept, kind.stood = kind.batch, now
            self.woken()
