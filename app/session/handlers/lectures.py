"""Give a lecture stop by stop, and record one while its scenes are tried out."""

from __future__ import annotations

from dataclasses import replace

from ...course.knobs import KnobError
from ...course.lectures import MAX_STOPS, Lecture, Stop, read_lecture, write_lecture
from ...text import languages, text
from ..state.validate import check_number
from . import guide
from .presenter import Presenter

NO_SCENE = text("Open a scene in the guide first; then it can be noted for a lecture.")
NOTHING_RECORDED = text("No scene is noted yet; open one in the guide and press B.")
OWN_TITLE = text("My lecture")


def turn_scene(show: Presenter, steps: int) -> None:
    """Turn so many stops of the lecture, or scenes of the path."""
    if show.state.talk is not None:
        _go_to(show, show.state.stop + steps)
    else:
        guide.enter_scene(show, show.state.scene + steps)


def turn_to(show: Presenter, index: object) -> None:
    """Open what a turn on another page of the presenter has led to, unless it stands here already. Raises KnobError."""
    if show.picture.place[0] != index:
        go_to_scene(show, index)


def go_to_scene(show: Presenter, index: object) -> None:
    """Open a stop of the lecture, or a scene of the path. Raises KnobError."""
    (guide.enter_scene if show.state.talk is None else _go_to)(show, int(check_number(index)))


def end_lecture(show: Presenter) -> None:
    """Leave the lecture; its lesson stays open, as a guide."""
    if show.state.talk is not None:
        guide.stop(show)
        show.rebuild(replace(show.state, talk=None, stop=0, mode="guide", lecture=False))


def begin(show: Presenter) -> None:
    """Open the lecture's stop where another scene stands, as when the server brought the lecture."""
    talk = show.state.talk
    if talk is not None:
        stop = talk.stops[show.state.stop]
        if (show.lesson.id, _scene_id(show)) != (stop.lesson, stop.scene):
            _go_to(show, show.state.stop)
            return
    guide.enter(show)


def _read(show: Presenter, words: object) -> Lecture:
    try:
        written = words.decode("utf-8-sig") if isinstance(words, bytes) else str(words)
    except UnicodeDecodeError as error:
        raise KnobError(text("The lecture is not a text in UTF-8.")) from error
    return read_lecture(written, show.lessons)


def open_lecture(show: Presenter, words: object) -> None:
    """Give the lecture of a TOML file, from its first stop. Raises KnobError."""
    talk = _read(show, words)
    guide.stop(show)
    show.state = replace(show.state, talk=talk, stop=0, mode="present", lecture=True)
    _go_to(show, 0, anew=True)


def _go_to(show: Presenter, index: int, anew: bool = False) -> None:
    """Open a stop of the lecture; beyond its ends nothing happens."""
    talk = show.state.talk
    if talk is None or not 0 <= index < len(talk.stops):
        return
    guide.stop(show)
    stop = talk.stops[index]
    show.state = replace(show.state, stop=index)
    if stop.lesson != show.lesson.id:
        show.open_lesson(stop.lesson)
    elif anew:
        show.rebuild(show.state)
    path = [scene.id for scene in show.lesson.path]
    guide.enter_scene(show, path.index(stop.scene))


def _scene_id(show: Presenter) -> str:
    scene = show.picture.scene
    return "" if scene is None else scene.id


def record_stop(show: Presenter) -> None:
    """Note the open scene. What is given as a lecture can be recorded too: its stop is noted with its note."""
    scene, state = show.picture.scene, show.state
    if scene is None:
        raise KnobError(NO_SCENE)
    if len(state.recorded) >= MAX_STOPS:
        raise KnobError(text("A lecture has at most {most} stops; save this one first.", most=MAX_STOPS))
    given = state.talk.stops[state.stop] if state.talk is not None else None
    show.change(replace(state, recorded=(*state.recorded, given or Stop(show.lesson.id, scene.id, {}, scene.minutes))))
    show.view.say(text("Stop {number} of your lecture is noted: {title}.", number=len(show.state.recorded),
                       title=show.picture.scene_words.title), False)


def save_lecture(show: Presenter) -> None:
    """Hand over what was recorded as a TOML file, and begin a new recording. Raises KnobError."""
    stops = show.state.recorded
    if not stops:
        raise KnobError(NOTHING_RECORDED)
    title = {language: OWN_TITLE(language) for language in languages()}
    show.view.download("lecture.toml", write_lecture(Lecture(title, stops, sum(stop.minutes for stop in stops))).encode())
    show.change(replace(show.state, recorded=()))
