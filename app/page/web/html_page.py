"""Build the HTML page around viser, with our name, or with a recording that needs no server."""

from __future__ import annotations

import base64
import html
import re
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from urllib.parse import quote

import viser

from ...text import Text, languages
from .. import web
from ..access.places import PLACE_FIELD
from ..words import phrases

APP_NAME = "Observer Lab"
ADDRESS = "observer-lab-address"  # the key of the token that a tab has put into its address bar
HELD, RELOADED = "observer-lab-held", "observer-lab-reloaded"  # the keys of what the server has not answered, and of the last resort
SCROLLED = "observer-lab-scrolled"  # the key of where a page's columns stood when it loaded itself again
TICKET = "observer-lab-place"  # the key of the ticket by which a tab finds its place again
REST = "rest"  # the reason of a close after which a page waits for a hand
SPOKEN = "observer-lab-language"  # the key of the language that a tab spoke last


def app_page(language: str) -> str:
    """viser's page under our name and sign, with what must run before the view opens in it.

    Until a lesson stands it shows our name in `language`, or in the one that the tab spoke before, instead of viser's form
    for an address; while the server does not answer, a sentence stands above what was last shown.

    Without a graphics card the view is drawn without multisampling; a scene at rest is finer instead.
    """
    words = {web_code(code): {"name": APP_NAME, "loading": phrases.LOADING(code), "lost": phrases.SERVER_LOST(code),
                              "rests": phrases.PAGE_RESTS(code), "token": phrases.OTHER_TOKEN(code),
                              "stranger": phrases.STRANGER(code)} for code in languages()}
    connection = (web.script_call("lifeline", version=version(), reloads=RELOADED, rest=REST), web.script_call("held", kept=HELD),
                  web.script_call("link", words=words, language=web_code(language), kept=SPOKEN, scrolled=SCROLLED))
    return viser_page(APP_NAME, f"<style>{web.coloured_text('link.css')}{web.font_rules()}</style>"
                             f"<script>{web.script_call('viser_dom')}</script>"
                             f"<script>{web.script_call('software')}</script>"
                             f"<script>{web.script_call('folded')}</script><script>{web.script_call('breadth')}</script>"
                             f"{''.join(f'<script>{script}</script>' for script in connection)}"
                             f"<script>{web.script_call('address', kept=ADDRESS)}</script>"
                             f"<script>{web.script_call('place', kept=TICKET, field=PLACE_FIELD)}</script>")


def server_full_page(language: str, places: int, seconds: int) -> str:
    """What a browser gets while a server has no place for it: one sentence in every language, its own first; it asks again by itself."""
    return _page_that_says(phrases.FULL.format(places=places, seconds=seconds), language,
                           f'<meta http-equiv="refresh" content="{seconds}">'
                           f"<script>{web.script_call('queue', kept=TICKET, field=PLACE_FIELD)}</script>")


def token_required_page(language: str) -> str:
    """What a browser gets that has not shown the access token: one sentence in every language.

    It asks once more by itself: who comes by a link on another site's page brings no cookie, though the browser may have it.
    """
    return _page_that_says(phrases.ASKS_FOR_TOKEN, language, f"<script>{web.script_call('knock')}</script>")


def _page_that_says(words: Text, language: str, head: str) -> str:
    codes = sorted(languages(), key=lambda code: code != language)
    said = "".join(f'<span lang="{web_code(code)}">{html.escape(words(code))}</span>' for code in codes)
    return (f'<!doctype html><html lang="{web_code(language)}"><head><meta charset="utf-8"><title>{APP_NAME}</title>'
            f'<meta name="viewport" content="width=device-width">{head}'
            f'<style>{web.coloured_text("link.css")}</style></head><body>'
            f'<main class="ol-cover"><b>{APP_NAME}</b>{said}</main></body></html>')


def recording_page(recording: bytes, language: str, title: str, head: str, body: str, dark: bool) -> str:
    """viser's page with a recording in it, which it plays without a server, and what of ours stands in its head and beside it."""
    embedded = web.script_call("embed", recording=base64.b64encode(recording).decode("ascii"), dark=dark)
    text = viser_page(title, f"{head}<style>{web.font_rules()}</style>"
                                f"<script>{web.script_call('viser_dom')}</script><script>{web.script_call('software')}</script>"
                                f"<script>{embedded}</script>")
    text = re.sub("<noscript>.*?</noscript>", "", text, count=1, flags=re.DOTALL)  # the figures are read without scripts
    text = text.replace('<html lang="en">', f'<html lang="{web_code(language)}">', 1)
    return text.replace("</body>", f"{body}</body>", 1)


def viser_page(title: str, head: str) -> str:
    theirs = Path(viser.__file__).parent / "client" / "build" / "index.html"
    text = re.sub(r'<link\s+rel="icon".*?/>', "", theirs.read_text(encoding="utf-8"), count=1, flags=re.DOTALL)
    icon = "data:image/svg+xml," + quote(web.coloured_text("icon.svg"))
    return text.replace("<title>Viser</title>", f'<link rel="icon" href="{icon}" /><title>{html.escape(title)}</title>{head}', 1)


def web_code(language: str) -> str:
    """A language's code as browsers write it."""
    return language.replace("_", "-")


@lru_cache(maxsize=1)
def version() -> str:
    """The version that is installed, "source" where none is."""
    try:
        return metadata.version("observer-lab")
    except metadata.PackageNotFoundError:
        return "source"
