"""Handle playback: lock before a prediction, play by the clock, kick, stop at the end."""

from __future__ import annotations

from dataclasses import replace

from ...course.error_window import ErrorWindow, find_error_window
from ...text import text
from ..state.validate import check_number
from ..state.view import ReplayLoop
from .presenter import Presenter

FRAME_S = 1 / 30  # s between poses while playing
HAND_ROUNDS = 2  # of the loop after the last move of a hand: what is left of this one, and a whole one
OPENING_ROUNDS = 3  # that an opened lesson shows by itself
REFILL_BEFORE_S = 0.3  # s before a view that goes on by itself has come to its end
MAX_POSE_S = 0.25  # s of real time that one pose may cover at most: a stalled worker does not leap over the run
PLAYBACK_SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
LATE_POSE_S, LATE_POSES_IN_A_ROW = 0.3, 3  # s that a pose waits for other tabs, and how many in a row, until the page says so
LATE_NOTICE_PAUSE_S = 120.0  # s before it says so once more
CROWDED = text("Many tabs are at work on this server: the stage moves in fewer pictures, and what your hand does is answered first.")
PREDICT_FIRST = text("Choose a prediction first; then the run unlocks.")


def warn_if_locked(show: Presenter) -> bool:
    """Whether the run waits for a prediction; says so if it does."""
    if show.picture.veiled:
        show.view.say(PREDICT_FIRST, False)
        return True
    return False


def wait_for_frame(show: Presenter, now: float) -> float | None:
    """Seconds until the next pose is due, None while nothing moves. A view that goes on by itself is looked after in time."""
    if not show.state.moving:
        return None
    alone = show.alone if show.alone >= _left(show) - 1e-9 else show.alone - REFILL_BEFORE_S
    return max(0.0, show.last_tick + max(alone, FRAME_S) - now)


def catch_up(show: Presenter, now: float) -> None:
    """What follows begins where the run is by now, not where its view was last looked after."""
    if show.state.moving and show.alone > 0:
        passed, end = min(now - show.last_tick, show.alone), _end(show)
        show.state = replace(show.state, t=min(show.state.t + passed * show.picture.rate, max(end, show.state.t)))
        show.last_tick, show.alone = now, 0.0


def _end(show: Presenter) -> float:
    loop = show.state.loop
    return show.picture.end if loop is None else min(loop.part.end, show.picture.horizon)


def _left(show: Presenter) -> float:
    """Seconds of playing until the end of the run, or of this round of its loop."""
    return (_end(show) - show.state.t) / show.picture.rate


def tick(show: Presenter, now: float) -> None:
    """What is due of the run at `now`; its end, or that of its loop, reveals the answer to the prediction."""
    wait = wait_for_frame(show, now)
    if wait is None or wait > FRAME_S * 0.1:
        return
    loop, end = show.state.loop, _end(show)
    t = show.state.t + min(now - show.last_tick, max(MAX_POSE_S, show.alone)) * show.picture.rate
    show.last_tick, show.alone = now, 0.0
    if t < end - 1e-9:
        show.state = replace(show.state, t=t)
    elif loop is not None and loop.rounds > 1:
        part = part_with_error(show)
        show.state = replace(show.state, t=part.begin, loop=replace(loop, part=part, rounds=loop.rounds - 1))
    else:
        t = min(loop.rest, end) if loop is not None else telling_moment(show) if _told(show) else end
        show.state = replace(show.state, t=t, playing=False, loop=None)
        show.view.pose(t)
        show.change(replace(show.state, revealed=show.state.revealed or show.state.predicted is not None))
        return
    covered = show.view.play(show.state.t, _end(show), show.picture.rate, FRAME_S)
    show.alone = covered if covered > FRAME_S else 0.0


def report_lateness(show: Presenter, waited: float) -> None:
    """What is due has waited for other tabs; where that goes on, and something moves, the page says so, now and then."""
    show.late = show.late + 1 if waited > LATE_POSE_S and show.state.moving else 0
    if show.late >= LATE_POSES_IN_A_ROW and show.clock() - show.said_late > LATE_NOTICE_PAUSE_S:
        show.said_late = show.clock()
        show.view.say(CROWDED, False)


def replay_while_dragging(show: Presenter) -> None:
    """A knob has been moved: the part of the run in which the error lives plays, until a round after the last move.

    Not before a prediction, not where the person has stopped the run at a moment, and not where the browser asks for calm.
    """
    state = show.state
    if show.picture.veiled or show.picture.asks_second_prediction or state.stopped or state.calm or not _has_ghost(show):
        return
    if state.loop is not None:
        show.state = replace(state, loop=replace(state.loop, rounds=HAND_ROUNDS, rest=state.loop.part.end))
        return
    _go_round(show, HAND_ROUNDS)


def part_with_error(show: Presenter) -> ErrorWindow:
    """Where the error lives in the run that is shown, after the last kick."""
    stage = show.picture.outcome.stage
    assert stage is not None
    kicked = dict(show.picture.design.values).get("kick", 0.0) if show.lesson.kick else 0.0
    pulled = [t for _, record in stage.held for t, force in record if force]
    return find_error_window(stage, max(kicked, min(pulled, default=0.0)))


def telling_moment(show: Presenter) -> float:
    """The moment at which a run that is over rests: the scene's, else where plant and estimate differ most, the end without estimate.

    A scene that has been answered may have another one, at which its verdict is seen.
    """
    stage, scene = show.picture.outcome.stage, show.picture.scene
    if stage is None:
        return 0.0
    if scene is not None:
        share = scene.told if scene.told is not None and scene.id in show.state.chosen else scene.moment
        if share is not None:
            return share * show.picture.end
    return part_with_error(show).telling if stage.xhat is not None else show.picture.end


def _told(show: Presenter) -> bool:
    """Whether the run is the one that the verdict of the open scene speaks of."""
    scene = show.picture.scene
    return scene is not None and scene.id in show.state.chosen and show.state.done.get(scene.id) == show.design


def _untouched(show: Presenter) -> bool:
    """Whether the run still rests where its lesson or its scene has put it."""
    return not show.state.stopped and (show.state.t == 0.0 or (show.picture.guided and show.state.t == telling_moment(show)
                                                               and show.design == show.lesson_state.began))


def _go_round(show: Presenter, rounds: int) -> None:
    part = part_with_error(show)
    t = show.state.t if show.state.playing and part.begin <= show.state.t < part.end else part.begin
    rest = part.end if show.state.predicted is not None else telling_moment(show)
    show.change(replace(show.state, playing=False, stopped=False, t=t, loop=ReplayLoop(part, rounds, rest)))
    show.last_tick = show.clock()
    show.view.pose(t)


def watch(show: Presenter, seen: object) -> None:
    """Show an untouched run in motion, a few rounds long, when the page is seen; end that when it is hidden. Raises KnobError."""
    seen = check_number(seen) > 0
    show.state = replace(show.state, calm=not seen)
    if not seen and show.state.loop is not None:
        show.change(replace(show.state, loop=None))
    elif seen and not show.state.moving and _has_ghost(show) and _untouched(show):
        _go_round(show, OPENING_ROUNDS)


def _ended(show: Presenter) -> bool:
    return show.state.t >= show.picture.end - 1e-9


def play(show: Presenter) -> None:
    """Play or pause; a run that is over, or rests where the page has put it, plays from its start."""
    if warn_if_locked(show) or show.picture.horizon <= 0 or show.lesson.live is not None:
        return
    playing = not show.state.moving
    rests = _ended(show) or (not show.state.stopped and show.state.t == telling_moment(show))
    t = 0.0 if playing and rests else show.state.t
    show.change(replace(show.state, playing=playing, loop=None, stopped=not playing, t=t))
    show.view.pose(show.state.t)


def seek(show: Presenter, t: object) -> None:
    """Go to a time of the run, where it has others than now. Raises KnobError."""
    if warn_if_locked(show) or show.lesson.live is not None:
        show.redraw()
        return
    t = min(max(check_number(t), 0.0), show.picture.horizon)
    show.resting, show.last_edit = False, show.clock()  # what a hand holds is not written over before it rests
    show.change(replace(show.state, t=t, loop=None, stopped=t > 0.0 and not show.state.playing))
    show.view.pose(show.state.t)


def change_speed(show: Presenter, steps: int) -> None:
    """Play faster, or slower where `steps` is negative."""
    index = min(max(PLAYBACK_SPEEDS.index(show.state.speed) + steps, 0), len(PLAYBACK_SPEEDS) - 1)
    show.change(replace(show.state, speed=PLAYBACK_SPEEDS[index]))


def play_for_hand(show: Presenter) -> bool:
    """Let the run go on under a hand that pulls the plant, from its start where it is over; False where it is locked."""
    if warn_if_locked(show):
        return False
    if _ended(show):
        show.state = replace(show.state, t=0.0)
    if not show.state.playing:
        show.change(replace(show.state, playing=True, loop=None, stopped=False))
    return True


def kick(show: Presenter) -> None:
    """Strike the plant now and play on."""
    if not show.lesson.kick or warn_if_locked(show):
        return
    if _ended(show):
        show.state = replace(show.state, t=0.0)
    show.last_tick = show.clock()
    show.adopt_design(show.lesson.apply(show.design, {"kick": show.state.t}))
    show.change(replace(show.state, playing=True, loop=None, stopped=False))


def _has_ghost(show: Presenter) -> bool:
    """Whether the run that is shown has a ghost beside its plant, and is not a plant that runs now."""
    stage = show.picture.outcome.stage
    return stage is not None and stage.xhat is not None and show.lesson.live is None
