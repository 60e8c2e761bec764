"""Show the page of all terms, each with its explanation and its formula."""

from __future__ import annotations

import html

from ...session.state.view import Picture
from ..words import phrases
from ..words.prose import mathml
from .dialog import Dialog


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
