"""Compute the margins of a design: guaranteed for LQR, not for LQG."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.engine import compensator, loop_margins
from observer_lab.engine.feedback import ChannelMargins, LoopMargins, state_feedback_margins

from .cases import Case, Factors
from .loops import Setting, gains, regulator

NYQUIST_STEP, DRAWN_POINTS = 0.1, 240  # of Nyquist's curve: a longer jump counts as this; points drawn
NEAREST_LIMIT = 1e-9  # of a gain to 1: nearer than this it is not told from 1
MATRICES_PER_BATCH = 60  # matrices looked at together


@dataclass(frozen=True, eq=False)
class Robustness:
    """A loop cut at one plant input, the model being right; each part is found when it is looked at."""

    case: Case
    all: LoopMargins
    cut: int

    @cached_property
    def margins(self) -> ChannelMargins:
        """There."""
        return self.all.input(self.cut)

    @cached_property
    def gain(self) -> np.ndarray:
        """ℓ (n_f,) at the case's wide frequencies."""
        return _gain(self._wide[:, self.cut, self.cut])

    @cached_property
    def curve(self) -> np.ndarray:
        """ℓ along Nyquist's curve in even steps."""
        return _even(_gain(self.all.loop.own(self.cut)))

    @cached_property
    def together(self) -> np.ndarray:
        """All inputs at once: σ_min(I + L) over frequency (n_f,)."""
        return _least(self._wide)

    @cached_property
    def nearest(self) -> float:
        """Its least value."""
        return 1 / _largest(self._dense)

    @cached_property
    def alpha(self) -> float:
        """Of the unstructured disk."""
        return 1 / _largest(self._dense - 0.5 * np.eye(self.case.plant.m))

    @cached_property
    def _wide(self) -> np.ndarray:
        return self.all.loop.corner(2 * np.pi * self.case.wide, self.case.plant.m)

    @cached_property
    def _dense(self) -> np.ndarray:
        return self.all.loop.corner(self.all.loop.omega, self.case.plant.m)


def within(limits: tuple[float, float]) -> tuple[float, float]:
    """Both limits of a gain as they are written: rounded toward 1, so that what is named is inside, to two digits of the distance to 1."""
    low, high = limits
    return float(np.ceil(low * _parts(low)) / _parts(low)), float(np.floor(high * _parts(high)) / _parts(high))


def beyond(high: float) -> float:
    """The upper limit rounded away from 1: a gain at which the loop is unstable."""
    return float(np.ceil(high * _parts(high)) / _parts(high))


def _parts(limit: float) -> float:
    """The steps of a written limit in a unit: three decimals, more where it is nearer to 1 than that."""
    away = abs(limit - 1)
    return 10.0 ** max(3.0, 1 - np.floor(np.log10(away))) if NEAREST_LIMIT < away < np.inf else 1e3


@lru_cache(maxsize=32)
def ideal(case: Case, alpha_q: float, alpha_r: float, cut: int) -> Robustness:
    """Of LQR, the whole state known."""
    return Robustness(case, state_feedback_margins(case.plant, regulator(case, alpha_q, alpha_r).gain), cut)


@lru_cache(maxsize=32)
def real(case: Case, factors: Factors, recovery: float, cut: int) -> Robustness:
    """Of LQG."""
    reg, est = gains(case, Setting(factors, recovery, 1.0))
    return Robustness(case, loop_margins(case.plant, compensator(case.plant, reg.gain, est.gain)), cut)


def _gain(S: np.ndarray) -> np.ndarray:
    """ℓ = 1/S − 1, at most 10⁹ where an integrator makes S zero."""
    return 1 / np.where(np.abs(S) < 1e-9, 1e-9, S) - 1


def _even(ell: np.ndarray) -> np.ndarray:
    """Points of a curve about evenly spaced where it is near, so that resonances are round and far arcs cost little."""
    way = np.concatenate([[0.0], np.cumsum(np.minimum(np.abs(np.diff(ell)), NYQUIST_STEP))])
    return ell[np.unique(np.searchsorted(way, np.linspace(0.0, way[-1], DRAWN_POINTS)).clip(0, len(ell) - 1))]


def _least(S: np.ndarray) -> np.ndarray:
    """1/σ_max(S) of each matrix of a stack: σ_min of I + L."""
    if S.shape[-1] == 1:
        return 1 / np.maximum(np.abs(S[:, 0, 0]), 1e-9)
    return 1 / np.sqrt(np.maximum(np.linalg.eigvalsh(S.conj().swapaxes(1, 2) @ S)[:, -1], 1e-18))


def _largest(matrices: np.ndarray) -> float:
    """The largest singular value of a stack; one whose Frobenius norm lies below the best so far need not be looked at."""
    size = np.linalg.norm(matrices, axis=(1, 2))
    if matrices.shape[-1] == 1:
        return float(size.max())
    order, best = np.argsort(size)[::-1], 0.0
    for part in np.array_split(order, max(len(order) // MATRICES_PER_BATCH, 1)):
        if size[part[0]] <= best:
            break
        M = matrices[part]
        best = max(best, float(np.sqrt(np.linalg.eigvalsh(M.conj().swapaxes(1, 2) @ M)[:, -1].max())))
    return best
