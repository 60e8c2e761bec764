"""Talk to one browser: storage, address bar, downloads and camera."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import viser

from ...session.state.tab_memory import MAX_MEMORY_BYTES
from ...session.state.token import LONGEST_LINK
from ...session.state.view import Picture
from ..column.answer_mark import AnsweredMark
from ..stage.viewpoint import Viewpoint
from ..viser_private import page_scripts, viser_internals

ADDRESS_PATTERN = re.compile(r"https?://[\w.:\[\]-]{1,200}(?:/[\w.~/%-]{0,200})?", re.ASCII)
STORAGE, DESIGNS = "observer-lab", "observer-lab-designs"  # the keys of what tabs keep, and of the designs under names
LESSONS = "observer-lab-lessons"  # the key of a tab's own .zip of lessons


class Browser:
    """The part of a screen that outlives it. All methods are called by the session's worker."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._viewpoint = Viewpoint(client)
        self._mark: AnsweredMark | None = None
        self._pressed = 0  # the number of the press that was done last
        self._home = ""  # where the browser found the page, as its address bar says

    def camera(self, preset: str) -> None:
        """Look from a named place."""
        self._viewpoint.camera(preset)
        self._looks_from_elsewhere()
        self._client.flush()

    def look(self, camera: tuple[float, ...] | None) -> None:
        """Look from a position at a target, from where everything is seen for None."""
        self._viewpoint.look(camera)
        self._looks_from_elsewhere()
        self._client.flush()

    def _looks_from_elsewhere(self) -> None:
        """The camera has been put elsewhere: a screen with a stage writes in another size."""

    def eye(self) -> tuple[float, ...] | None:
        """Position and target of the camera, None where it stands as it was put."""
        return self._viewpoint.eye()

    def address(self, token: str, lesson: str, asked: int) -> None:
        """Put a state into the address bar, if it fits there."""
        page_scripts.show_address(self._client, token if len(token) <= LONGEST_LINK else "", lesson, asked, self._pressed)

    def download(self, name: str, content: bytes) -> None:
        """Give the person a file."""
        self._client.send_file_download(name, content, save_immediately=True)

    def replay(self, picture: Picture, token: str, camera: tuple[float, ...] | None) -> bytes:
        """The run of a picture as a page that plays by itself."""
        from ..replay.replay import replay  # matplotlib is loaded only when a file is wanted

        return replay(picture, token, camera).encode()

    def recall(self, answer: Callable[..., object]) -> None:
        """Ask for what this tab kept through a reload, for what stands in the address bar, and for what the browser keeps."""
        def heard(kept: str | None, token: str, known: bool, home: str, *others: Any) -> None:
            self._home = home if ADDRESS_PATTERN.fullmatch(home) else ""
            answer(kept, token, known, *others)
        viser_internals.ask_storage(self._client, STORAGE, DESIGNS, LESSONS, heard)

    def remember(self, text: str) -> None:
        """Keep a text in this tab's own storage, which survives a reload, and beside that of other tabs for those to come."""
        viser_internals.run_script(self._client, "remember", key=STORAGE, text=text, most=MAX_MEMORY_BYTES, answered=self._pressed)

    def save_design(self, name: str, words: str) -> None:
        """Keep words in the browser under a name, or nothing any more for ""."""
        viser_internals.run_script(self._client, "shelve", key=DESIGNS, under=name, words=words)

    def keep_lessons(self, words: str) -> None:
        """Keep a .zip of lessons in this tab's own storage, or none any more for ""."""
        viser_internals.run_script(self._client, "lessons", key=LESSONS, words=words)

    def clear_storage(self) -> None:
        """Let the browser forget all that it keeps."""
        viser_internals.run_script(self._client, "wipe", keys=[STORAGE, DESIGNS, LESSONS])

    def answer(self, question: float) -> None:
        """Say on the page's mark that all that was done before a question is shown."""
        if self._mark is not None:
            self._mark.answer(question)
            self._client.flush()

    def expect(self, edit: int) -> None:
        """The press of this number comes next: what the page keeps from then on holds what it did, and the page does it no more."""
        self._pressed = edit

    def acknowledge(self, edit: int) -> None:
        """Tell the page that its edits up to this one are shown and kept, once they are."""
        if self._mark is not None and self._mark.rests:
            page_scripts.acknowledge(self._client, edit)
            self._client.flush()
