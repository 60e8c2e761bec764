"""Mark on the page how far its edits have been answered, for scripts and tests that wait."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ...session.commands.commands import Answer, Edit
from ...session.state.view import Picture
from ..viser_private import viser_internals


class AnsweredMark:
    """A number that is put into the widget named by `data-ask` stands in `data-answer` once all before it is answered.

    It is posted behind everything that the browser has sent, so its answer is shown after theirs. `data-rests` is 1 while
    the final picture stands and no long job works, `data-stands` from the first picture on, when the page is all there.
    """

    def __init__(self, gui: viser.GuiApi, post: Callable[[Edit], int]) -> None:
        self._answer, self._stands, self._rests, self._works = 0.0, False, False, False
        ask = gui.add_number("", 0.0, visible=False)
        self._ask = viser_internals.node_id(ask)
        self._html = gui.add_html(self._words())

        @ask.on_update
        async def _(event: viser.GuiEvent) -> None:
            post(Answer(event.target.value))

    @property
    def rests(self) -> bool:
        """Whether the final picture stands and no long job works."""
        return self._stands and self._rests and not self._works

    def answer(self, question: float) -> None:
        """Say that all that came before this question has been shown."""
        self._answer = question
        self._write()

    def show(self, picture: Picture) -> None:
        """Whether this is the final picture of its design; all else of it has been sent before."""
        self._stands, self._rests = True, picture.resting
        self._write()

    def works(self, working: bool) -> None:
        """Whether a long job goes on."""
        if working != self._works:
            self._works = working
            self._write()

    def _write(self) -> None:
        words = self._words()
        if self._html.content != words:
            self._html.content = words

    def _words(self) -> str:
        rests = int(self._rests and not self._works)
        return (f'<i class="ol-mark" hidden data-ask="{self._ask}" data-answer="{self._answer:g}" data-rests="{rests}" '
                f'data-stands="{int(self._stands)}"></i>')
