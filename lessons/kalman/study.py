"""Compute a design of lesson 9: one filtered record, its tests, and averages over records."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.special import chdtri, chndtr

from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine import chi2_band, innovation_test, nees, nis
from observer_lab.engine.filters import InnovationTest, SquaredError, Track, with_coloured_noise
from observer_lab.engine.systems import root, settled_covariance
from observer_lab.plants.bodies.deck_body import MOTION_GAIN
from observer_lab.plants.bodies.deck_body import STAGE_SCALE as SCALE_OF_STAGE
from observer_lab.text import Text, joined, listed, text

from ..toolkit.latex import matrix, number
from .body import DECK_BODY, STATE_COUNT, ellipsoids
from .filters import ADC, UNTESTED_SAMPLES, Forms, Truth, Watcher, compare, truth, tuned, watch, watcher
from .knobs import CARRIED, DT, SAMPLE_COUNT, SINGLE, UPDATE, WHITE
from .one_number import one_reading

VZ_INDEX = 4  # of v_z in the state


@dataclass(frozen=True, eq=False)
class Trials:
    """Means over `count` runs of NIS and NEES at each sample (n_t,)."""

    count: int
    nis: np.ndarray
    nees: np.ndarray


@dataclass(frozen=True, eq=False)
class Study:
    """One record through one filter, and all that judges it, found when it is looked at. `nis` and `nees` are of the whole record;
    `asked` says what two forms of the update are compared on: q, r, p0, and whether in single precision."""

    truth: Truth
    watcher: Watcher
    track: Track
    asked: tuple[float, float, float, bool]
    trials: Trials | None = None

    @cached_property
    def test(self) -> InnovationTest:
        """Of the innovations once the filter has settled."""
        return innovation_test(self.track.innovations[UNTESTED_SAMPLES:], self.track.S[UNTESTED_SAMPLES:])

    @cached_property
    def settled(self) -> SquaredError:
        """NEES once the filter has settled."""
        return nees(
            self.truth.x[UNTESTED_SAMPLES:],
            self.track.means[UNTESTED_SAMPLES:, :6],
            self.track.covariances[UNTESTED_SAMPLES:, :6, :6],
            independent=self.watcher.independent,
        )

    @cached_property
    def nis(self) -> np.ndarray:
        """νᵀ S⁻¹ ν at every sample."""
        return nis(self.track.innovations, self.track.S).values

    @cached_property
    def nees(self) -> np.ndarray:
        """eᵀ P⁻¹ e at every sample."""
        first = nees(
            self.truth.x[:UNTESTED_SAMPLES], self.track.means[:UNTESTED_SAMPLES, :6], self.track.covariances[:UNTESTED_SAMPLES, :6, :6]
        )
        return np.concatenate([first.values, self.settled.values])

    @property
    def over_R(self) -> tuple[float, float]:
        """The variance of the innovation of VL over R: what the filter says, and what is seen."""
        quiet = self.watcher.filter.R[0, 0]
        return (float(self.watcher.schedule.S[-1][0, 0] / quiet), float(np.var(self.track.innovations[UNTESTED_SAMPLES:, 0]) / quiet))

    def covariances_at(self, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """P(k−1), P⁻(k) and P(k)."""
        plan = self.watcher.schedule
        return plan.posterior[int(plan.index[k - 1])], plan.prior[int(plan.index[k])], plan.posterior[int(plan.index[k])]

    @cached_property
    def forms(self) -> Forms:
        """Joseph's form beside the short one."""
        return compare(*self.asked)


def compute(design: Design) -> Outcome[Study]:
    """The deck, the filter with its beliefs, the record filtered and judged."""
    what = truth(int(design["seed"]), design["noise"] != WHITE, design["force"], design["kick"])
    who = watcher(design["noise"], design["q"], design["r"], design["p0"])
    track = watch(who, what)
    study = Study(what, who, track, (design["q"], design["r"], design["p0"], design["arithmetic"] == SINGLE))
    metrics = LazyMap(lambda: _metrics(study, int(design["k"])) | one_reading(design).metrics)
    t = DT * np.arange(len(what.x))
    spread = 3 * SCALE_OF_STAGE * MOTION_GAIN * np.sqrt(track.variances[:, 1])
    return Outcome(design, {"M": track.schedule.gains[-1], "M_riccati": who.steady.filter_gain},
                   {"filter": np.log(who.steady.poles.astype(complex)) / DT}, metrics,
                   LazySequence(lambda: checks(study.test, study.settled, metrics["gain_gap"])), None, (),
                   _stage(design, study, t, spread), LazySequence(lambda: _formulas(design, study)),
                   LazyValue(lambda: _live(study)), study)


def _stage(design: Design, s: Study, t: np.ndarray, spread: np.ndarray) -> Stage:
    """The deck and its ghost over time; above them the ellipsoids of the step that is looked at."""
    last, prior, posterior = s.covariances_at(int(design["k"]))
    tail = np.tile(ellipsoids(last, prior, posterior if design["phase"] == UPDATE else None, tuned().steady.solution),
                   (len(t), 1))
    shown = [np.hstack([x[:, :STATE_COUNT], tail]) for x in (s.truth.x, s.track.means)]
    return Stage(DECK_BODY, t, shown[0], shown[1], s.truth.u, spread)


def _metrics(s: Study, k: int) -> dict[str, float]:
    M, last = s.watcher.steady.filter_gain, s.watcher.schedule.gains[-1]
    _, *both = s.covariances_at(k)
    sigma_prior, sigma_after = (1e3 * float(np.sqrt(P[VZ_INDEX, VZ_INDEX])) for P in both)
    return {
        "nis_mean": s.test.nis.mean, "nis_low": s.test.nis.mean_band[0], "nis_high": s.test.nis.mean_band[1],
        "nees_mean": s.settled.mean, "nees_low": s.settled.mean_band[0], "nees_high": s.settled.mean_band[1],
        "white_p": s.test.whiteness.p_value, "bias_p": s.test.bias_p_value, "failures": float(len(s.test.failures)),
        "gain_gap": float(np.abs(last - M).max() / np.abs(M).max()), "riccati_residual": s.watcher.steady.residual,
        "S_over_R": s.over_R[0], "seen_over_R": s.over_R[1],
        "short_gap": float(s.forms.short.max()), "joseph_gap": float(s.forms.joseph.max()),
        "short_least": s.forms.least_short, "joseph_least": s.forms.least_joseph,
        "sigma_vz_prior": sigma_prior, "sigma_vz": sigma_after,
    }


def holds(test: InnovationTest, settled: SquaredError) -> dict[str, bool]:
    """Which tests a record passes."""
    failed = failures_of(test)
    return {"centred": "biased" not in failed, "white": "coloured" not in failed, "nis": test.nis.verdict == "consistent",
            "nees": settled.verdict == "consistent"}


def failures_of(test: InnovationTest) -> tuple[str, ...]:
    """The tests that fail, without that of the bias where another fails: it takes innovations for white, of covariance S."""
    return test.failures if bias_is_judged(test) else tuple(name for name in test.failures if name != "biased")


def bias_is_judged(test: InnovationTest) -> bool:
    """Whether the innovations are white and of the size that the filter says, as the test of the mean assumes."""
    return not set(test.failures) - {"biased"}


def checks(test: InnovationTest, settled: SquaredError, gain_gap: float) -> tuple[Check, ...]:
    """The lights of a record: its tests, and whether the gain has come to rest."""
    held = holds(test, settled)
    return (
        Check("centred", text("innovations have no bias"), held["centred"], test.bias_p_value),
        Check("white", text("innovations are white"), held["white"], test.whiteness.p_value, informative=True),
        Check("nis", text("NIS lies in its band"), held["nis"], test.nis.mean),
        Check("nees", text("NEES lies in its band"), held["nees"], settled.mean, informative=True),
        Check("riccati", text("the gain has reached the Riccati solution"), gain_gap < 1e-3, gain_gap),
    )


def _formulas(design: Design, s: Study) -> tuple[Formula, ...]:
    k = int(design["k"])
    at = int(s.watcher.schedule.index[k])
    pick = np.ix_([1, 4], [1, 4])
    prior, after = (1e6 * P[at][pick] for P in (s.watcher.schedule.prior, s.watcher.schedule.posterior))
    out = [Formula("predict", rf"P_{{{k}|{k - 1}}}^{{(z,v_z)}} = {matrix(prior)}",
                   text("in mm², mm²/s, mm²/s²"))]
    if design["phase"] == UPDATE:
        S, M = s.watcher.schedule.S[at], s.watcher.schedule.gains[at]
        out += [Formula("S", rf"S_{{VL}} = {number(1e6 * S[0, 0])}, \quad R = {number(1e6 * s.watcher.filter.R[0, 0])}"),
                Formula("M", rf"M_{{v_z}} = {matrix(M[4:5])}"),
                Formula("update", rf"P_{{{k}|{k}}}^{{(z,v_z)}} = {matrix(after)}")]
    return (*out, Formula("nis", rf"\mathrm{{NIS}}_{{{k}}} = \nu^{{\mathsf T}} S^{{-1}} \nu = {number(float(s.nis[k]))}"))


WORDS = (("biased", text("a bias")), ("coloured", text("correlated innovations")),
         ("overconfident", text("NIS too large")), ("cautious", text("NIS too small")))


def _live(s: Study) -> Text:
    found = [words for name, words in WORDS if name in failures_of(s.test)]
    if s.settled.verdict != "consistent":
        large = s.settled.verdict == "overconfident"
        found.append(text("NEES too large") if large else text("NEES too small"))
    head = text("NIS {mean:.2f} (4 expected), NEES {mean2:.3g} (6 expected).",
                mean=s.test.nis.mean, mean2=s.settled.mean)
    tail = text("Flagged: {found}.", found=listed(found)) if found else text("Nothing is flagged.")
    return joined(head, tail)


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
        float(np.trace(np.linalg.solve(who.steady.filtered[:6, :6], error))), chi2_band(6, count=who.independent),
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
