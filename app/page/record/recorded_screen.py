"""Show pictures on a page that nobody looks at, and read what stands there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, cast

import viser

from ...session.handlers.playback import FRAME_S, PLAYBACK_SPEEDS
from ...session.state.view import Picture
from ..charts.style_sheet import clock
from ..replay.transport import CLOCK_PLACEHOLDERS
from ..screen.screen import Screen
from ..viser_private.page_tape import PageTape, Place
from ..viser_private.stage_frames import Frame
from ..words import phrases

WINDOWS = MappingProxyType({"wide": ((1366.0, 768.0), (929, 768)), "phone": ((390.0, 844.0), (390, 844))})  # px: window, canvas
MAX_FRAMES = 450  # poses of a run that are kept


@dataclass(frozen=True)
class Look:
    """In which language, theme and width a page is shown."""

    language: str
    dark: bool = False
    width: str = "wide"

    @property
    def name(self) -> str:
        """Its name in the names of files."""
        return f"{self.language}-{'dark' if self.dark else 'light'}-{self.width}"


@dataclass(frozen=True)
class RecordedRun:
    """Where everything stands at each of these times (s); `end` and `rate` as in a picture."""

    times: tuple[float, ...]
    frames: tuple[Frame, ...]
    end: float
    rate: float


class RecordedScreen(Screen):
    """The page's own screen over a tape, with pictures in the look that it was made for."""

    def __init__(self, look: Look) -> None:
        window, canvas = WINDOWS[look.width]
        self._tape = PageTape(*canvas)
        super().__init__(cast(viser.ClientHandle, self._tape))
        self.look, self._window = look, window

    @property
    def values(self) -> Mapping[Place, Any]:
        """All that stands on the page."""
        return self._tape.values

    def build(self, picture: Picture) -> None:
        """Lay everything out anew."""
        seen = self._seen(picture)
        super().build(seen)
        self._client.gui.add_html(f'<p class="ol-note ol-published">{phrases.PUBLISHED(self.look.language)}</p>', order=1e6)

    def show(self, picture: Picture) -> None:
        """Show what changed since the last picture."""
        super().show(self._seen(picture))

    def play(self, t: float, end: float, rate: float, every: float) -> float:
        """The run is recorded, not played."""
        return every

    def recorded_run(self) -> RecordedRun | None:
        """The run of the picture that stands, None where nothing moves in time."""
        picture = self._picture
        if picture is None or picture.horizon <= 0:
            return None
        every = max(FRAME_S * picture.rate / picture.state.speed, picture.end / MAX_FRAMES)
        count = max(1, round(picture.end / every))
        times = tuple(picture.end * k / count for k in range(count + 1))
        return RecordedRun(times, tuple(self._stage.frame_at(self._stage.place_at(t)) for t in times), picture.end, picture.rate)

    def told_of_run(self) -> dict[str, object]:
        """What a page must know to write the clock of that run, for each speed."""
        picture, transport = self._picture, self._transport
        assert picture is not None and transport is not None
        rate = picture.rate / picture.state.speed
        words = [clock(0.0, picture.horizon, rate * speed, "", *CLOCK_PLACEHOLDERS) for speed in PLAYBACK_SPEEDS]
        return self._tape.plain({**transport.told, "words": words})

    def _seen(self, picture: Picture) -> Picture:
        state = replace(picture.state, language=self.look.language, dark=self.look.dark, window=self._window)
        return replace(picture, state=state)
