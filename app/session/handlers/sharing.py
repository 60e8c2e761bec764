"""Handle the commands that open or export a state as a link, a token or a file."""

from __future__ import annotations

import logging
from dataclasses import replace

from ...course.figures.records import tab_names
from ...course.knobs import KnobError
from ...course.lesson import Design
from ...course.scenes import Choose, Read
from ...engine import EngineError
from ...text import error_words, joined
from ..runtime.error_words import NOT_DONE, error_kind
from ..state.saved_state import NO_STATE, SavedState, read_state, write_state
from ..state.token import is_token, read_token, write_token
from .guide import begin_opened, entry_design
from .presenter import Presenter

LEAD_S, STALE_S = 1.0, 10.0  # s after its last edit in which a page keeps what a hand has made there; in which a lead may be behind it
LEFT_BEHIND = 40  # looks of a page that a lead may still have
log = logging.getLogger(__name__)


def open_state(show: Presenter, words: object, asked: object) -> None:
    """Open a state; where that fails the address bar goes back to what is shown. Raises KnobError and what a lesson raises."""
    show.asked = asked if isinstance(asked, int) else show.asked
    try:
        take(show, words)
    except Exception:
        show.remember()
        raise


def toggle_downloads(show: Presenter) -> None:
    """Open or close the dialog in which the state can be taken away."""
    show.view.offer(write_token(show.lesson, show.saved()))


def save_state(show: Presenter) -> None:
    """Hand the present state over as a file."""
    show.view.download(f"{show.lesson.id}.json", write_state(show.lesson, show.saved()).encode())


def take(show: Presenter, words: object) -> None:
    """Open the state in a token, a link or the words of a file, and say what could not be taken over. Raises KnobError and
    what the lesson raises."""
    _take(show, _read(show, words))
    if show.shown is not None:
        begin_opened(show)


def follow_lead(show: Presenter, token: str) -> None:
    """Show what the leading page of the same presenter shows: language, print and camera stay.

    Not where a hand has just been here, nor what this page itself showed before its last edits: the lead has not done them yet.
    """
    mine, lead = show.saved(), _read(show, token)
    lead = replace(lead, language=mine.language, lecture=mine.lecture, camera=mine.camera, tab=mine.tab, step=mine.step, notes=())
    quiet = show.clock() - max(show.last_edit, show.last_hand)
    if looks(lead) != looks(mine) and show.resting and quiet > LEAD_S and (quiet > STALE_S or looks(lead) not in show.left_behind):
        _take(show, lead)
        show.left_behind.clear()
        talk = show.state.talk
        places = [k for k, stop in enumerate(talk.stops if talk else ()) if (stop.lesson, stop.scene) == (lead.design.lesson, lead.scene)]
        if places:
            show.change(replace(show.state, stop=min(places, key=lambda k: abs(k - show.state.stop))))


def note_look(show: Presenter) -> None:
    """Note how a presenter's page looks before an edit: a lead that looks so has not done it yet."""
    if show.vote_desk is not None and show.shown is not None:
        show.left_behind = [*show.left_behind[-LEFT_BEHIND:], looks(show.saved())]


def looks(saved: SavedState) -> tuple[Design, str, int | None, str | None]:
    """The part of a state that is equal on two pages of a presenter that show the same."""
    return saved.design, saved.scene, saved.answered, saved.mode


def _take(show: Presenter, saved: SavedState) -> None:
    show.open_state(saved)
    if saved.scene:
        scene = [each.id for each in show.lesson.path].index(saved.scene)
        kept = show.lesson_state
        kept.scene, kept.entered = scene, True
        if saved.answered is None and not saved.design.plant:
            kept.began = entry_design(show, scene)  # a move is judged as for somebody who came to the scene along the path
        if saved.answered is None and isinstance(show.lesson.path[scene].do, Read):
            kept.done = {name: design for name, design in kept.done.items() if name != saved.scene}  # it is read anew
        elif saved.answered is not None:
            kept.done = {**kept.done, saved.scene: saved.design}
            kept.chosen = {**kept.chosen, saved.scene: saved.answered} if isinstance(show.lesson.path[scene].do, Choose) else kept.chosen
        if show.shown is not None:
            show.change(replace(show.state, scene=scene, done=kept.done, chosen=kept.chosen))
            if saved.camera is None and show.picture.guided:
                show.view.camera(show.lesson.path[scene].view)
    if saved.notes:
        show.tell(joined(*saved.notes), False)


def open_words(show: Presenter, words: str) -> None:
    """Open a state with which a page was called; where that fails, the page opens as it would, with a sentence."""
    try:
        take(show, words)
    except (KnobError, EngineError) as problem:
        show.tell(error_words(problem), True)
    except Exception as problem:
        log.exception("a link could not be opened")
        show.tell(NOT_DONE.format(kind=error_kind(problem)), True)


def look_again(show: Presenter, token: str) -> None:
    """After a reload: how the page looked, from the token that this tab has put into the address bar itself."""
    try:
        saved = _read(show, token)
    except KnobError:
        return
    if saved.design.lesson == show.lesson.id:
        show.state = replace(show.state, tab=saved.tab, step=saved.step, camera=saved.camera)


def _read(show: Presenter, words: object) -> SavedState:
    if isinstance(words, bytes):
        words = words.decode(errors="replace")
    if not isinstance(words, str):
        raise KnobError(NO_STATE)
    return read_token(words, show.lessons) if is_token(words) or "{" not in words else read_state(words, show.lessons)


def note_place(show: Presenter, tab: object, step: object) -> None:
    """Note which figures' tab and which step of thought are open."""
    names, steps = tab_names(show.picture.figures), show.lesson.words["en"].steps
    chosen = names[tab]("en") if isinstance(tab, int) and 0 < tab < len(names) else None
    opened = step if isinstance(step, int) and 0 <= step < len(steps) else None
    if (chosen, opened) != (show.state.tab, show.state.step):
        show.state = replace(show.state, tab=chosen, step=opened)
        show.remember()
