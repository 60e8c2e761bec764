"""Define the widget that shows a lesson in a notebook."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal

from observer_lab.lessons import all_lessons

from ..session.state.saved_state import SavedState
from ..session.state.token import write_token
from ..text.languages import languages

try:
    import anywidget
    import traitlets
except ImportError as problem:
    raise ImportError('The notebook widget needs the package anywidget; run pip install "observer-lab[notebook]".') from problem

View = Literal["guide", "lab", "stage"]
VIEWS: tuple[View, ...] = ("guide", "lab", "stage")
WIDTH = re.compile(r"\d{1,4}(?:px|%|em|rem|vw)")
MIN_HEIGHT, MAX_HEIGHT = 200, 4000  # px


class Lab(anywidget.AnyWidget):
    """A lesson in a frame of a notebook.

    `view` is "guide" (scene by scene), "lab" (all at once) or "stage" (the picture alone). The server runs in the kernel, on a free port of
    this machine, and ends with it. `address` uses another lab instead, which `serve --embed-in` must let stand in this notebook.

    What the notebook stores holds no access token: the page asks for the address each time it is shown.
    """

    _esm = Path(__file__).with_name("lab.js")
    title = traitlets.Unicode().tag(sync=True)
    width = traitlets.Unicode("100%").tag(sync=True)
    height = traitlets.Int(640).tag(sync=True)

    def __init__(self, lesson: str, view: View = "guide", *, language: str = "en", width: str = "100%", height: int = 640,
                 address: str | None = None) -> None:
        """Raises ValueError at an unknown lesson, view or language, and at a size that is none."""
        lessons = all_lessons()
        if lesson not in lessons:
            raise ValueError(f"There is no lesson {str(lesson)[:40]}; there are {', '.join(lessons)}.")
        if view not in VIEWS:
            raise ValueError(f"There is no view {str(view)[:40]}; use {', '.join(VIEWS)}.")
        if language not in languages():
            raise ValueError(f"There is no language {str(language)[:40]}; use {', '.join(languages())}.")
        if WIDTH.fullmatch(width) is None:
            raise ValueError(f"{width[:40]!r} is not a width; give one as 100% or 800px.")
        if not MIN_HEIGHT <= height <= MAX_HEIGHT:
            raise ValueError(f"The height must be {MIN_HEIGHT} to {MAX_HEIGHT} pixels; it is {height}.")
        if address is not None and re.fullmatch(r"https?://[^\s#]{1,300}", address) is None:
            raise ValueError(f"{address[:60]!r} is not an address; give one as https://lab.example.org/.")
        super().__init__(title=lessons[lesson].words[language].title, width=width, height=height)
        self._view, self._address = view, address
        saved = SavedState(lessons[lesson].start(), language, mode="guide" if view == "guide" else "lab")
        self._token = write_token(lessons[lesson], saved)
        self.on_msg(self._answer)

    def address_for(self, origin: str) -> str:
        """The address of the lesson for the notebooks of an origin, such as http://localhost:8888. Raises ValueError, OSError."""
        from .lab_server import server_for

        page = self._address or server_for(origin).address
        asked = [] if self._view != "stage" else ["view=stage"]
        return f"{'&'.join([page, *asked]) if '?' in page else '?'.join([page, *asked])}#{self._token}"

    def _answer(self, _: object, content: Any, __: object) -> None:
        """Tell the page of a notebook, which names its origin, where the lesson is, or in one sentence why not."""
        origin = content.get("origin") if isinstance(content, dict) else None
        try:
            self.send({"address": self.address_for(str(origin))})
        except (ValueError, OSError) as problem:
            self.send({"problem": f"The lesson cannot be shown: {problem}"})
