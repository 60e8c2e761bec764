"""Compute what lesson 9 has on the deck alone: its records and its stage."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Design, Formula, Stage
from observer_lab.plants.bodies.deck_body import MOTION_GAIN
from observer_lab.plants.bodies.deck_body import STAGE_SCALE as SCALE_OF_STAGE
from observer_lab.text import Text, joined, listed, same, text

from ..toolkit.latex import matrix, number
from .all_records import expected
from .body import STATE_COUNT, VELOCITY_INDEX, body_of, ellipsoids, error_record
from .data_sheet import MM, STATE_LABELS
from .filters import Forms, compare, draw, truth, tuned, watch, watcher
from .knobs import ERRORS, GAIN, MODEL, SINGLE, UPDATE, VZ_INDEX, WHITE
from .one_number import one_reading
from .study import Look, Study, failures_of

MOST_GAIN = 1e3  # times the steady gain, the largest that is written


@dataclass(frozen=True, eq=False)
class DeckStudy(Study):
    """A record of the deck; `asked` says what two forms of the update are compared on: q, r, p0, and whether in single precision."""

    asked: tuple[float, float, float, bool]

    @property
    def over_R(self) -> tuple[float, float]:
        """The variance of the innovation of VL over R: what the filter says, and what is seen."""
        quiet = self.watcher.filter.R[0, 0]
        return (float(self.watcher.schedule.S[-1][0, 0] / quiet),
                float(np.var(self.track.innovations[self.watcher.first:, 0]) / quiet))

    def covariances_at(self, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """P(k−1), P⁻(k) and P(k)."""
        plan = self.watcher.schedule
        return plan.posterior[int(plan.index[k - 1])], plan.prior[int(plan.index[k])], plan.posterior[int(plan.index[k])]

    @cached_property
    def forms(self) -> Forms:
        """Joseph's form beside the short one."""
        return compare(*self.asked)


def studied(design: Design, seed: int) -> DeckStudy:
    """The deck with the noise of a seed, the filter with its beliefs, the record filtered; the record of the design itself is kept."""
    what = (truth if seed == design["seed"] else draw)(seed, design["noise"] != WHITE, design["force"], design["kick"])
    who = watcher(design["noise"], design["q"], design["r"], design["p0"])
    return DeckStudy(what, who, watch(who, what), (design["q"], design["r"], design["p0"], design["arithmetic"] == SINGLE))


def stage(design: Design, s: DeckStudy) -> Stage:
    """The deck and its ghost over time, and above them the step that is looked at, the errors or the gain."""
    updated, above, settled = design["phase"] == UPDATE, design["above"], tuned().steady.solution
    if above == ERRORS:
        tail = error_record((s.truth.x - s.means)[:, :STATE_COUNT], s.watcher.steady.filtered[:STATE_COUNT, :STATE_COUNT], settled,
                            s.watcher.first)
    elif above == GAIN:
        tail = np.minimum(gain_sizes(s), MOST_GAIN)[:, None]
    else:
        last, prior, posterior = s.covariances_at(int(design["k"]))
        tail = np.tile(ellipsoids(last, prior, posterior if updated else None, settled), (len(s.truth.t), 1))
    shown = [np.hstack([x[:, :STATE_COUNT], tail]) for x in (s.truth.x, s.means)]
    spread = None if above == GAIN else 3 * SCALE_OF_STAGE * MOTION_GAIN * np.sqrt(s.track.variances[:, 1])
    return Stage(body_of(above, updated), s.truth.t, shown[0], shown[1], s.truth.u, spread)


def gain_sizes(s: DeckStudy) -> np.ndarray:
    """‖M‖ of the deck's states at each sample (n_t,), over that of the steady gain for the right Q and R."""
    return np.asarray(np.linalg.norm(s.track.gains[:, :STATE_COUNT], axis=(1, 2)) / np.linalg.norm(tuned().steady.filter_gain))


def rms_over_stated(s: DeckStudy) -> float:
    """The RMS of the errors of the velocities once the filter has settled, over the σ that it then states."""
    index, steady = list(VELOCITY_INDEX), s.watcher.steady.filtered
    e = (s.truth.x - s.means)[s.watcher.first:, index]
    return float(np.sqrt(np.mean(np.sum(e * np.linalg.solve(steady[np.ix_(index, index)], e.T).T, axis=1)) / len(index)))


def numbers(design: Design, s: DeckStudy) -> dict[str, float]:
    """Ends of the bands, R beside S, two forms of the update, one step and one reading."""
    _, *both = s.covariances_at(int(design["k"]))
    sigma_prior, sigma_after = (1e3 * float(np.sqrt(P[VZ_INDEX, VZ_INDEX])) for P in both)
    return {
        "nis_low": s.test.nis.mean_band[0], "nis_high": s.test.nis.mean_band[1],
        "nees_low": s.settled.mean_band[0], "nees_high": s.settled.mean_band[1],
        "bias_p": s.test.bias_p_value, "failures": float(len(s.test.failures)),
        "S_over_R": s.over_R[0], "seen_over_R": s.over_R[1],
        "short_gap": float(s.forms.short.max()), "joseph_gap": float(s.forms.joseph.max()),
        "short_least": s.forms.least_short, "joseph_least": s.forms.least_joseph,
        "gain_times": float(gain_sizes(s)[-1]),
        "rms_times": rms_over_stated(s), "sigma_vz_prior": sigma_prior, "sigma_vz": sigma_after, **one_reading(design).metrics,
    }


def formulas(design: Design, s: DeckStudy) -> tuple[Formula, ...]:
    """The covariance of height and vertical speed through one step, and the NIS of its sample."""
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


def live(s: DeckStudy) -> Text:
    """Means of the record, and what its tests flag."""
    found = [words for name, words in WORDS if name in failures_of(s.test)]
    if s.settled.verdict != "consistent":
        large = s.settled.verdict == "overconfident"
        found.append(text("NEES too large") if large else text("NEES too small"))
    head = text("NIS {mean:.2f} (4 expected), NEES {mean2:.3g} (6 expected).",
                mean=s.test.nis.mean, mean2=s.settled.mean)
    tail = text("Flagged: {found}.", found=listed(found)) if found else text("Nothing is flagged.")
    return joined(head, tail)


def verdict(design: Design, quiet: bool) -> Text:
    """What the tests of one record mean: a right filter is flagged now and then, and a wrong one may pass."""
    away = expected(design["noise"], design["q"], design["r"]).away
    if quiet:
        return claim(text("No test flags this filter."), away, below=1.0, otherwise=text(
            "No test flags this record, yet over all records this filter is found out."))
    return claim(text("Flagged by chance: each test flags a right filter in a few records of a hundred."), away, below=1.0,
                 otherwise=text("Over all records, too, this filter is wrong about itself."))


ENTRIES = ((4, 0, "vz ← VL"), (3, 1, "vx ← HL"))
LOOK = Look(
    STATE_LABELS, MM, ".3f", (MODEL.watched[0], MODEL.watched[1]), [same(name) for name in MODEL.plant.output_names],
    (text("sensor VL"), "mm/s"), text("entries of the gain M"), lambda _: ENTRIES, 100,
    (text("NIS of a sample of four readings"), text("NEES, six states")),
    MappingProxyType({"height": (-10.0, 10.0), "pitch": (-10.0, 10.0), "gain": (-0.1, 0.6), "innovation": (-5.0, 5.0),
                      "nis": (0.1, 100.0), "nees": (0.1, 100.0)}), ".3f", verdict)
