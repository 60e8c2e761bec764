"""Show each picture on several recorded screens: one for each language, theme and width."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..course.course_map import Progress
from ..course.lesson import Stage
from ..page.record.recorded_screen import Look, RecordedScreen
from ..session.state.view import Picture
from ..text import Text

Values = Mapping[tuple[str, str], Any]


class RecordedScreens:
    """A `View` for a presenter: what it shows stands on all screens; what only a browser can do is passed over."""

    def __init__(self, looks: Sequence[Look]) -> None:
        self.screens = tuple(RecordedScreen(look) for look in looks)

    def standing(self) -> tuple[Values, ...]:
        """All that stands on each screen now."""
        return tuple(dict(screen.values) for screen in self.screens)

    def build(self, picture: Picture) -> None:
        """Lay each screen out."""
        for screen in self.screens:
            screen.build(picture)

    def show(self, picture: Picture) -> None:
        """Show a picture on each screen."""
        for screen in self.screens:
            screen.show(picture)

    def pose(self, t: float) -> None:
        """Move each stage to time t."""
        for screen in self.screens:
            screen.pose(t)

    def follow(self, stage: Stage) -> None:
        """No running plant is recorded."""

    def play(self, t: float, end: float, rate: float, every: float) -> float:
        """The run is recorded, not played."""
        return every

    def camera(self, preset: str) -> None:
        """Look from a named place."""
        for screen in self.screens:
            screen.camera(preset)

    def look(self, camera: tuple[float, ...] | None) -> None:
        """Look from a position at a target."""
        for screen in self.screens:
            screen.look(camera)

    def open_course(self, progress: Mapping[str, Progress]) -> None:
        """Open the page of all lessons on each screen, or close it."""
        for screen in self.screens:
            screen.open_course(progress)

    def open_glossary(self) -> None:
        """Open the page of all terms on each screen, or close it."""
        for screen in self.screens:
            screen.open_glossary()

    def open_help(self) -> None:
        """Open the list of keys on each screen, or close it."""
        for screen in self.screens:
            screen.open_help()

    def eye(self) -> tuple[float, ...] | None:
        """Nobody has moved the camera."""
        return None

    def progress(self, fraction: float | None, label: Text | None) -> None:
        """The guide starts no long computation."""

    def say(self, words: Text, bad: bool) -> None:
        """No notification is recorded."""

    def open_figure(self, figure: str) -> None:
        """The guide has no tabs of figures."""

    def answer(self, question: float) -> None:
        """Nobody asks."""

    def address(self, token: str, lesson: str, asked: int) -> None:
        """There is no address bar."""

    def offer(self, token: str) -> None:
        """Nothing can be taken away from a folder."""

    def download(self, name: str, content: bytes) -> None:
        """Nobody takes a file."""

    def replay(self, picture: Picture, token: str, camera: tuple[float, ...] | None) -> bytes:
        """Nobody takes a replay."""
        return b""

    def recall(self, answer: Callable[..., object]) -> None:
        """There is no browser that keeps anything."""

    def remember(self, text: str) -> None:
        """There is no browser that keeps anything."""

    def save_design(self, name: str, words: str) -> None:
        """There is no browser that keeps anything."""

    def keep_lessons(self, words: str) -> None:
        """There is no browser that keeps anything."""

    def clear_storage(self) -> None:
        """There is no browser that keeps anything."""
