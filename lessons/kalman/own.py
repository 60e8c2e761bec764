"""The Kalman filter on a person's own plant: one step at a time, its gain, its innovations, and what it believes wrongly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from app.engine import chi2_band, innovation_test, nees, nis
from app.engine.filters import FilterTrial, InnovationTest, SquaredError, simulate_filter
from app.lesson.figures import Curve, Figure, LineFigure, PlaneFigure, TableFigure
from app.lesson.knobs import Choice, Knob, KnobError, Number
from app.lesson.lesson import Check, Design, Formula, Job, Lesson, Outcome, Stage
from app.plants import Model, Signal
from app.plants.names import called, with_unit
from app.text import Text, same, symbol, text, text_in

from ..toolkit.figures import TIME_TAB
from ..toolkit.gains import noise_units
from ..toolkit.knobs import run_knobs
from ..toolkit.latex import gain_words, number
from .figures import GAIN_TAB, INNOVATION_TAB, STEP_TAB, TEST_TAB
from .job import RUNS
from .knobs import PREDICT, UPDATE
from .study import Trials

SAMPLES, SKIP, LAST = 160, 40, 60
MOST_STATES = 10  # rows of the table of one step
AT_ONCE = 2


@dataclass(frozen=True, eq=False)
class Study:
    """One record through one filter, and what judges it."""

    found: FilterTrial
    test: InnovationTest
    settled: SquaredError
    nis: np.ndarray
    nees: np.ndarray
    trials: Trials | None = None


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """Beliefs, true noises in the plant's own measures, and the step to look at."""
    return (
        Number("q", "q", text("believed Q / true Q"), low=0.01, high=100.0, default=0.05, scale="log",
               hint=text("Below 1 the filter trusts its model too much.")),
        Number("r", "r", text("believed R / true R"), low=0.01, high=100.0, default=1.0, scale="log",
               hint=text("Below 1 the filter trusts its sensors too much.")),
        Number("w", r"\sigma_w", text("process noise, share of the natural input"), low=1e-3, high=10.0,
               default=0.1, scale="log", hint=text("How strongly an unknown input shakes the plant.")),
        Number("v", r"\sigma_v", text("sensor noise, share of the outputs"), low=1e-4, high=1.0,
               default=0.003,
               scale="log", hint=text("As a share of the outputs at the start.")),
        Number("k", "k", text("sample to look at"), low=1, high=LAST, default=1, scale="integer",
               hint=text("The tab One step shows this sample.")),
        Choice("phase", "", text("the step"), default=PREDICT,
               options=((PREDICT, text("predict")), (UPDATE, text("predict and update"))),
               hint=text("Before or after the sample is taken in.")),
        *run_knobs(model.horizon),
    )


def tried(model: Model, design: Design, seed: int) -> FilterTrial:
    """The filter of a design on the record of a seed. Raises EngineError where there is no filter."""
    G, W, V = noise_units(model)
    kick = (design["kick"], np.array(model.kick)) if design["kick"] >= 0 else None
    found = simulate_filter(model.plant, G, design["w"] ** 2 * W, design["v"] ** 2 * V, model.horizon / SAMPLES,
                            SAMPLES,
                         believed=(design["q"], design["r"]), seed=seed, kick=kick)
    if len(found.run.t) < 2 * SKIP:
        raise KnobError(text("The plant runs away before the filter can be judged."))
    return found


def compute(model: Model, design: Design) -> Outcome[Study]:
    """The record filtered and judged."""
    study = _judged(tried(model, design, int(design["seed"])))
    found, p, n = study.found, model.plant.p, model.plant.n
    metrics = {
        "nis_mean": study.test.nis.mean, "nis_expected": found.expected, "nees_mean": study.settled.mean,
        "white_p": study.test.whiteness.p_value, "gain_gap": float(found.distance[-1]), "riccati_residual": found.steady.residual}
    failed = study.test.failures
    checks = (
        Check("centred", text("innovations have no bias"), "biased" not in failed, study.test.bias_p_value),
        Check("white", text("innovations are white"), "coloured" not in failed, metrics["white_p"]),
        Check("nis", text("NIS lies in its band"), study.test.nis.verdict == "consistent", metrics["nis_mean"]),
        Check("nees", text("NEES lies in its band"), study.settled.verdict == "consistent", metrics["nees_mean"]),
        Check("riccati", text("the gain has reached the Riccati solution"), metrics["gain_gap"] < 1e-3,
              metrics["gain_gap"]))
    k, at = int(design["k"]), int(found.track.schedule.index[int(design["k"])])
    formulas = [Formula("M", gain_words(rf"M_{{{k}}}", found.track.schedule.gains[at]))]
    if design["phase"] == UPDATE:
        formulas.append(Formula("nis", rf"\mathrm{{NIS}}_{{{k}}} = \nu^{{\mathsf T}} S^{{-1}} \nu = {number(float(study.nis[k]))}"))
    live = text("NIS {nis_mean:.3g} in this record, {expected:.3g} on average ({p} expected); NEES "
                "{nees_mean:.3g} ({n} expected).",
                nis_mean=metrics["nis_mean"], expected=found.expected, p=p, nees_mean=metrics["nees_mean"], n=n)
    stage = Stage(model.body, found.run.t, found.run.x, found.track.means, found.run.u_applied)
    poles = np.log(np.where(np.abs(found.steady.poles) > 1e-12, found.steady.poles, 1e-12)) * SAMPLES / model.horizon
    return Outcome(design, {"M": found.track.schedule.gains[-1], "M_riccati": found.steady.filter_gain}, {"filter": poles}, metrics, checks,
                   None, (), stage, tuple(formulas), live, study)


def _judged(found: FilterTrial) -> Study:
    track, x = found.track, found.run.x
    P, S = track.covariances, track.S
    tests = innovation_test(track.innovations[SKIP:], S[SKIP:])
    settled, first = nees(x[SKIP:], track.means[SKIP:], _solid(P[SKIP:])), nees(x[:SKIP], track.means[:SKIP], _solid(P[:SKIP]))
    early = nis(track.innovations[:SKIP], S[:SKIP])
    return Study(found, tests, settled, np.concatenate([early.values, tests.nis.values]), np.concatenate([first.values, settled.values]))


def _solid(P: np.ndarray) -> np.ndarray:
    """Covariances with a floor of 1e-9 of each variance: a state known exactly has no NEES."""
    spread = np.maximum(np.diagonal(P, axis1=1, axis2=2), 1e-300)
    return P + 1e-9 * spread[:, :, None] * np.eye(P.shape[1])


# --- figures -----------------------------------------------------------------------------------------------------------
def figures(model: Model, outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """One step; two signals; the gain; innovations; consistency."""
    second = next((s for s in model.watched if s.name("en").startswith("state")), model.watched[-1])
    return (_step(model, outcome), _state(outcome, "height", model.watched[0]), _state(outcome, "pitch", second), _gain(outcome),
            _distance(outcome), _innovation(model, outcome), _correlation(model, outcome),
            _squares(outcome, "nis", text("NIS of a sample"), model.plant.p, 0),
            _squares(outcome, "nees", text("NEES of the states"), model.plant.n, 1),
            _tests(outcome))


def _step(model: Model, outcome: Outcome[Study]) -> TableFigure:
    study, k, plant = outcome.study, int(outcome.design["k"]), model.plant
    track, updated = study.found.track, outcome.design["phase"] == UPDATE
    at = int(track.schedule.index[k])
    mean, P = (track.means[k], track.schedule.posterior[at]) if updated else (track.predicted[k], track.schedule.prior[at])

    def digits(value: float) -> str:
        return f"{value:.4g}".replace("-", "−")
    rows = tuple((with_unit(plant, name), digits(study.found.run.x[k, i]), digits(mean[i]),
                  digits(float(np.sqrt(max(P[i, i], 0.0))))) for i, name in enumerate(plant.state_names[:MOST_STATES]))
    return TableFigure("step", text("sample {k}", k=k),
                       (text("state"), text("true"), text("estimate"), same("σ")), rows, tab=STEP_TAB,
                       caption=text("t = {t:.3g} s, {updated} the sample is taken in; its NIS {nis:.3g}.",
                                    t=study.found.run.t[k], updated=text("after") if updated else text("before"),
                                    nis=study.nis[k]))


def _state(outcome: Outcome[Study], name: str, signal: Signal) -> LineFigure:
    found, row = outcome.study.found, np.array(signal.weights)
    true, mean = signal.of(found.run.x), signal.of(found.track.means)
    spread = 2 * np.sqrt(np.maximum(np.einsum("i,kij,j->k", row, found.track.covariances, row), 0.0))
    inside = 100 * float(np.mean(np.abs(true - mean)[SKIP:] <= spread[SKIP:] + 1e-300))
    return LineFigure(name, signal.name, found.run.t, (
        Curve(text("true"), true), Curve(text("estimate"), mean, "estimate", "dash"),
        Curve(same("+ 2σ"), mean + spread, "muted", "dot", 1.2), Curve(same("− 2σ"), mean - spread, "muted", "dot", 1.2)),
        f"[{signal.unit}]", tab=TIME_TAB, caption=text(
            "Once settled, the truth is within the filter's own 2σ for {inside:.0f} % of the time; 95 % are "
            "expected.",
            inside=inside))


def _gain(outcome: Outcome[Study]) -> LineFigure:
    found = outcome.study.found
    M, goal, count = found.track.gains, found.steady.filter_gain, min(len(found.run.t), 80)
    largest = np.argsort(np.abs(goal).ravel())[::-1][:3]
    curves = []
    for place, role in zip(largest, ("estimate", "force", "second"), strict=False):
        i, j = divmod(int(place), goal.shape[1])
        curves += [Curve(same(symbol(f"M{i + 1}{j + 1}")), M[:count, i, j], role),
                   Curve(same(symbol(f"M{i + 1}{j + 1}") + " ∞"), np.full(count, goal[i, j]), "reference", "dot", 1.2)]
    return LineFigure("gain", text("largest entries of the gain M"), found.run.t[:count], tuple(curves),
                      "M", tab=GAIN_TAB,
                      caption=text("Dotted: the gain that the Riccati equation promises for ever."))


def _distance(outcome: Outcome[Study]) -> LineFigure:
    found = outcome.study.found
    late = np.flatnonzero(found.distance > 0.01)
    after, left = f"{found.run.t[min(late[-1] + 1, len(found.run.t) - 1)]:.3g}" if len(late) else "0", 100 * float(found.distance[-1])
    return LineFigure("distance", text("distance to the Riccati gain"), found.run.t,
                      (Curve(text("relative distance"), np.maximum(found.distance, 1e-12), "error"),),
                      "‖M − M∞‖ / ‖M∞‖", log_y=True,
                      window=(1e-10, 1.0), tab=GAIN_TAB,
                      caption=text("Within 1 % after {after} s. No reading has any part in this.", after=after) if left <= 1 else
                      text("At the end still {left:.2g} % away. No reading has any part in this.", left=left))


def _innovation(model: Model, outcome: Outcome[Study]) -> LineFigure:
    found, name = outcome.study.found, model.plant.output_names[0]
    nu, spread = found.track.innovations[:, 0], 2 * np.sqrt(found.track.S[:, 0, 0])
    inside = 100 * float(np.mean(np.abs(nu[SKIP:]) <= spread[SKIP:]))
    return LineFigure("innovation", text("innovation of {name}", name=called(model.plant, name)), found.run.t, (
        Curve(same("ν"), nu, "error", width=1.4), Curve(same("+ 2√S"), spread, "muted", "dot", 1.4),
        Curve(same("− 2√S"), -spread, "muted", "dot", 1.4)), f"ν [{model.plant.unit(name)}]", tab=INNOVATION_TAB,
        caption=text("Once settled, {inside:.0f} % within 2√S.", inside=inside))


def _correlation(model: Model, outcome: Outcome[Study]) -> PlaneFigure:
    w = outcome.study.test.whiteness
    lags = np.arange(1, len(w.correlation) + 1, dtype=float)
    roles, ends = ("estimate", "second", "disturbance", "plant"), np.array([lags[0], lags[-1]])
    curves = [Curve(called(model.plant, name), w.correlation[:, i], roles[i % 4], "solid", 1.8, lags)
              for i, name in enumerate(model.plant.output_names[:4])]
    curves += [Curve(text("band"), np.full(2, sign * w.band), "reference", "dot", 1.2, ends) for sign in (1, -1)]
    said = (text("White as far as one can tell: p = {p_value:.2g}.", p_value=w.p_value) if w.white else
            text("Coloured: p = {p_value:.1e}; each sample foretells the next.", p_value=w.p_value))
    return PlaneFigure("correlation", text("autocorrelation of the innovations"), tuple(curves), (),
                       text("lag [samples]"), "r", (0.0, float(lags[-1] + 1)), (-0.6, 1.0), caption=said, tab=INNOVATION_TAB)


def _squares(outcome: Outcome[Study], name: str, title: Text, dof: int, which: int) -> LineFigure:
    study = outcome.study
    trials = study.trials
    count, shown = ((1, (study.nis, study.nees)[which]) if trials is None else
                    (trials.count, (trials.nis, trials.nees)[which]))
    t, (low, high) = study.found.run.t[:len(shown)], chi2_band(dof, count=count)
    inside = 100 * float(np.mean((shown[SKIP:] >= low) & (shown[SKIP:] <= high)))
    who = text("One run") if trials is None else text("Mean of {count} runs", count=count)
    whose = text("one run") if trials is None else text("mean of {count} runs", count=count)
    n = len(t)
    return LineFigure(name, title, t, (
        Curve(whose, np.maximum(shown, 1e-4), "error", width=1.4),
        Curve(text("expected, {dof}", dof=dof), np.full(n, float(dof)), "reference", "dash", 1.4),
        Curve(text("95 % band"), np.full(n, high), "muted", "dot", 1.4),
        Curve(text("lower edge"), np.full(n, low), "muted", "dot", 1.4)), name.upper(), log_y=True, window=(0.05 * dof, 20.0 * dof),
        tab=TEST_TAB,
        caption=text("{who}: once settled, {inside:.0f} % of the samples lie in the χ² band [{low:.3g}, "
                     "{high:.3g}].",
                     who=who, inside=inside, low=low, high=high))


def _tests(outcome: Outcome[Study]) -> TableFigure:
    study, held = outcome.study, {c.id: c.holds for c in outcome.checks}

    def verdict(name: str) -> Text:
        return text("passes") if held[name] else text("flagged")
    bands = [f"{s.mean_band[0]:.3g} … {s.mean_band[1]:.3g}" for s in (study.test.nis, study.settled)]
    rows = ((text("mean of NIS"), f"{study.test.nis.mean:.3g}", bands[0], verdict("nis")),
            (text("mean of NEES"), f"{study.settled.mean:.3g}", bands[1], verdict("nees")),
            (text("whiteness, p"), f"{study.test.whiteness.p_value:.2g}", "≥ 0.017", verdict("white")),
            (text("bias, p"), f"{study.test.bias_p_value:.2g}", "≥ 0.017", verdict("centred")))
    return TableFigure("tests", text("tests of this record, once settled"),
                       (text_in("kalman", "test"), text("value"), text("band"), text("verdict")), rows,
                       tab=TEST_TAB, caption=text("Each test flags a right filter in a few records of a hundred."))


def try_often(model: Model, outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """The job: the same filter on many records; NIS and NEES averaged at each sample."""
    study, design = outcome.study, outcome.design
    sums = np.zeros((2, len(study.nis)))
    for count, seed in enumerate(np.random.SeedSequence(int(design["seed"])).generate_state(RUNS), start=1):
        other = _judged(tried(model, design, int(seed)))
        shared = min(sums.shape[1], len(other.nis))
        sums = sums[:, :shared] + np.vstack([other.nis[:shared], other.nees[:shared]])
        if count % AT_ONCE == 0:
            yield count / RUNS, Trials(count, sums[0] / count, sums[1] / count)


def shown(outcome: Outcome[Study], trials: Trials) -> Outcome[Study]:
    """The outcome with what the records showed."""
    return replace(outcome, study=replace(outcome.study, trials=trials))


def key(design: Design) -> Design:
    """What the records rest on: all but the sample that is looked at."""
    return design.with_values(k=1, phase=PREDICT)


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, where a Kalman filter for it exists; report and converter stay with the deck."""
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, model), figures=partial(figures, model), tasks=(),
                   job=Job(text("Try {runs} runs", runs=RUNS), partial(try_often, model), key, shown, figure="nees", follows=True))
