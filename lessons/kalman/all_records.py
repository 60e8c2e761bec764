"""Average the tests of lesson 9 over all records of the deck."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import chdtri, chndtr

from observer_lab.engine import chi2_band
from observer_lab.engine.filters import with_coloured_noise
from observer_lab.engine.systems import root, settled_covariance

from .filters import ADC, UNTESTED_SAMPLES, independent_samples, tuned, watcher
from .knobs import CARRIED, SAMPLE_COUNT, WHITE

LAGS, WHITENESS_PROBABILITY = 20, 1 - 0.05 / 3  # of the test of whiteness in `innovation_test`
TESTED_SAMPLES = SAMPLE_COUNT - UNTESTED_SAMPLES
SELDOM = 0.1  # share of the records that may be flagged and still count as left alone


@dataclass(frozen=True)
class Expected:
    """Means of NIS and NEES over all records, with the bands that one record is judged by.

    flagged: share of the records whose innovations the test of whiteness finds coloured, by a noncentral χ².
    memory: correlation of neighbouring innovations of VL. over_R, S_over_R: variance of the innovation of VL, and what the
    filter says of it, over its R.
    """

    nis: float
    nis_band: tuple[float, float]
    nees: float
    nees_band: tuple[float, float]
    flagged: float
    memory: float
    over_R: float
    S_over_R: float

    @property
    def nis_holds(self) -> bool:
        """Whether the mean of NIS lies in the band of one record."""
        return self.nis_band[0] <= self.nis <= self.nis_band[1]

    @property
    def nees_holds(self) -> bool:
        """Whether the mean of NEES does."""
        return self.nees_band[0] <= self.nees <= self.nees_band[1]

    @property
    def right(self) -> bool:
        """Whether no test finds the filter out over all records, whatever one of them says."""
        return self.nis_holds and self.nees_holds and self.flagged <= SELDOM

    @property
    def away(self) -> float:
        """How far the worst of the means lies from where it belongs, in half bands: below 1 the filter is right."""
        nis, nees = (2 * abs(mean - sum(band) / 2) / (band[1] - band[0])
                     for mean, band in ((self.nis, self.nis_band), (self.nees, self.nees_band)))
        return float(np.nextafter(1.0, 0.0)) if self.right and max(nis, nees) == 1 else max(nis, nees, self.flagged / SELDOM)


@lru_cache(maxsize=32)
def expected(noise: str, q: float, r: float) -> Expected:
    """Statistics once the filter has settled: the Lyapunov equation of truth and error together.

    Truth z⁺ = A z + w, y = C z + v, z the deck and, for the converter, its noise states. The filter knows S z. With
    e = S z − x̂⁻ and what it leaves out of y, D = C − C_f S: ν = D z + C_f e + v, and S A = A_f S makes
    e⁺ = A_f (I − M C_f) e − A_f M (D z + v) + S w.
    """
    who, real = watcher(noise, q, r, 1.0), tuned() if noise == WHITE else with_coloured_noise(tuned(), ADC)
    kf, M, n, k = who.filter, who.steady.filter_gain, real.n, who.filter.n
    S = np.eye(k) if noise == CARRIED else np.eye(k, n)
    D, keep = real.C - kf.C @ S, np.eye(k) - M @ kf.C
    A = np.block([[real.A, np.zeros((n, k))], [-kf.A @ M @ D, kf.A @ keep]])
    w, v = np.vstack([np.eye(n), S]), np.vstack([np.zeros((n, 4)), -kf.A @ M])
    Z = settled_covariance(A, np.hstack([w @ root(real.Q), v @ root(real.R)]), dt=1.0)
    H, after = np.hstack([D, kf.C]), np.hstack([-M @ D, keep])
    seen = H @ Z @ H.T + real.R
    error = (after @ Z @ after.T + M @ real.R @ M.T)[:6, :6]
    promised = kf.C @ who.steady.solution @ kf.C.T + kf.R
    excess, memory = _colour(A, H, A @ Z @ H.T + v @ real.R, seen)
    dof = 16 * LAGS
    return Expected(
        float(np.trace(np.linalg.solve(promised, seen))), chi2_band(4, count=TESTED_SAMPLES, level=WHITENESS_PROBABILITY),
        float(np.trace(np.linalg.solve(who.steady.filtered[:6, :6], error))), chi2_band(6, count=independent_samples(who.filter)),
        1.0 - float(chndtr(chdtri(dof, 1.0 - WHITENESS_PROBABILITY), dof, max(excess, 1e-9))), memory, float(seen[0, 0] / kf.R[0, 0]),
        float(promised[0, 0] / kf.R[0, 0]))


def _colour(A: np.ndarray, H: np.ndarray, cross: np.ndarray, seen: np.ndarray) -> tuple[float, float]:
    """Noncentrality N² Σ (N − l)⁻¹ (1 − l/N)² tr(C_lᵀ C₀⁻¹ C_l C₀⁻¹), and the correlation of VL at lag 1; C_l = H A^(l−1) cross."""
    inverse, excess, first = np.linalg.inv(seen), 0.0, 0.0
    for lag in range(1, LAGS + 1):
        C = H @ cross
        first = first if lag > 1 else float(C[0, 0] / seen[0, 0])
        excess += (TESTED_SAMPLES - lag) * float(np.trace(C.T @ inverse @ C @ inverse))
        cross = A @ cross
    return excess, first
