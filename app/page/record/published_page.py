"""Build the page of a published folder: viser's own, fed from files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from ...session.handlers.playback import PLAYBACK_SPEEDS
from .. import web
from ..stage.viewpoint import BOARD_HEIGHT, BOARD_WIDTH
from ..web.html_page import APP_NAME, viser_page, web_code
from ..words import phrases
from .recorded_screen import WINDOWS

POLICY = ("default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; style-src 'unsafe-inline'; "
          "img-src data: blob:; font-src data:; media-src data: blob:; worker-src data: blob:; connect-src data: blob:; base-uri 'none'; "
          "form-action 'none'")
BUTTONS = (("play", phrases.PLAY), ("pause", phrases.PAUSE), ("kick", phrases.KICK), ("rewind", phrases.REWIND),
           ("slower", phrases.SLOWER), ("faster", phrases.FASTER), ("next", phrases.NEXT_SCENE), ("back", phrases.BACK_SCENE),
           ("lacks", phrases.NOT_PUBLISHED))


def published_page(languages: Sequence[str], lessons: Sequence[str], looks: Sequence[str], data: str,
                   stops: Sequence[tuple[str, str]] = (), lecture: Mapping[str, str] = MappingProxyType({})) -> str:
    """The page that shows these lessons in these looks from the folder `data` beside it.

    Next and Back follow the stops of a lecture, lesson and scene each, and lead at its ends to the page of the lecture in the language.
    """
    words = {code: {name: button(code) for name, button in BUTTONS} for code in languages}
    script = web.script_call("published", lessons=list(lessons), looks=list(looks), words=words,
                             web={code: web_code(code) for code in languages}, speeds=list(PLAYBACK_SPEEDS),
                             stops=list(stops), lecture=dict(lecture), board=[BOARD_WIDTH, BOARD_HEIGHT / 2],
                             shapes={width: canvas[0] / canvas[1] for width, (_, canvas) in WINDOWS.items()})
    return viser_page(APP_NAME, f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
                                f'<meta name="viewport" content="width=device-width,initial-scale=1">'
                                f"<style>{web.coloured_text('published.css')}{web.font_rules()}</style>"
                                f"<script>{web.script_call('viser_dom')}</script><script>{web.script_call('software')}</script>"
                                f"<script>{web.script_call('folded')}</script><script>{web.script_call('breadth')}</script>"
                                f"<script>{web.script_call('packed', folder=data)}</script><script>{script}</script>")
