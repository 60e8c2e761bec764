"""Check an own bilinear plant, list the possible g = K x, and scale its run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.engine import BilinearPlant, EngineError, Plant, bilinear_functional_observer, simulate_bilinear
from observer_lab.engine.design import StartingGain, shift_poles, starting_feedback, typical_rate
from observer_lab.engine.observers import BilinearForm, BilinearObserver
from observer_lab.plants import Model
from observer_lab.plants.bodies.body import Body
from observer_lab.plants.bodies.own_body import MOST_IN_ROW, tubes_body
from observer_lab.plants.model import Window
from observer_lab.plants.own_plant import board_of
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import Text, same, subscript, text

from .input_signals import columns, together, wave
from .paper_example import base_of, error_matrix

RUN_STEPS = 400  # of a run
MOST_SINGLE = 8  # states that may be wanted one by one
RUN_TYPICAL_TIMES, MAX_GROWTH_EXPONENT = 6.0, 8.0  # a run is this many typical times long, or e^MAX_GROWTH_EXPONENT of what grows fastest
START_EAGERNESS = 25.0  # how eager the observer begins


@dataclass(frozen=True, eq=False)
class Wanted:
    """One choice of g = K x: its name, its rows and theirs, the eight steps, the gain π to begin with and its board, a body."""

    id: str
    label: Text
    rows: tuple[Text, ...]
    units: tuple[str, ...]
    solved: BilinearObserver
    start: StartingGain | None
    poles: tuple[complex, ...]
    window: Window
    body: Body
    standing: np.ndarray  # which entries of (x, g) stand on the stage
    sizes: np.ndarray  # (r,): the largest |g| of the first run

    @property
    def K(self) -> np.ndarray:
        """The rows wanted (r×n)."""
        return self.solved.K

    @property
    def bolted(self) -> tuple[complex, ...]:
        """Poles that no L of the family moves."""
        return () if self.start is None else tuple(map(complex, self.start.bolted))

    def gain(self, asked: tuple[complex, ...]) -> np.ndarray:
        """L (q×m) with the poles on the board where they are asked for; the one L where there is one, the nearest where there is none."""
        o = self.solved
        if o.case == 1:
            return nearest(o)
        pi = self.pi(asked)
        return base_of(o) if pi is None else base_of(o) + pi @ o.canonical_Q.zero_left

    def pi(self, asked: tuple[complex, ...]) -> np.ndarray | None:
        """π (q×k) of the family, None where there is none."""
        o = self.solved
        if self.start is None:
            return None
        return (shift_poles(o.A_star, o.B_star, self.start.gain, self.poles, asked) if self.poles else self.start.gain).T


def nearest(o: BilinearObserver) -> np.ndarray:
    """L of least squares for (20), each condition and each output as heavy as any other."""
    stacked = np.vstack([o.Q, o.right])
    wide = np.linalg.norm(stacked, axis=0)
    wide = np.where(wide > 0, wide, 1.0)
    tall = np.linalg.norm(o.Q / wide, axis=1)
    tall = np.where(tall > 0, tall, 1.0)
    return (o.right / wide) @ np.linalg.pinv(o.Q / wide / tall[:, None]) / tall


@dataclass(frozen=True, eq=False)
class Here:
    """A plant for this lesson: what may be wanted, the input's natural size, how long a run is, what each sensor reads at most."""

    model: Model
    plant: BilinearPlant
    wanted: tuple[Wanted, ...]
    strength: np.ndarray  # (k,)
    horizon: float
    readings: np.ndarray  # (m,)

    @property
    def names(self) -> tuple[Text, ...]:
        """What the inputs are called."""
        p = self.model.plant
        return tuple(signal_name(p, name) for name in p.input_names[:self.plant.inputs])

    @property
    def units(self) -> tuple[str, ...]:
        """The units of the inputs."""
        p = self.model.plant
        return tuple(p.unit(name) for name in p.input_names[:self.plant.inputs])

    @property
    def linear(self) -> bool:
        """Whether u multiplies nothing."""
        return not np.any(self.plant.F)

    @property
    def dt(self) -> float:
        """The step of a run in s."""
        return self.horizon / RUN_STEPS

    def of(self, id: str) -> Wanted:
        """The choice of that name."""
        return next(w for w in self.wanted if w.id == id)

    @property
    def scale(self) -> np.ndarray:
        """Powers of two (n,) about as large as the states."""
        return 2.0 ** np.round(np.log2(np.maximum(np.abs(np.array(self.model.x0)), 1e-300)))

    @property
    def inner(self) -> BilinearPlant:
        """The plant in states of like size, in which it is simulated."""
        p, D = self.plant, self.scale
        return BilinearPlant(p.A * D / D[:, None], p.B / D[:, None], np.hstack([F * D / D[:, None] for F in p.parts]), p.C * D)


def fitted(model: Model) -> Here:
    """What the lesson needs of a plant. Raises KnobError or EngineError, in one sentence, where it does not fit."""
    p, beyond = model.plant, model.beyond
    count = 1 if beyond.F is None else p.m  # of a linear plant the first input is u, the others rest
    if np.any(p.D[:, :count]):
        raise KnobError(text("This lesson has y = C x: leave out D, or take y − D u for the output."))
    F = np.zeros_like(p.A) if beyond.F is None else beyond.F
    plant = BilinearPlant(p.A, p.B[:, :count], F, p.C)
    rate = typical_rate(p)
    growing = float(np.max(np.real(p.poles)))
    horizon = float(f"{min(RUN_TYPICAL_TIMES / rate, MAX_GROWTH_EXPONENT / growing if growing > 0 else np.inf):.2g}")
    here = Here(model, plant, (), _strength(model, plant, rate), horizon, np.ones(p.p))
    x, u = _first_run(here)
    readings = np.max(np.abs(x @ p.C.T), axis=0)
    full = np.maximum(np.max(np.abs(x), axis=0), 1e-300)
    wanted = []
    for id, label, rows, units, K in _choices(model):
        try:
            solved = bilinear_functional_observer(p.A, plant.B, F, p.C, K, -rate)
        except EngineError:
            if id == "K":
                raise
            continue  # the sensors read this row already
        sizes = np.max(np.abs(x @ K.T), axis=0)
        wanted.append(_choice(here, id, label, rows, units, solved, full, np.where(sizes > 0, sizes, 1.0), u))
    return Here(model, plant, tuple(wanted), here.strength, horizon, np.where(readings > 0, readings, 1.0))


def _strength(model: Model, plant: BilinearPlant, rate: float) -> np.ndarray:
    """The inputs (k,) which make Σ uⱼ Fⱼ at most half as fast as the plant; where Fⱼ is zero an input's own natural size."""
    D = np.abs(np.array(model.x0))
    sizes = [float(np.linalg.norm(F * D / D[:, None], 2)) for F in plant.parts]
    return np.array([float(f"{0.5 * rate / size / plant.inputs if size > 0 else model.u_max:.2g}") for size in sizes])


def _first_run(here: Here) -> tuple[np.ndarray, np.ndarray]:
    """x (n_t, n) and u (n_t, k) of the plant alone under the sines that the knobs begin with."""
    p = here.inner
    none, one = np.zeros((1, p.m)), np.zeros((1, 1))
    still = BilinearForm(one, none, np.zeros((1, p.inputs)), np.zeros((1, p.inputs * p.m)), none, none, one)
    sines = together([wave("sine", size, omega_of(here.horizon, j), here.horizon) for j, size in enumerate(here.strength.tolist())])
    run = simulate_bilinear(p, still, np.ones((1, p.n)), sines, np.array(here.model.x0) / here.scale, [0.0],
                            horizon=here.horizon, dt=here.dt)
    return run.x * here.scale, columns(run.u)


def omega_of(horizon: float, which: int = 0) -> float:
    """The frequency that an input begins with: about two periods in a run, and more of each that follows."""
    return float(f"{4 * np.pi / horizon * (1 + 0.6 * which):.2g}")


def _choices(model: Model) -> list[tuple[str, Text, tuple[Text, ...], tuple[str, ...], np.ndarray]]:
    """All rows of K together, each alone, and states one by one: id, label, names and units of the rows, the rows."""
    p, K, one = model.plant, model.beyond.K, np.eye(model.plant.n)
    found = []
    if K is not None:
        names = tuple(same("g" if len(K) == 1 else subscript(f"g{i + 1}")) for i in range(len(K)))
        found.append(("K", text("g = K x of the file, {count} numbers", count=len(K)) if len(K) > 1 else text("g = K x of the file"),
                      names, ("",) * len(K), K))
        if len(K) > 1:
            found += [(f"g{i + 1}", text("row {row} of K alone", row=i + 1), (names[i],), ("",), K[i:i + 1]) for i in range(len(K))]
    unseen = [i for i in range(p.n) if np.linalg.matrix_rank(np.vstack([_even(p.C), one[i]]), 1e-9) > p.p]
    found += [(f"x{i + 1}", text("state {name}", name=signal_name(p, p.state_names[i])), (signal_name(p, p.state_names[i]),),
               (p.unit(p.state_names[i]),), one[i:i + 1]) for i in unseen[:MOST_SINGLE]]
    return found


def _even(C: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(C, axis=1, keepdims=True)
    return C / np.where(size > 0, size, 1.0)


def _choice(here: Here, id: str, label: Text, rows: tuple[Text, ...], units: tuple[str, ...], o: BilinearObserver, full: np.ndarray,
            sizes: np.ndarray, u: np.ndarray) -> Wanted:
    p = here.model.plant
    start = starting_feedback(Plant(o.A_star, o.B_star, np.eye(o.order)), eager=START_EAGERNESS) if o.case == 3 else None
    if start is not None:
        shown = board_of(start, 0.0)
        poles, window = shown.poles, shown.window
    else:
        known = np.linalg.eigvals(error_matrix(o, nearest(o) if o.case == 1 else base_of(o))).astype(complex)
        shown = board_of(StartingGain(np.zeros((0, 0)), known, np.zeros(0, dtype=complex)), 0.0)
        poles, window = (), shown.window
    measured = tuple(k for k in range(p.n) if any(np.flatnonzero(row).tolist() == [k] for row in p.C))
    few = p.n + len(rows) <= MOST_IN_ROW
    states = [k for k in range(p.n) if few or k not in measured][:max(MOST_IN_ROW - len(rows), 1)]
    told = (text("One tube per state, lit where a sensor reads it alone. On the right one per row of g, with its ghost ĝ; green arrow: u.")
            if few else
            text("Tubes for states that no sensor reads alone. On the right one per row of g, with its ghost ĝ; green arrow: u."))
    body = replace(tubes_body([*(signal_name(p, p.state_names[k]) for k in states), *rows], [*full[states].tolist(), *sizes.tolist()],
                              measured if few else (), [float(s) or 1.0 for s in np.max(np.abs(u), axis=0)]), caption=told)
    return Wanted(id, label, rows, units, o, start, poles, window, body, np.array([*states, *range(p.n, p.n + len(rows))]), sizes)
