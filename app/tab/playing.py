"""The run: locked until a prediction, played by the clock, kicked, and silent while it stands still."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from ..text import text
from .commands import ChangeSpeed, Kick, Play, Playing, Rewind, Seek
from .gate import number
from .presenter import Presenter

FRAME = 1 / 30  # s between poses while playing
STALL = 0.25  # s of real time that one pose may cover at most: a stalled worker does not leap over the run
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
PREDICT_FIRST = text("Choose a prediction first; then the run unlocks.")


def obey(show: Presenter, command: Playing) -> None:
    """Do what a command of the run asks. Raises KnobError."""
    match command:
        case Play():
            _play(show)
        case Rewind():
            _seek(show, 0.0)
        case Seek(t):
            _seek(show, t)
        case ChangeSpeed(steps):
            _change_speed(show, steps)
        case Kick():
            _kick(show)
        case _:
            assert_never(command)


def locked(show: Presenter) -> bool:
    """Whether the run waits for a prediction; says so if it does."""
    if show.state.predicted is None:
        show.view.say(PREDICT_FIRST, False)
        return True
    return False


def wait_for_frame(show: Presenter, now: float) -> float | None:
    """Seconds until the next pose is due, None while nothing plays."""
    return max(0.0, show.last_tick + FRAME - now) if show.state.playing else None


def tick(show: Presenter, now: float) -> None:
    """The pose that is due at `now`; the end of the run reveals the answer to the prediction."""
    if not show.state.playing or now - show.last_tick < FRAME * 0.9:
        return
    picture = show.picture
    t = show.state.t + min(now - show.last_tick, STALL) * picture.rate
    show.last_tick = now
    ended = t >= picture.horizon
    show.state = replace(show.state, t=min(t, picture.horizon), playing=not ended)
    show.view.pose(show.state.t)
    if ended:
        show.change(replace(show.state, revealed=True))


def _ended(show: Presenter) -> bool:
    return show.state.t >= show.picture.horizon - 1e-9


def _play(show: Presenter) -> None:
    if locked(show) or show.picture.horizon <= 0:
        return
    playing = not show.state.playing
    show.change(replace(show.state, playing=playing, t=0.0 if playing and _ended(show) else show.state.t))
    show.view.pose(show.state.t)


def _seek(show: Presenter, t: object) -> None:
    if locked(show):
        show.redraw()
        return
    show.change(replace(show.state, t=min(max(number(t), 0.0), show.picture.horizon)))
    show.view.pose(show.state.t)


def _change_speed(show: Presenter, steps: int) -> None:
    index = min(max(SPEEDS.index(show.state.speed) + steps, 0), len(SPEEDS) - 1)
    show.change(replace(show.state, speed=SPEEDS[index]))


def _kick(show: Presenter) -> None:
    if not show.lesson.kick or locked(show):
        return
    if _ended(show):
        show.state = replace(show.state, t=0.0)
    show.last_tick = show.clock()
    show.adopt(show.lesson.apply(show.design, {"kick": show.state.t}))
    show.change(replace(show.state, playing=True))
