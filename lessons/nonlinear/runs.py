"""Compute the runs of a design and the consistency of three filters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from observer_lab.course.lazy import LazyValue
from observer_lab.course.lesson import Design
from observer_lab.engine import EngineError, ExtendedKalmanFilter, NonlinearPlant, UnscentedKalmanFilter, chi2_band
from observer_lab.engine.filters import (
    Beliefs,
    Experiment,
    LinearisedFilter,
    NonlinearFilter,
    PrintedUnscentedFilter,
    Sample,
    Steering,
    errors_squared,
    simulate_filters,
)

from .cases import EKF, FALL_CASE, KF, PENDULUM_CASE, UKF, Case, case_of, flow_of, inputs_of, judged, plant_of, starts
from .cramer_rao import Bound, Slopes

FILTERS = (KF, EKF, UKF)
DRAFT_RUNS, JOB_RUNS = 8, 200
FALLEN = np.pi / 2  # rad: a pole past the horizontal has fallen, and its run is left out from there on
MAX_MEAN_SQUARE = 1e9  # of a mean square that is shown


@dataclass(frozen=True, eq=False)
class Judged:
    """Means over all runs of NEES and NIS (K,) at each sample, by filter.

    apart: greatest distance of EKF and UKF from the KF, in standard deviations of the KF. honest: share of the runs whose
    NEES at the last sample lies below the 99 % point of χ²: rare strays do not spoil it as they spoil a mean.
    """

    nees: Mapping[str, np.ndarray]
    nis: Mapping[str, np.ndarray]
    apart: Mapping[str, float]
    honest: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Study:
    """Run 0 in full, and means over all `runs` at each sample.

    t (K,); x (K, n), u (K, m) of run 0; means, sigmas (K, n), rms (K, 2) by filter, rms of the watched signals; `judged`:
    what the filters believe of their errors beside these, `limit`: what no filter could do better than, when they are looked at;
    lost: runs that a filter gave up; fallen: runs whose pole fell; upright (K,): runs that still count.
    """

    case: Case
    runs: int
    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    means: Mapping[str, np.ndarray]
    sigmas: Mapping[str, np.ndarray]
    judged: LazyValue[Judged]
    limit: LazyValue[Bound]
    rms: Mapping[str, np.ndarray]
    lost: Mapping[str, int]
    fallen: int
    upright: np.ndarray

    @property
    def nees(self) -> Mapping[str, np.ndarray]:
        """NEES by filter."""
        return self.judged.value.nees

    @property
    def nis(self) -> Mapping[str, np.ndarray]:
        """NIS by filter."""
        return self.judged.value.nis

    @property
    def apart(self) -> Mapping[str, float]:
        """Distances from the KF."""
        return self.judged.value.apart

    @property
    def honest(self) -> Mapping[str, float]:
        """Shares of the runs."""
        return self.judged.value.honest

    @property
    def bound(self) -> Bound:
        """What no filter could do better than."""
        return self.limit.value

    def ratio(self, name: str) -> float:
        """NEES of a filter over the record, as a multiple of the number of states; capped where it is beyond all sense."""
        return float(min(np.mean(self.nees[name]) / self.x.shape[1], MAX_MEAN_SQUARE))


def filters_of(case: Case, plant: NonlinearPlant, design: Design) -> dict[str, NonlinearFilter]:
    """The three filters on one flow: expanded once, at every estimate, and by sigma points."""
    flow = flow_of(case, plant)
    Q, R = design["wind"] * case.Q, design["sensor"]**2 * case.R
    points = UnscentedKalmanFilter if design["redraw"] else PrintedUnscentedFilter
    return {
        KF: LinearisedFilter(flow, plant.output, Q, R, case.guess, np.zeros(plant.m)),
        EKF: ExtendedKalmanFilter(flow, plant.output, Q, R, h_expand=plant.observe),
        UKF: points(flow, plant.output, Q, R, design["alpha"], design["beta"], design["kappa"]),
    }


def experiment_of(design: Design, runs: int, count: int, rng: np.random.Generator) -> tuple[Case, Experiment]:
    """The experiment of a design with its true starts drawn."""
    case = case_of(design["case"])
    plant = plant_of(case.id, design["hardening"], design["weakening"])
    filters = filters_of(case, plant, design)
    size, some = design["size"], filters[EKF]
    steering = (Steering(design["filter"], case.gain, case.u_max)
                if case.id == PENDULUM_CASE or (case.id != FALL_CASE and design["steer"]) else None)
    at = round(design["kick"] / case.step)
    kicks = ((at, case.kick),) if design["kick"] >= 0 and at < count else ()
    return case, Experiment(some.f, plant.output, some.Q, some.R, starts(case, size, runs, rng),
                            Beliefs.alike(case.guess, np.diag((size * case.spread)**2), runs),
                            inputs_of(case, count, design["force"]), filters, steering, kicks)


def draft(design: Design) -> Study:
    """A few runs over a short record."""
    case = case_of(design["case"])
    *_, last = studies(design, DRAFT_RUNS, case.draft, case.draft)
    assert last is not None
    return last


def studies(design: Design, runs: int, count: int, block: int) -> Iterator[Study | None]:
    """March `runs` runs over `count` samples; None between two blocks of samples, the study at the end."""
    rng = np.random.default_rng([int(design["seed"]), 14])
    case, experiment = experiment_of(design, runs, count, rng)
    tally = _Tally(case, experiment, runs, plant_of(case.id, design["hardening"], design["weakening"]))
    pending: list[Sample] = []
    for sample in simulate_filters(experiment, rng):
        if len(pending) == block:  # the last block waits to be judged until that is looked at
            tally.add(pending)
            tally.judge()
            tally.slope()
            pending = []
            yield None
        pending.append(sample)
    tally.add(pending)
    yield tally.study()


class _Tally:
    """Collects samples into a study, block by block."""

    def __init__(self, case: Case, experiment: Experiment, runs: int, plant: NonlinearPlant) -> None:
        self.case, self.runs, self.n = case, runs, len(case.guess)
        self.weights = np.array([s.weights for s in case.watched])
        self.down = np.zeros(runs, dtype=bool)
        self.lost = {name: np.zeros(runs, dtype=bool) for name in FILTERS}
        self.x: list[np.ndarray] = []
        self.u: list[np.ndarray] = []
        self.upright: list[int] = []
        self.parts: dict[str, list[tuple[np.ndarray, ...]]] = {name: [] for name in FILTERS}
        self.squares: dict[str, list[tuple[np.ndarray, ...]]] = {name: [] for name in FILTERS}
        self.apart: dict[str, float] = dict.fromkeys((EKF, UKF), 0.0)
        self.honest: dict[str, float] = dict.fromkeys(FILTERS, 0.0)
        self.point = chi2_band(self.n, count=1, level=0.98)[1]
        self.waiting: list[tuple[list[Sample], np.ndarray]] = []
        self.flat: list[list[Sample]] = []
        self.slopes = Slopes(case, experiment, plant)
        self.seen: dict[str, list[np.ndarray]] = {name: [] for name in FILTERS}

    def add(self, samples: list[Sample]) -> None:
        """Take in a block of samples; how its errors compare with what the filters believe of them is asked by `judge`."""
        x = np.stack([s.x for s in samples])  # (k, n, N)
        down = np.zeros((len(samples), self.runs), dtype=bool)
        if self.case.id == PENDULUM_CASE:
            down = np.logical_or.accumulate(np.vstack([self.down, np.abs(x[:, 1]) > FALLEN]), axis=0)[1:]
            self.down = down[-1]
        self.x.append(x[:, :, 0])
        self.u.append(np.stack([s.u[:, 0] for s in samples]))
        self.upright += [int(v) for v in self.runs - down.sum(axis=1)]
        for name in FILTERS:
            steps = [s.corrections[name] for s in samples]
            self.lost[name] = self.lost[name] | samples[-1].lost[name]
            mean = np.stack([c.beliefs.mean for c in steps])
            own = np.stack([np.diag(c.beliefs.covariance[0]) for c in steps])
            watched, out = (self.weights @ (x - mean))**2, _out(samples, down, name)
            self.seen[name].append(np.where(out, np.nan, watched[:, judged(self.case)]))
            rms = np.sqrt(np.stack([_mean(watched[:, i], out) for i in range(2)], axis=1))
            self.parts[name].append((mean[:, :, 0], np.sqrt(np.maximum(own, 0.0)), rms))
        self.waiting.append((samples, down))
        self.flat.append(samples)

    def judge(self) -> None:
        """NEES, NIS and distances of the blocks that wait for it."""
        for samples, down in self.waiting:
            x = np.stack([s.x for s in samples])
            linear = np.stack([s.corrections[KF].beliefs.mean for s in samples])
            unsure = np.stack([np.sqrt(np.maximum(np.diag(s.corrections[KF].beliefs.covariance[0]), 1e-300)) for s in samples])
            for name in FILTERS:
                steps, out = [s.corrections[name] for s in samples], _out(samples, down, name)
                mean = np.stack([c.beliefs.mean for c in steps])
                P = np.stack([np.broadcast_to(c.beliefs.covariance, (self.runs, self.n, self.n)) for c in steps])
                nu, S = (np.stack(a) for a in zip(*((c.innovation.T, np.broadcast_to(
                    c.S, (self.runs, *c.S.shape[1:]))) for c in steps), strict=True))
                each = errors_squared((x - mean).transpose(0, 2, 1), P)
                self.honest[name] = float(np.sum(each[-1, ~out[-1]] < self.point) / max(np.sum(~down[-1]), 1))
                self.squares[name].append((_mean(each, out), _mean(errors_squared(nu, S), out)))
                if name != KF:
                    apart = np.abs(mean - linear) / unsure[:, :, None]
                    self.apart[name] = max(self.apart[name], float(np.max(np.where(out[:, None], 0.0, apart))))
        self.waiting.clear()

    def slope(self) -> None:
        """The slopes along the blocks that wait for them."""
        for samples in self.flat:
            self.slopes.add(samples)
        self.flat.clear()

    def bound(self) -> Bound:
        """What no filter could do better than on all blocks."""
        self.slope()
        return self.slopes.bound({name: np.concatenate(v) for name, v in self.seen.items()}, self.down)

    def judged(self) -> Judged:
        """What all blocks say."""
        self.judge()
        squares = {name: [_filled(np.concatenate(p)) for p in zip(*self.squares[name], strict=True)] for name in FILTERS}
        return Judged({name: squares[name][0] for name in FILTERS}, {name: squares[name][1] for name in FILTERS}, self.apart, self.honest)

    def study(self) -> Study:
        x, u = np.concatenate(self.x), np.concatenate(self.u)
        if not np.isfinite(x).all():
            raise EngineError("The plant has left the region where its equations hold; start it nearer to rest.")
        parts = {name: [np.concatenate(p) for p in zip(*self.parts[name], strict=True)] for name in FILTERS}
        mean, sigma, rms = ({name: parts[name][i] for name in FILTERS} for i in range(3))
        return Study(
            self.case,
            self.runs,
            self.case.step * np.arange(len(x)),
            x,
            u,
            mean,
            sigma,
            LazyValue(self.judged),
            LazyValue(self.bound),
            {name: np.stack([_filled(v[:, i]) for i in range(2)], axis=1) for name, v in rms.items()},
            {name: int(v.sum()) for name, v in self.lost.items()},
            int(self.down.sum()),
            np.array(self.upright),
        )


def _out(samples: list[Sample], down: np.ndarray, name: str) -> np.ndarray:
    """Which runs do not count at each sample (k, N)."""
    return down | np.stack([s.lost[name] for s in samples])


def _mean(values: np.ndarray, out: np.ndarray) -> np.ndarray:
    """Means over the runs that count (k,); NaN where none does."""
    good = ~out & np.isfinite(values)
    count = good.sum(axis=1)
    total = np.where(good, np.minimum(np.where(good, values, 0.0), MAX_MEAN_SQUARE), 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _filled(values: np.ndarray) -> np.ndarray:
    """Gaps carry on the last value that there was."""
    known = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), -1))
    return np.where(known >= 0, values[np.maximum(known, 0)], MAX_MEAN_SQUARE)
