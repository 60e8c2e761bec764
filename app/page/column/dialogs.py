"""Keep the dialogs of a page, of which one is open at a time."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import viser

from ...course.course_map import Progress
from ...session.commands.commands import Edit
from ...session.state.view import Picture
from .course_page import CourseDialog
from .dialog import Dialog
from .download_dialog import DownloadDialog
from .glossary_dialog import GlossaryDialog
from .key_list import HelpDialog


class Dialogs:
    """List of keys, glossary, page of lessons, downloads; the command that opens one also closes it."""

    def __init__(self, client: viser.ClientHandle, picture: Picture, post: Callable[[Edit], int], home: str) -> None:
        self._help, self._terms = HelpDialog(client, post), GlossaryDialog(client, post)
        self._course, self._take = CourseDialog(client, post), DownloadDialog(client, picture, post, home)

    def help(self, picture: Picture) -> None:
        """The list of keys."""
        self._close_others(self._help)
        self._help.toggle(picture.state.language)

    def glossary(self, picture: Picture) -> None:
        """The page of all terms."""
        self._close_others(self._terms)
        self._terms.toggle(picture)

    def course(self, picture: Picture, progress: Mapping[str, Progress]) -> None:
        """The page of all lessons."""
        self._close_others(self._course)
        self._course.toggle(picture, progress)

    def take(self, picture: Picture, token: str) -> None:
        """What can be taken away of a state."""
        self._close_others(self._take)
        self._take.toggle(token, picture)

    def _close_others(self, dialog: Dialog) -> None:
        for other in (self._help, self._terms, self._course, self._take):
            if other is not dialog:
                other.close()
