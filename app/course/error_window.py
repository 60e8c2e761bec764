"""Find the part of a run in which the estimation error is large, to replay while a knob moves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .lesson import Stage

DECAYED_SHARE = 0.05  # of its peak: below this the error lives no more
MOMENTS = 80  # at which the stage is looked at
DEAD_ERROR_SHARE = 0.1  # of the run: an error that was dead for longer lives anew
MIN_WINDOW_SHARE = 0.1  # of the run: no part is shorter
AFTER_SHARE = 0.3  # of the part: how long one sees that the error is gone
MIN_REST_SHARE = 0.05  # of the run: how long one sees at least that nothing moves any more
EARLY_SHARE, HALVED = 0.05, 0.5  # of the part: a peak that early tells nothing yet; of the peak: when the ghost is on its way
MIN_ROUND_S = 2.0  # s that a round of a part takes at least, and less than 2.5 times as long


@dataclass(frozen=True)
class ErrorWindow:
    """From `begin` to `end` of a run, in its seconds; at `peak` the error is largest.

    `telling` is the moment at which a run that is over rests: the peak, or where the error began at its largest, when half of it has
    gone: then the plant has moved, and its ghost still stands apart.
    """

    begin: float
    end: float
    peak: float
    telling: float

    @property
    def rate(self) -> float:
        """Seconds of the run in a second of playing: 1, 2 or 5 times a power of ten, so that a round takes 2 to 5 s."""
        asked = (self.end - self.begin) / MIN_ROUND_S
        decade = 10.0 ** math.floor(math.log10(asked))
        return max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= asked * (1 + 1e-9))


def sample_at(times: np.ndarray, t: float) -> int:
    """The index of the last sample that is not after `t`, the first one before all."""
    return max(0, min(int(np.searchsorted(times, t + 1e-9, side="right")) - 1, len(times) - 1))


def apart(stage: Stage) -> tuple[np.ndarray, np.ndarray]:
    """Moments of the run, and how far plant and ghost stand apart then: the sum over the body's anchors, in stage units."""
    index = np.unique(np.linspace(0, len(stage.t) - 1, MOMENTS).round().astype(int))
    if stage.xhat is None:
        return stage.t[index], np.zeros(len(index))
    body = stage.body
    gaps = [sum(map(math.dist, body.anchors(stage.x[i].tolist(), body.gain), body.anchors(stage.xhat[i].tolist(), body.gain)))
            for i in index]
    return stage.t[index], np.nan_to_num(np.array(gaps, dtype=float), nan=0.0, posinf=0.0)


def run_end(stage: Stage) -> float:
    """When a run is over: shortly after plant and ghost have come to stand for good, as after a fall; else at its end."""
    first, last = float(stage.t[0]), float(stage.t[-1])
    moves = np.any([np.any(np.diff(states, axis=0) != 0, axis=1) for states in (stage.x, stage.xhat) if states is not None], axis=0)
    if not moves.any():
        return last
    stands = float(stage.t[np.flatnonzero(moves)[-1] + 1])
    return min(last, stands + max(AFTER_SHARE * (stands - first), MIN_REST_SHARE * (last - first)))


def find_error_window(stage: Stage, since: float = 0.0) -> ErrorWindow:
    """Where the error lives, from `since` on (a kick): about its peak, from when it rises above 5 % of that until it falls below.

    Moments of silence shorter than a tenth of the run belong to it. Where nothing is estimated, or the ghost never leaves
    the plant, or its error never dies, that is the rest of the run, until it is over.
    """
    t, gap = apart(stage)
    first, last = float(t[0]), run_end(stage)
    since = since if first <= since < last else first
    gap = np.where(t >= since - 1e-12, gap, 0.0)
    top = int(np.argmax(gap))
    if not gap[top] > 0:
        return ErrorWindow(since, last, since, since)
    alive = np.flatnonzero(gap > DECAYED_SHARE * gap[top])
    breaks = np.flatnonzero(np.diff(t[alive]) > DEAD_ERROR_SHARE * (last - first))
    groups = np.split(alive, breaks + 1)
    own = next(group for group in groups if top in group)
    begin = max(since, float(t[max(own[0] - 1, 0)]))
    end = float(t[min(own[-1] + 1, len(t) - 1)])
    end = min(last, max(end + AFTER_SHARE * (end - begin), begin + MIN_WINDOW_SHARE * (last - first)))
    peak = min(max(float(t[top]), begin), end)
    halved = np.flatnonzero((t > peak) & (gap <= HALVED * gap[top]))
    early = peak - begin < EARLY_SHARE * (end - begin)
    return ErrorWindow(begin, end, peak, peak if not early else min(float(t[halved[0]]), end) if len(halved) else 0.5 * (begin + end))
