"""Call our scripts in the page for what viser cannot do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import viser

from ..web.html_page import SPOKEN, web_code
from ..words import phrases
from .viser_internals import node_id, run_script


def name_page(client: viser.ClientHandle, title: str, language: str) -> None:
    """What the browser's own tab is called, and the language that a screen reader and the next loading screen speak."""
    run_script(client, "name", title=title, language=web_code(language), kept=SPOKEN)


def say_in(client: viser.ClientHandle, language: str) -> None:
    """Let viser's own words, which it knows in English alone, stand in the language on its page."""
    run_script(client, "words", words={words("en"): words(language) for words in phrases.OF_VISER})


def flat_colour(client: viser.ClientHandle, name: str, colour: str) -> None:
    """Show a node in its colour as it is (#RRGGBB), neither lit nor toned down: viser has no such material."""
    run_script(client, "flat", node=name, colour=colour)


def open_tab(client: viser.ClientHandle, title: str, figure: str) -> None:
    """Bring a panel's tab to the front, as its Enter key does, and in it a figure into view; viser has no call for it."""
    run_script(client, "tab", title=title, figure=figure)


def find_knob(client: viser.ClientHandle, label: str, folder: str) -> None:
    """Put the focus on the widget beside these words, in a folder with this head if it is not in sight."""
    run_script(client, "find", label=label, folder=folder)


def light_stage(client: viser.ClientHandle, lamp: str, ground: str, picture: str, solids: str,
                metals: Sequence[tuple[int, int, int]]) -> None:
    """Cast shadows and let metal reflect where a graphics card draws: names of nodes, of `solids` how they begin."""
    run_script(client, "light", lamp=lamp, ground=ground, picture=picture, solids=solids,
               metals=[(red << 16) | (green << 8) | blue for red, green, blue in metals])


def turn_light(client: viser.ClientHandle) -> None:
    """Cast shadows, or no longer."""
    run_script(client, "turn_light")


def pulse_once(client: viser.ClientHandle, ending: str, best: str, faint: float, full: float = 0.6, seconds: float = 2.4) -> None:
    """Let nodes whose name ends so, of them those that begin as in `best`, swell in colour when a pointer first comes over the stage."""
    run_script(client, "pulse", ending=ending, best=best, faint=faint, full=full, lasts=1e3 * seconds)


def ask_whether_seen(client: viser.ClientHandle, widget: Any) -> None:
    """Let the page say to a widget whether somebody sees it and lets things move: 1 now or once it is shown, 0 when hidden."""
    run_script(client, "watched", widget=node_id(widget))


def tell_the_window(client: viser.ClientHandle, widget: viser.GuiVector3Handle) -> None:
    """Have a widget told how large the window is and whether its owner likes the dark, now and at every change."""
    run_script(client, "window", widget=node_id(widget))


def show_address(client: viser.ClientHandle, token: str, lesson: str, asked: int, answered: int) -> None:
    """Let the address bar say a state: another lesson is a page of its own to go back from, all else is not.

    `asked` is the number of the last state that was opened from there: the answer to an older one is passed over.
    `answered` is the number of the last press that the state holds.
    """
    run_script(client, "shown", token=token, lesson=lesson, asked=asked, answered=answered)


def tell_places(client: viser.ClientHandle, widget: Any, tabs: Sequence[str], steps: Sequence[str], tab: str | None) -> None:
    """Let a widget hear what is opened by hand, from the address bar and among tabs and folders, and open a tab."""
    run_script(client, "places", widget=node_id(widget), tabs=tabs, steps=steps, tab=tab)


def acknowledge(client: viser.ClientHandle, edit: int) -> None:
    """Let the page forget what a hand has done up to here: all of it was answered."""
    run_script(client, "beat", answered=edit)


def give_ticket(client: viser.ClientHandle, ticket: str) -> None:
    """Let a page keep the ticket by which it finds its place again."""
    run_script(client, "ticket", ticket=ticket)


def freeze(client: viser.ClientHandle, words: str) -> None:
    """Cover the page with a sentence and let nothing on it move or answer; without words it goes on."""
    run_script(client, "freeze", words=words)
