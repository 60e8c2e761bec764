"""Many runs of one case beside each other: the same equations as in `runs`, a step of all of them at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .bank import COUNT, DT, gain, guard, model, truth
from .runs import DRIFT, OPEN, STUCK, Case, Noise, known_force


def residuals_of(case: Case, noises: Sequence[Noise]) -> np.ndarray:
    """Residuals of the bank (COUNT, runs, 7, 3) in the runs of a case without a kick in which nobody notices, one for each noise."""
    w, v = (np.stack([getattr(noise, name) for noise in noises], axis=1) for name in "wv")
    y, asked = _loop(case, w, v, np.stack([noise.whole for noise in noises]))
    s = guard().bank.system
    known = np.concatenate([asked, y], axis=2)
    states = _scan(s.A, known[:-1] @ s.B.T, np.stack([noise.bank for noise in noises]))
    return (states @ s.C.T + known @ np.asarray(s.D).T).reshape(COUNT, len(noises), len(guard().bank.members), -1)


def _loop(case: Case, w: np.ndarray, v: np.ndarray, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the sensors say, (COUNT, runs, 4), and what is asked of the coils, (COUNT, runs, 3)."""
    kf, o, start = model(), guard().whole, case.start
    K = gain() if case.loop != OPEN else np.zeros((3, 6))
    A, B = truth(case.stiffer)
    C, shape = kf.C, known_force(case)[:, None]
    z = np.empty((COUNT + 1, len(whole), 12))
    z[0], said = np.hstack([np.zeros((len(whole), 6)), whole]), np.empty((COUNT, len(whole), 4))
    for begin, end in ((0, min(start, COUNT)), (start, COUNT)):
        if begin >= end:
            continue
        if begin == start:
            B, C, v = _lies(case, B, C, v, z[start, :, :6])
        step = np.block([[A, -B @ K], [o.K @ C, o.F - o.G @ K]])
        push = np.concatenate([shape[begin:end] @ B.T + w[begin:end], shape[begin:end] @ o.G.T + v[begin:end] @ o.K.T], axis=2)
        z[begin:end + 1] = _scan(step, push, z[begin])
        said[begin:end] = z[begin:end, :, :6] @ C.T + v[begin:end]
    return said, shape - z[:COUNT, :, 6:] @ K.T


def _lies(case: Case, B: np.ndarray, C: np.ndarray, v: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """B and C with the fault, and what is added to C x, as in `runs`; x (runs, 6) is where the fault begins."""
    start = case.start
    if case.coil is not None:
        B = B.copy()
        B[:, case.coil] *= 1 - case.size
    elif case.sensor is not None:
        i, C, v = case.sensor, C.copy(), v.copy()
        if case.kind == STUCK:
            v[start:, :, i] = x @ C[i] + v[start, :, i]
            C[i] = 0.0
        else:
            late = np.arange(COUNT - start)[:, None]
            v[start:, :, i] += 1e-3 * case.size * (DT * late if case.kind == DRIFT else 1.0)
    return B, C, v


def _scan(step: np.ndarray, push: np.ndarray, start: np.ndarray) -> np.ndarray:
    """z⁺ = step z + push for all runs: (steps + 1, runs, N) of push (steps, runs, N)."""
    z = np.empty((len(push) + 1, *start.shape))
    z[0], turned = start, np.ascontiguousarray(step.T)
    for k in range(len(push)):
        np.matmul(z[k], turned, out=z[k + 1])
        z[k + 1] += push[k]
    return z
