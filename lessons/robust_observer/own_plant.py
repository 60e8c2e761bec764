"""Check an own plant, list what can be estimated, and choose starting poles."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from observer_lab.course.knobs import KnobError, Poles
from observer_lab.course.lesson import Design
from observer_lab.engine import EngineError, Plant, functional_observer, observability
from observer_lab.engine.design import typical_rate
from observer_lab.engine.observers import FunctionalObserver, Norm, Perturbations, every_entry, perturbations
from observer_lab.plants import Model
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import Text, same, text

from ..toolkit.gains import feedback
from .knobs import NORMS
from .loop import CONDITION_RTOL, Errors, weighed

MAX_LOW_ORDERS = 3  # orders offered from the lowest on; the highest comes with them
COINCIDENT_POLES_RTOL = 1e-6  # poles nearer to each other than this, relative, coincide
WORST_CONDITION = 1e4  # of [T; C]
FREQUENCIES = 50


@dataclass(frozen=True, eq=False)
class Scaled:
    """A plant in units of its own: states all about as large, time in 1/rate; both powers of two, so nothing is rounded.

    There polynomials keep their precision. The directions g of an observer have unit length there, which fixes the scale of T.
    """

    plant: Plant
    unit: np.ndarray  # (n,)
    rate: float
    inner: Plant

    def given(self, o: FunctionalObserver, row: np.ndarray, wrong: Perturbations) -> FunctionalObserver:
        """An observer of the inner plant as one of the plant that was given, in seconds; N and M are the same."""
        return replace(o, plant=self.plant, K=row, F=o.F * self.rate, T=o.T / self.unit, L=o.L * self.rate, poles=o.poles * self.rate,
                       wrong=wrong)

    def within(self, wrong: Perturbations) -> Perturbations:
        """Errors such that J of an inner observer is that of the given one: T Aᵢ and L Cᵢ have the same size."""
        return replace(wrong, A=wrong.A / self.unit[:, None], beta=wrong.beta * self.rate)

    def observer(self, row: np.ndarray, poles: tuple[complex, ...], wrong: Perturbations, norm: Norm = 2) -> FunctionalObserver:
        """The observer of row · x with these poles, for the plant that was given."""
        found = functional_observer(self.inner, row * self.unit, len(poles), poles=np.array(poles) / self.rate,
                                    wrong=self.within(wrong),
                                    norm=norm)
        return self.given(found, row, wrong)


def scaled(model: Model) -> Scaled:
    """The plant with units from its typical start and its typical rate."""
    plant = model.plant
    unit = 2.0 ** np.round(np.log2(np.maximum(np.abs(np.array(model.x0)), 1e-300)))
    rate = float(2.0 ** np.round(np.log2(typical_rate(plant))))
    return Scaled(plant, unit, rate, Plant(plant.A * unit / unit[:, None] / rate, plant.B / unit[:, None] / rate, plant.C * unit, plant.D))


@dataclass(frozen=True, eq=False)
class Here:
    """A plant, what may be wanted of it (name → input or state), and the poles to start from for every order offered."""

    model: Model
    wanted: tuple[tuple[str, Text], ...]
    starts: tuple[tuple[int, tuple[complex, ...]], ...]
    entries: Perturbations
    highest: int
    scaled: Scaled

    @property
    def plant(self) -> Plant:
        return self.model.plant

    @property
    def frequencies(self) -> np.ndarray:
        """Frequencies in Hz around those of the run."""
        return np.geomspace(0.2, 200.0, FREQUENCIES) / self.model.horizon

    def unit(self, design: Design) -> str:
        """The unit of what is wanted."""
        names = self.plant.input_names if design["wanted"][0] == "u" else self.plant.state_names
        return self.plant.unit(names[int(design["wanted"][1:]) - 1])

    def weighed(self, design: Design) -> Perturbations:
        """Every entry of A and C wrong by itself, with the design's weights."""
        return weighed(self.entries, design)

    def errors(self, design: Design) -> Errors:
        """ΔA, ΔB = 0, ΔC of the true plant."""
        A, C = self.plant.A, self.plant.C
        rng = np.random.default_rng(int(design["signs"]))
        a, c = (rng.choice([-1.0, 1.0], M.shape) if design["signs"] else np.ones(M.shape) for M in (A, C))
        return design["delta_a"] / 100 * a * A, 0 * self.plant.B, design["delta_c"] / 100 * c * C

    def rows(self, design: Design) -> tuple[np.ndarray, np.ndarray]:
        """K (m×n) of the whole controller, and the wanted row (1×n)."""
        K = feedback(self.plant, design["controller_poles"], self.model)
        return K, row_of(self.plant, K, design["wanted"])

    def inner(self, design: Design) -> tuple[Plant, np.ndarray, float]:
        """The plant and the wanted row in its own units, and their unit of time in 1/s."""
        return self.scaled.inner, self.rows(design)[1] * self.scaled.unit, self.scaled.rate

    def orders(self, design: Design) -> tuple[tuple[complex, ...], ...]:
        """No poles, those of each order that the page offers, and one more than the highest has."""
        offered = [tuple(design[f"poles_{order}"]) for order, _ in self.starts]
        return ((), *offered, (*offered[-1], complex(2 * min(p.real for p in offered[-1]))))

    def observer(self, design: Design) -> FunctionalObserver:
        """The observer of the design. Raises KnobError, in one sentence, where its poles give none."""
        order = int(design["order"])
        poles = design[f"poles_{order}"]
        if max(p.real for p in poles) >= -1e-6 * -self.model.observer_window.re_low:
            raise KnobError(text("An observer pole is not in the left half plane, so its error would not decay; drag it left."))
        if coincide(poles):
            raise KnobError(text("Two observer poles coincide; this form of the observer needs them apart, so move one."))
        try:
            found = self.scaled.observer(self.rows(design)[1], poles, self.weighed(design), NORMS[design["norm"]])
        except (EngineError, np.linalg.LinAlgError) as problem:
            raise _none(order) from problem
        if not met(found):
            raise _none(order)
        return found

    def unit_rows(self, o: FunctionalObserver) -> FunctionalObserver:
        """The same observer with z in rows of T of unit length."""
        size = lengths(o.T * self.scaled.unit)
        return replace(o, F=o.F * size / size[:, None], T=o.T / size[:, None], L=o.L / size[:, None], N=o.N * size)


def _none(order: int) -> KnobError:
    return KnobError(text("With these poles no observer of order {order} gives the function to 10⁻⁹; raise the order or move the poles.",
                          order=order))


def lengths(rows: np.ndarray) -> np.ndarray:
    """The length of each row, 1 for a row of zeros."""
    length = np.linalg.norm(rows, axis=1)
    return np.where(length > 0, length, 1.0)


def fitted(model: Model) -> Here:
    """What the lesson needs of a plant. Raises KnobError, in one sentence, where it does not fit."""
    plant = model.plant
    if observability(plant).unobservable:
        raise KnobError(text("The plant has modes that leave no trace in its outputs; measure more, or take it to the "
                             "lesson on hidden modes."))
    units = scaled(model)
    highest = plant.n - seen_by(units)
    if highest < 1:
        raise KnobError(text("The outputs of this plant give its whole state, so u = −Kx needs no observer. Leave out an output, or "
                             "use a plant with more states."))
    K = np.zeros((plant.m, plant.n)) if model.controller is None else model.controller.gain
    wanted = tuple((f"u{i + 1}", text("input {name}: its row of K", name=signal_name(plant, name)))
                   for i, name in enumerate(plant.input_names) if np.any(K[i]))
    wanted += tuple((f"x{i + 1}", text("state {name}", name=signal_name(plant, name)))
                    for i, name in enumerate(plant.state_names))
    row = row_of(plant, K, wanted[0][0])
    found = [(order, *starting_poles(model, units, row, order)) for order in range(1, highest + 1)]
    limit = max(WORST_CONDITION, min(condition for _, _, condition in found))
    starts = [(order, poles) for order, poles, condition in found if poles and condition <= limit]
    starts = starts[:MAX_LOW_ORDERS] + starts[MAX_LOW_ORDERS:][-1:]
    if not starts:
        raise KnobError(text("Double precision finds no observer of order 1 to {highest} for this plant: its polynomials spread over "
                             "too many powers of ten.",
                             highest=highest))
    return Here(model, wanted, tuple(starts), every_entry(plant), highest, units)


def seen_by(here: Scaled) -> int:
    """How many directions of the state the outputs give at once."""
    values = np.linalg.svd(here.inner.C, compute_uv=False)
    return int(np.count_nonzero(values > 1e-10 * values[0]))


def row_of(plant: Plant, K: np.ndarray, wanted: str) -> np.ndarray:
    """The wanted row (1×n): of K, or of the unit matrix."""
    index = int(wanted[1:]) - 1
    return K[[index]] if wanted[0] == "u" else np.eye(plant.n)[[index]]


def starting_poles(model: Model, units: Scaled, row: np.ndarray, order: int) -> tuple[tuple[complex, ...], float]:
    """Poles of an observer of that order inside the board that keep [T; C] best conditioned, and its condition; (), ∞ if none serve."""
    window, nothing = model.observer_window, perturbations(model.plant)
    best, least = (), np.inf
    for poles in (_natural(model, order), _natural(model, order, 0.5),
                  tuple(complex(v) for v in np.linspace(0.3, 0.9, order) * window.re_low),
                  tuple(complex(v) for v in np.geomspace(0.05, 0.9, order)[::-1] * window.re_low)):
        if len(poles) != order or coincide(poles) or max(p.real for p in poles) >= 0:
            continue
        try:
            poles = Poles("p", "", same(""), default=poles, re_low=window.re_low, re_high=window.re_high,
                          im_high=window.im_high).check(poles)
            found = units.observer(row, poles, nothing)
        except (EngineError, KnobError, np.linalg.LinAlgError):
            continue
        if met(found, 0.1) and found.condition < least:
            best, least = poles, found.condition
    return best, least


def _natural(model: Model, order: int, share: float = 1.0) -> tuple[complex, ...]:
    """The slowest of the poles that a full observer starts with, in whole pairs."""
    chosen: list[complex] = []
    window = model.observer_window
    known = model.observer_poles if model.observer is None else model.observer.moved
    for p in sorted((complex(p) for p in known if p.imag >= 0 and p.real >= window.re_low and p.imag <= window.im_high), key=abs):
        pair = [p * share] if p.imag == 0 else [p * share, p.conjugate() * share]
        if len(chosen) + len(pair) <= order:
            chosen += pair
    return tuple(chosen)


def coincide(poles: tuple[complex, ...]) -> bool:
    """Whether two of the poles are one."""
    p = np.array(poles)
    gaps = np.abs(p[:, None] - p[None, :]) + np.diag(np.full(p.size, np.inf))
    return bool(gaps.min() < COINCIDENT_POLES_RTOL * max(float(np.abs(p).max()), 1e-300))


def met(o: FunctionalObserver, share: float = 1.0) -> bool:
    """Both conditions hold to 1e-9, or to a share of it."""
    return o.dynamics_residual < share * CONDITION_RTOL and o.output_residual < share * CONDITION_RTOL
