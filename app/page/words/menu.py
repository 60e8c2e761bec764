"""Write the menu and the switch of views as HTML: language, theme, print, search; guide, lab, present."""

from __future__ import annotations

import html
from collections.abc import Iterable

from ...course.scenes import Mode
from ...session.commands.commands import Edit, LookFrom, SetLanguage, ToggleDownloads, ToggleHelp, ToggleLecture, ToggleTheme
from ...session.commands.guide import ToggleGlossary
from ...session.state.view import Picture
from ...text import languages, name_of
from . import phrases

MODE_WORDS = (("guide", phrases.GUIDE), ("lab", phrases.LAB), ("present", phrases.PRESENT))


def menu_html(picture: Picture, hand: str, first: Iterable[tuple[str, str]] = (), last: Iterable[tuple[str, str]] = (),
              keys: bool = True) -> str:
    """The menu with more items at its beginning and its end, each what it says to the hidden widget `hand`, and its words.

    `keys` is whether it offers the list of keys.
    """
    lang, lab = picture.state.language, not picture.guided
    theme = phrases.LIGHT if picture.state.is_dark else phrases.DARK_THEME
    items = [*first, *((f"language:{code}", name_of(code)) for code in languages() if code != lang), ("theme", theme(lang))]
    items += [("print", phrases.LECTURE(lang)), ("view", phrases.VIEW(lang))] if lab else []
    items += [("take", phrases.TAKE(lang)), ("terms", phrases.GLOSSARY(lang)), *([("help", phrases.HELP(lang))] if keys else []), *last]
    more = "".join(f'<button type="button" class="ol-item" data-to="{hand}" data-value="{value}">{html.escape(words)}</button>'
                   for value, words in items)
    pages = [("search", phrases.SEARCH), ("light", phrases.SHADOWS), *([] if lab else [("notes", phrases.NOTES)])]
    more += "".join(f'<button type="button" class="ol-item ol-{name}">{html.escape(words(lang))}</button>' for name, words in pages)
    return (f'<details class="ol-more"><summary aria-label="{html.escape(phrases.MORE(lang), quote=True)}">⋯</summary>'
            f"<div>{more}</div></details>")


def menu_edit(kind: str, value: str) -> Edit | None:
    """What an item of the menu asks for, None for an item of somebody else."""
    if kind == "language":
        return SetLanguage(value)
    asked = {"theme": ToggleTheme, "print": ToggleLecture, "take": ToggleDownloads, "terms": ToggleGlossary, "help": ToggleHelp}
    return LookFrom("all") if kind == "view" else asked[kind]() if kind in asked else None


def mode_switch(now: Mode, language: str, hand: str) -> str:
    """A button for each view of a lesson; each says `mode:` and its name to the hidden widget `hand`."""
    modes = "".join(f'<button type="button" class="ol-mode" aria-pressed="{"true" if mode == now else "false"}" '
                    f'data-to="{hand}" data-value="mode:{mode}">{html.escape(words(language))}</button>' for mode, words in MODE_WORDS)
    return f'<span class="ol-modes" role="group">{modes}</span>'
