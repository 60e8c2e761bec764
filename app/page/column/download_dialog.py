"""Show the dialog for downloads: link with QR code, state, figures, scripts, replay, sheet."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping

import viser

from ...course.figures.records import tab_names
from ...session.commands.commands import Edit, OpenState, PlaceOpened, SaveState
from ...session.commands.files import DownloadFile
from ...session.state.saved_state import MAX_STATE_CHARACTERS
from ...session.state.token import LONGEST_LINK, LONGEST_TOKEN
from ...session.state.view import Picture
from ...text import Text, read_outside_json
from ..access.addresses import is_reachable
from ..viser_private import page_scripts
from ..words import phrases
from ..words.link_code import qr_code
from .dialog import Dialog

LONGEST_CODE = 700  # characters of a link whose code a telephone reads from the back of a hall
FIGURE_KINDS = ("PNG", "SVG", "PDF", "CSV", "JSON")  # of a figure


class DownloadDialog(Dialog):
    """The dialog, and the hidden widget by which the page says what was opened in it."""

    def __init__(self, client: viser.ClientHandle, picture: Picture, post: Callable[[Edit], int], home: str) -> None:
        super().__init__(client, post)
        self._home, self._lang, self._picture = home, picture.state.language, picture
        gui, state = client.gui, picture.state
        said = gui.add_text("", "", visible=False)
        names = tab_names(picture.seen)
        page_scripts.tell_places(client, said, [name(self._lang) for name in names],
                           [heading for heading, _ in picture.lesson.words[self._lang].steps],
                           next((name(self._lang) for name in names if name("en") == state.tab), None))

        @said.on_update
        async def _(event: viser.GuiEvent) -> None:
            edit = _said(event.target.value)
            if edit is not None:
                post(edit)

    def toggle(self, token: str, picture: Picture) -> None:
        """Open the dialog on a state and what is shown of it, or close it."""
        self._picture = picture
        if self.close():
            return
        gui, lang = self._client.gui, self._lang
        with self.open(phrases.TAKE(lang)):
            parts = gui.add_tab_group()
            with parts.add_tab(phrases.LINK(lang)):
                self._offer_state(token)
                if picture.state.predicted is None:
                    self._note(phrases.AFTER_CHOICE)
            if picture.state.predicted is not None:
                self._offer_files(parts)
            self.closed_by(gui.add_button(phrases.CLOSE(lang), color="gray"))

    def _offer_state(self, token: str) -> None:
        """The link with its code, and the state as a file."""
        gui, lang = self._client.gui, self._lang
        gui.add_html(self._link(token))
        self._button_each({phrases.SAVE: SaveState()})
        upload = gui.add_upload_button(phrases.OPEN(lang), color="gray", mime_type=".json,.txt", hint=phrases.OPEN_HINT(lang))

        @upload.on_upload
        async def _(event: viser.GuiEvent) -> None:
            self.close_later()
            self._post(OpenState(event.target.value.content[:MAX_STATE_CHARACTERS + 1]))

    def _offer_files(self, parts: viser.GuiTabGroupHandle) -> None:
        """Figures, scripts, the replay and the sheet, all of which hold the answer to the question."""
        lang = self._lang
        if self._picture.seen:
            with parts.add_tab(phrases.FIGURES(lang)):
                self._offer_figures()
        with parts.add_tab(phrases.SCRIPTS(lang)):
            self._note(phrases.PROVES)
            self._button_each({phrases.PYTHON: DownloadFile("python"), phrases.NOTEBOOK: DownloadFile("notebook"),
                               phrases.MATLAB: DownloadFile("matlab"), phrases.ENGINE_NOTEBOOK: DownloadFile("engine-notebook")})
        if self._picture.horizon > 0:
            with parts.add_tab(phrases.REPLAY(lang)):
                self._note(phrases.REPLAY_HAS)
                self._button_each({phrases.REPLAY_PAGE: DownloadFile("replay")})
        with parts.add_tab(phrases.PRINT_THEME(lang)):
            self._note(phrases.SHEET_HAS)
            self._button_each({phrases.LESSON_SHEET: DownloadFile("sheet")})
        with parts.add_tab(phrases.DEVICE(lang)):
            self._note(phrases.DEVICE_HAS)
            self._button_each({phrases.DEVICE_C: DownloadFile("c"), phrases.DEVICE_ARDUINO: DownloadFile("arduino"),
                               phrases.DEVICE_PYTHON: DownloadFile("micropython"), phrases.DEVICE_ST: DownloadFile("st"),
                               phrases.DEVICE_SIMULINK: DownloadFile("simulink")})

    def _offer_figures(self) -> None:
        """A figure to choose, the one that is on top first, with its kinds of file; all of them; the stage."""
        gui, lang, figures, name = self._client.gui, self._lang, self._picture.seen, self._picture.state.tab
        titles = {f"{k}. {figure.title(lang)}": figure.id for k, figure in enumerate(figures, 1)}
        shown = next((k for k, figure in enumerate(figures) if figure.tab("en") == name), 0)
        every = phrases.ALL_FIGURES(lang)
        choice = gui.add_dropdown(phrases.FIGURE(lang), (*titles, every), initial_value=list(titles)[shown])
        row = gui.add_button_group("", FIGURE_KINDS)
        self._button_each({phrases.ZIP: DownloadFile("zip")})
        if self._picture.outcome.stage is not None:
            gui.add_html(f'<button type="button" class="ol-wide ol-snapshot" data-name="{self._picture.lesson.id}-stage.png">'
                         f"{phrases.STAGE_PICTURE(lang)}</button>")

        @row.on_click
        async def _(event: viser.GuiEvent) -> None:
            if event.target.value in FIGURE_KINDS:
                self._post(DownloadFile(event.target.value.lower(), titles.get(choice.value, "")))

    def _note(self, words: Text) -> None:
        self._client.gui.add_html(f'<p class="ol-note">{html.escape(words(self._lang))}</p>')

    def _button_each(self, edits: Mapping[Text, Edit]) -> None:
        """A button for each of these, under its words."""
        for words, edit in edits.items():
            self._bind(self._client.gui.add_button(words(self._lang)), edit)

    def _bind(self, button: viser.GuiButtonHandle, edit: Edit) -> None:
        @button.on_click
        async def _(_: viser.GuiEvent) -> None:
            self._post(edit)

    def _link(self, token: str) -> str:
        """The link in a field, a button that copies it, and its code; a sentence where it is too long."""
        if len(token) > LONGEST_LINK:
            return f'<p class="ol-note">{phrases.TOO_LONG(self._lang)}</p>'
        link = html.escape(f"{self._home}#{token}", quote=True)
        copy, done = (html.escape(words(self._lang), quote=True) for words in (phrases.COPY, phrases.COPIED))
        field = (f'<div class="ol-take"><input class="ol-link" readonly aria-label="{copy}" value="{link}">'
                 f'<button type="button" class="ol-copy" data-token="{token}" data-done="{done}">{copy}</button></div>')
        shown = self._home and len(self._home) + 1 + len(token) <= LONGEST_CODE
        alone = "" if not self._home or is_reachable(self._home) else phrases.ONLY_THIS_MACHINE(self._lang)
        field += f'<p class="ol-note">{html.escape(alone)}</p>' if alone else ""
        return field + (qr_code(f"{self._home}#{token}") if shown else "")


def _said(words: object) -> Edit | None:
    """What the page said: a token from its address bar, or what is open on it; None where it makes no sense."""
    if not isinstance(words, str) or len(words) > LONGEST_TOKEN + 100:
        return None
    try:
        data = read_outside_json(words)
    except ValueError:
        return None
    match data:
        case {"open": token, "asked": asked}:
            return OpenState(token, asked)
        case {"tab": tab, "step": step}:
            return PlaceOpened(tab, step)
    return None
