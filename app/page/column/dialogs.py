"""Keep the dialogs of a page, one open at a time; show the page of terms and the list of keys."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping

import viser

from ...course.course_map import Progress
from ...session.commands.commands import Edit
from ...session.commands.shortcuts import SHORTCUTS
from ...session.state.view import Picture
from ..web.html_page import APP_NAME, version
from ..words import phrases
from ..words.prose import mathml
from .course_page import CourseDialog
from .dialog import Dialog
from .download_dialog import DownloadDialog


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


class GlossaryDialog(Dialog):
    """A dialog that opens and closes."""

    def toggle(self, picture: Picture) -> None:
        """Open it in the language of the page, or close it."""
        lang = picture.state.language
        glossary = picture.lesson.words[lang].glossary
        if self.close() or glossary is None:
            return
        terms = "".join(f"<dt>{html.escape(entry.term)}</dt><dd>{html.escape(entry.text)}<div>{mathml(entry.formula, True)}</div></dd>"
                        for entry in sorted(glossary.entries, key=lambda entry: entry.term.lower()))
        with self.open(phrases.GLOSSARY(lang)):
            self._client.gui.add_html(f'<dl class="ol-terms">{terms}</dl>')
            self.closed_by(self._client.gui.add_button(phrases.CLOSE(lang), color="gray"))
        self._client.flush()


class HelpDialog(Dialog):
    """A dialog that opens and closes."""

    def toggle(self, language: str) -> None:
        """Open it in a language, or close it."""
        if self.close():
            return
        gui = self._client.gui
        rows = "".join(f"<tr><td><kbd>{html.escape(c.key)}</kbd></td><td>{html.escape(c.label(language))}</td></tr>"
                       for c in SHORTCUTS)
        with self.open(phrases.KEYS_TITLE(language)):
            gui.add_html(f'<table class="ol-table ol-keys">{rows}</table><p class="ol-note">{APP_NAME} {version()}</p>')
            self.closed_by(gui.add_button(phrases.CLOSE(language)))
        self._client.flush()
