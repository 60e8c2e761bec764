"""Simulate many runs of one case at once, by the same equations as `runs`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .observer_bank import SAMPLE_COUNT, gain, guard, truth
from .runs import KEEP_LOOP_OPEN, Case, Noise, failed, known_force, stretches


def residuals_of(case: Case, noises: Sequence[Noise]) -> np.ndarray:
    """Residuals of the bank (SAMPLE_COUNT, runs, 7, 3) in the runs of a case without a kick in which nobody notices, one for each noise."""
    w, v = (np.stack([getattr(noise, name) for noise in noises], axis=1) for name in "wv")
    y, asked = _loop(case, w, v, np.stack([noise.whole for noise in noises]))
    s = guard().bank.system
    known = np.concatenate([asked, y], axis=2)
    states = _scan(s.A, known[:-1] @ s.B.T, np.stack([noise.bank for noise in noises]))
    return (states @ s.C.T + known @ np.asarray(s.D).T).reshape(SAMPLE_COUNT, len(noises), len(guard().bank.members), -1)


def _loop(case: Case, w: np.ndarray, v: np.ndarray, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the sensors say, (SAMPLE_COUNT, runs, 4), and what is asked of the coils, (SAMPLE_COUNT, runs, 3)."""
    o, (A, _) = guard().whole, truth(case.stiffer)
    K = gain() if case.loop != KEEP_LOOP_OPEN else np.zeros((3, 6))
    shape = known_force(case)[:, None]
    z = np.empty((SAMPLE_COUNT + 1, len(whole), 12))
    z[0], said = np.hstack([np.zeros((len(whole), 6)), whole]), np.empty((SAMPLE_COUNT, len(whole), 4))
    for begin, end in stretches(case, 0):
        deck = failed(case, v, z[:, :, :6], begin)
        step = np.block([[A, -deck.B @ K], [o.K @ deck.C, o.F - o.G @ K]])
        push = np.concatenate([shape[begin:end] @ deck.B.T + w[begin:end],
                               shape[begin:end] @ o.G.T + deck.extra[begin:end] @ o.K.T], axis=2)
        z[begin:end + 1] = _scan(step, push, z[begin])
        said[begin:end] = z[begin:end, :, :6] @ deck.C.T + deck.extra[begin:end]
    return said, shape - z[:SAMPLE_COUNT, :, 6:] @ K.T


def _scan(step: np.ndarray, push: np.ndarray, start: np.ndarray) -> np.ndarray:
    """z⁺ = step z + push for all runs: (steps + 1, runs, N) of push (steps, runs, N)."""
    z = np.empty((len(push) + 1, *start.shape))
    z[0], turned = start, np.ascontiguousarray(step.T)
    for k in range(len(push)):
        np.matmul(z[k], turned, out=z[k + 1])
        z[k + 1] += push[k]
    return z
