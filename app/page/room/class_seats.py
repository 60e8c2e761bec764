"""Give each follower of one worker a number, and draw the run of that number for it."""

from __future__ import annotations

import asyncio
import html
from collections.abc import Mapping
from functools import partial

import numpy as np

from ...classroom.kept_room import KeptRoom
from ...classroom.room import ClassRuns, OwnRun, read_runs
from ...course.figures.records import Curve, PlaneFigure
from ...text import same
from ..charts.svg import draw
from ..words import phrases
from .follower import Follower


class ClassSeats:
    """The numbers of this worker's followers. Only the thread that counts the room calls `update`."""

    def __init__(self, store: KeptRoom, worker: int) -> None:
        self._store, self._worker = store, worker
        self._seats: dict[int, int] = {}
        self._shown = -1
        store.empty_worker(worker)

    def update(self, followers: Mapping[int, Follower], loop: asyncio.AbstractEventLoop) -> None:
        """Number those who have come, forget those who have left, and show what runs there are now."""
        here = dict(followers)
        left = [client for client in self._seats if client not in here]
        new = [client for client in here if client not in self._seats]
        if left:
            self._store.leave_seats([self._seats.pop(client) for client in left])
        if new:
            self._seats.update(zip(new, self._store.take_seats(self._worker, len(new)), strict=True))
        number = self._store.run_number
        if number != self._shown:
            self._shown = number
            words = self._store.runs()
            self._show(here, None if not words else read_runs(words), loop)

    def _show(self, followers: Mapping[int, Follower], runs: ClassRuns | None, loop: asyncio.AbstractEventLoop) -> None:
        for client, follower in followers.items():
            own = None if runs is None else runs.runs.get(self._seats[client])
            content = "" if runs is None or own is None else own_run_html(runs, own, follower.language)
            if loop.is_closed():  # the server ends
                return
            loop.call_soon_threadsafe(partial(follower.show_run, content))


LEAST_HALF, MARGIN = 1e-12, 1.15  # of the range of the errors that is shown
STARTED = 0.25  # the part of the run after which its errors set that range: the start may lie beyond it


def own_run_html(runs: ClassRuns, run: OwnRun, language: str) -> str:
    """The course of the error between ±2σ, and whether it ends in the ellipse of P. Nothing tells whose run it is."""
    t, e, band = np.array(runs.times), np.array(run.path), 2 * np.array(run.sigma)
    late = slice(int(STARTED * len(t)), None)
    half = MARGIN * max(float(np.abs(e[late]).max()), float(band[late].max()), LEAST_HALF)
    figure = PlaneFigure(
        "own-run", phrases.OWN_RUN,
        (Curve(phrases.OWN_ERROR, e, "error", x=t), Curve(same("+ 2σ"), band, "muted", "dot", 1.4, t),
         Curve(same("− 2σ"), -band, "muted", "dot", 1.4, t)),
        x_label="t [s]", y_label=runs.name.get(language, next(iter(runs.name.values()))), x_range=(float(t[0]), float(t[-1])),
        y_range=(-half, half))
    said = html.escape((phrases.OWN_INSIDE if run.inside else phrases.OWN_OUTSIDE)(language))
    return f'<section class="ol-own-run">{draw(figure, language)}<p class="ol-note" role="status">{said}</p></section>'
