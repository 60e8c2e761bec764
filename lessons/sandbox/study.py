"""Compute all analyses of a plant and a design, with one status line for each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal, cast

import numpy as np

from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Check, Design, Formula, Outcome
from observer_lab.engine import Scenario, closed_loop, simulate
from observer_lab.engine.feedback import ClosedLoop, Sensitivity
from observer_lab.engine.simulation import Run, separation_meter
from observer_lab.engine.structure import Mode
from observer_lab.plants import Model
from observer_lab.text import Text, format_number, listed, text

from ..toolkit.boards import pole_boards, stage
from ..toolkit.gains import gains
from ..toolkit.knobs import kicks
from ..toolkit.latex import gain_words, pole_words, tiny
from .analyses import Margins, Noise, Refusal, Structure, Trial, attempt, certificates, margins, noise, noises, structure, trial
from .number_bars import MARGIN_STATES, nis_over_expected, with_numbers
from .rank_columns import columns_of

RECOVERY_LEVELS = np.logspace(-3, 3, 9)  # of the recovery knob q, in natural units
POINTS = 140  # of the sensitivity over frequency
SAMPLED = text("Recovery is for continuous plants: a sampled loop keeps the delay of a step.")
Row = tuple[Text, bool | None, Text]
UNION_RTOL = 1e-6
MOST_ERROR, NIS_SHARE, LEAST_DISK = 1.5, 0.1, 0.5  # times the least error; share of the expected NIS; of a robust loop


@dataclass(frozen=True, eq=False)
class Study:
    """All that is asked, when it is looked at; each answer or the sentence why there is none. `steps` of recovery: (q, α, α with x
    known); `patient` the margins that were waited for."""

    model: Model
    design: Design
    run: Run
    K: np.ndarray
    L: np.ndarray
    loop: ClosedLoop
    steps: tuple[tuple[float, float, float], ...] = ()
    recovered: np.ndarray | None = None
    refused: Text | None = None
    patient: Margins | Refusal | None = None

    @cached_property
    def structure(self) -> Structure:
        """What no gain changes."""
        return structure(self.model.plant)

    @cached_property
    def certificates(self) -> tuple[tuple[Text, float], ...] | Refusal:
        """Residuals that theory says are zero."""
        return attempt(lambda: certificates(self.model.plant, self.loop, self.K, self.L))

    @cached_property
    def noise(self) -> Noise | Refusal:
        """The observer among Kalman filters."""
        return attempt(lambda: noise(self.model, self.L, self.design["sensor"]))

    @cached_property
    def trial(self) -> Trial | Refusal:
        """One record through a Kalman filter."""
        return attempt(lambda: trial(self.model, self.design["sensor"], self.design["belief"], int(self.design["seed"])))

    @cached_property
    def margins(self) -> Margins | Refusal:
        """Margins at the inputs."""
        return self.patient or attempt(lambda: margins(self.model.plant, self.K, self.L, False))

    @cached_property
    def meter(self) -> float:
        """How much the error is not its own."""
        return separation_meter(self.run)

    @cached_property
    def rows(self) -> tuple[Row, ...]:
        """One line for each answer."""
        return verdicts(self.structure, self.loop, self.meter, self.design["limited"], self.noise, self.trial, self.margins)


def compute(model: Model, design: Design) -> Outcome[Study]:
    """Gains and one run, which every plant has, and each analysis for itself."""
    plant, seed = model.plant, int(design["seed"])
    K, L = gains(design, plant, model)
    loop = closed_loop(plant, K, L)
    G, W, V = noises(model, design["sensor"])
    limit, noisy = (design["u_max"] if design["limited"] else None), design["noisy"]
    run = simulate(Scenario(
        plant, K, L, x0=model.x0, xhat0=model.guess, horizon=model.horizon, dt=model.dt, u_min=None if limit is None else -limit,
        u_max=limit, fed=cast(Literal["applied", "commanded"], design["fed"]), impulses=kicks(design, model), seed=seed,
        W=W if noisy else None, V=V if noisy else None, G=G if noisy else None))
    study = Study(model, design, run, K, L, loop, refused=SAMPLED if plant.dt else None)
    return Outcome(
        design, {"K": K, "L": L},
        {"controller": loop.controller_poles, "observer": loop.observer_poles, "loop": loop.poles, "compensator": loop.compensator_poles,
         "plant": plant.poles},
        LazyMap(lambda: _metrics(study, limit)), LazySequence(lambda: _checks(study.rows)), run,
        pole_boards(model, design, loop.controller_poles, loop.observer_poles, plant.A - L @ plant.C),
        with_numbers(stage(model, run, design), model, K, L, nis_over_expected(study.trial) if plant.n <= MARGIN_STATES else 0.0,
                     columns_of(study.structure.seen, design["tolerance"]) if design["columns"] else None),
        (Formula("K", gain_words("K", K)), Formula("L", gain_words(r"L^{\mathsf T}", L.T))),
        LazyValue(lambda: _live(study.rows)), study)


def _metrics(study: Study, limit: float | None) -> dict[str, float]:
    loop, run = study.loop, study.run
    clipped = float(np.mean(np.any(np.abs(run.u_asked) > (limit or np.inf) * (1 + 1e-9), axis=1)))
    metrics = {"separation_meter": study.meter, "clipped_share": clipped, "union_error": loop.union_error,
               "slowest_loop": _slowest(loop.poles, study.model.plant.dt), "largest_input": float(np.abs(run.u_asked).max())}
    if not isinstance(study.margins, Refusal):
        metrics["disk_margin"] = study.margins.together
    if not isinstance(study.trial, Refusal):
        metrics["nis_mean"], metrics["nis_expected"] = study.trial.test.mean, study.trial.expected
        metrics["nis_share"] = study.trial.test.mean / study.trial.test.dof
    return metrics


def _checks(rows: tuple[Row, ...]) -> tuple[Check, ...]:
    return tuple(Check(f"row{i}", text("{name}: {said}", name=name, said=said), holds)
                 for i, (name, holds, said) in enumerate(rows) if holds is not None)


def _slowest(poles: np.ndarray, dt: float) -> float:
    return float(np.abs(poles).max() - 1) if dt else float(np.real(poles).max())


def _live(rows: tuple[tuple[Text, bool | None, Text], ...]) -> Text:
    no = [name for name, holds, _ in rows if holds is False]
    if not no:
        return text("All applicable checks pass.")
    return text("Not satisfied: {names}.", names=listed(no))


@lru_cache(maxsize=64)
def frequencies(plant_rate: float, dt: float) -> np.ndarray:
    """Hz, two decades around the plant's own pace, below half the sampling rate."""
    middle = plant_rate / (2 * np.pi)
    high = min(100 * middle, 0.499 / dt) if dt else 100 * middle
    return np.geomspace(min(middle / 100, high / 100), high, POINTS)


def largest(loop: Sensitivity, grid: np.ndarray) -> np.ndarray:
    """σ_max of the block of S at the inputs, over frequencies in Hz."""
    m = loop.inputs
    S = loop.at(2 * np.pi * grid)[:, :m, :m]
    values = np.abs(S[:, 0, 0]) if m == 1 else np.linalg.svd(S, compute_uv=False)[:, 0]
    return np.clip(np.nan_to_num(values, nan=1.0, posinf=1e6), 1e-6, 1e6)


def verdicts(found: Structure, loop: ClosedLoop, meter: float, limited: bool, noise: Noise | Refusal, trial: Trial | Refusal,
             margins: Margins | Refusal) -> tuple[Row, ...]:
    """All rows, in the order of the lessons."""
    return (*_structure(found), *_loop(loop, meter, limited), _noise(noise), _trial(trial), _margins(margins))


def _weakest(modes: tuple[Mode, ...], hidden: tuple[complex, ...]) -> Text:
    if hidden:
        words = pole_words([p for p in hidden if p.imag >= 0][:4])
        return text("{count} hidden: {words}", count=len(hidden), words=words)
    d = min(mode.distance for mode in modes)
    return text("nearest mode {d:.2g} from hidden", d=d)


def _structure(found: Structure) -> tuple[Row, ...]:
    names = ((text("observable"), text("detectable")), (text("controllable"), text(
        "stabilizable")))
    rows: list[Row] = []
    for report, (strong, weak), fixed, good in ((found.seen, names[0], "unobservable", "detectable"),
                                                (found.reached, names[1], "uncontrollable", "stabilizable")):
        if isinstance(report, Refusal):
            rows += [(strong, None, report.text), (weak, None, report.text)]
            continue
        hidden = getattr(report, fixed)
        loose = [p for p, m in zip(hidden, [m for m in report.modes if not m.visible], strict=False) if not m.stable]
        rows += [(strong, not hidden, _weakest(report.modes, hidden)),
                 (weak, getattr(report, good), text("nothing is hidden") if not hidden else
                  text("what is hidden settles") if not loose else
                  text("{count} hidden and not settling", count=len(loose)))]
    d = found.decomposition
    if isinstance(d, Refusal):
        rows.append((text("minimal"), None, d.text))
    else:
        n, both = sum(d.sizes), d.sizes[0]
        rows.append((text("minimal"), both == n, text(
            "states that act from u to y: {both} of {n}", both=both, n=n)))
    return tuple(rows)


def _loop(loop: ClosedLoop, meter: float, limited: bool) -> tuple[Row, ...]:
    error = min(loop.union_error, loop.polynomial_error)
    meter_now = "0" if meter < 1e-8 else format_number(meter, ".2g")
    said = text("meter {meter} with the limit on", meter=meter_now) if limited else text("meter {meter}", meter=meter_now)
    return (
        (text("loop stable"), loop.stable, text("{count} poles", count=len(loop.poles))),
        (text("separation of the poles"), error < UNION_RTOL, text(
            "off the union by {error}", error=tiny(error))),
        (text("error dynamics autonomous"), meter < UNION_RTOL, said),
        (text("compensator stable by itself"), loop.compensator_stable,
         text("{count} poles of its own", count=len(loop.compensator_poles))),
    )


def times_the_least(found: Noise | Refusal) -> float | Refusal:
    """The size of the observer's error, over the least that a Kalman filter of the ladder leaves."""
    if isinstance(found, Refusal):
        return found
    if isinstance(found.ours, Refusal):
        return found.ours

    def size(P: np.ndarray) -> float:
        return float(np.sqrt(np.mean(np.diag(P) / found.unit**2)))
    return size(found.ours.total) / max(min(size(p.total) for p in found.ladder.parts), 1e-300)


def _noise(found: Noise | Refusal) -> Row:
    name = text("observer near the Kalman filter")
    ratio = times_the_least(found)
    if isinstance(ratio, Refusal):
        return name, None, ratio.text
    return name, ratio < MOST_ERROR, text("error {ratio:.3g} times the least", ratio=ratio)


def _trial(found: Trial | Refusal) -> Row:
    name = text("Kalman filter consistent")
    if isinstance(found, Refusal):
        return name, None, found.text
    p = found.test.dof
    return name, abs(found.expected / p - 1) < NIS_SHARE, text(
        "NIS {expected:.3g} on average, {p} expected",
        expected=found.expected, p=p)


def _margins(found: Margins | Refusal) -> Row:
    name = text("robust at the inputs (α ≥ 0.5)")
    if isinstance(found, Refusal):
        return name, None, found.text
    return name, found.together >= LEAST_DISK, text("disk margin {together:.3g}", together=found.together)
