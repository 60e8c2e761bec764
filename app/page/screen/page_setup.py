"""Send the scripts that a page runs once: drawing, keys and pointer."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ...session.commands.commands import Edit, PageSeen
from ...session.commands.shortcuts import SHORTCUTS
from ...session.state.view import Picture
from ..stage.drag_handles import FAINT, GRIPS, OBSERVER_BOARD
from ..stage.lighting import cast_shadows
from ..viser_private import page_scripts, viser_internals
from ..web.html_page import APP_NAME

PAGE_SCRIPTS = (
    # Draw each answer of the server in one frame; where frames come slowly, with fewer pixels while things move. viser takes
    # moves up inside a frame and hands half of them to React, whose changes then cost a second frame: here they are taken up
    # as they arrive. It covers the whole view with a background image even when there is none: here it does not. On a slow
    # machine it lowers the resolution to three quarters and after seconds, and goes on drawing for a quarter of a second after
    # every change: here the moving scene has 0.6 of its pixels each way, and is drawn once more, sharp, when it rests.
    "frames",
    "folders",  # let Tab reach the heads of folders and Enter or Space open them: viser opens folders by the mouse alone
    "keys",  # keep from viser's camera the keys that mean something else here: the arrows of a widget, the letters of commands
    "options",  # let a button of our own HTML, with mathematics in it, answer for a widget
    "terms",  # show what a term means where the pointer or the focus is on it
    "dialogs",  # close a dialog by Escape, and by a press beside it
    "held_rows",  # keep the rows of the column where they are while a hand is at work
    "news",  # bring a verdict or a second question into view, clear of the knobs that lie over its column
    "reading",  # say what the curves of a chart are where the pointer is; viser hands no function to its charts that could
    "names",  # write the names of a chart's curves beside them; viser has a key below the chart and nothing else
    "cursor",  # put the cursor of every chart over time where the clock stands
    "diagram",  # light a block of a diagram with its equation
    "snapshot",  # let the dialog keep the stage as a picture, drawn with all its pixels on the ground that the page gives it
    "countdown",  # count down how long the class discusses
    "parts",  # let a phone show one part of the lesson at a time
    "drop",  # take a file that is dropped on a folder with an upload button
    "floor",  # keep the camera from turning or sliding under the floor, from where nothing can be seen
)


def run_page_scripts(client: viser.ClientHandle) -> None:
    """Run every script that a page keeps until it is closed."""
    for name in PAGE_SCRIPTS:
        viser_internals.run_script(client, name)
    cast_shadows(client)
    page_scripts.pulse_once(client, GRIPS, OBSERVER_BOARD, FAINT)


def watch_page_visibility(client: viser.ClientHandle, post: Callable[[Edit], object]) -> None:
    """Ask the page whether anybody sees it; then a run that has not begun is shown in motion."""
    seen = client.gui.add_number("", -1.0, visible=False)  # neither answer, so that either is heard

    @seen.on_update
    async def _(event: viser.GuiEvent) -> None:
        post(PageSeen(event.target.value))
    page_scripts.ask_whether_seen(client, seen)


def stage_name(picture: Picture, language: str) -> str:
    """What a screen reader says of the stage: what stands on it."""
    stage = picture.outcome.stage
    return stage.body.caption(language) if stage is not None else picture.lesson.words[language].title


def speak(client: viser.ClientHandle, picture: Picture, language: str) -> None:
    """Name the page, viser's own words and the stage in a language."""
    page_scripts.name_page(client, f"{picture.lesson.words[language].title} · {APP_NAME}", language)
    page_scripts.say_in(client, language)
    viser_internals.run_script(client, "aria", stage=stage_name(picture, language))


def bind_shortcuts(client: viser.ClientHandle, post: Callable[[Edit], object], language: str) -> None:
    """Bind the keys, which also fill the command palette."""
    for shortcut in SHORTCUTS:
        handle = client.gui.add_command(shortcut.label(language), hotkey=shortcut.key,  # type: ignore[arg-type]
                                        modifier=shortcut.modifier)  # type: ignore[arg-type]
        _bind(handle, shortcut.command, post)


def _bind(handle: viser.CommandHandle, command: Edit, post: Callable[[Edit], object]) -> None:
    @handle.on_trigger
    async def _(_: object) -> None:
        post(command)
