"""Read the user's own plant from a file and make a `Model` of it.

A file comes from a stranger. `read_plant_file` and `canonical_text` are the gate: what passes has bounded sizes, finite numbers and
names that are plain words, so that no page, formula or file that shows them has to mistrust them again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..engine import EngineError, Plant, Scenario, simulate
from ..engine.design import StartingGain, starting_feedback, starting_observer, typical_rate
from ..engine.plant_files import Content, read_content, reduced_to
from ..engine.simulation import Run
from ..engine.systems import continuous_of, natural_scale
from ..text import Text, error_words, text, text_in
from .bodies.own_body import tubes_body
from .model import Model, Signal, Window
from .plant_extras import NO_EXTRAS, PlantExtras, extras_of, plant_json
from .signal_names import signal_name, title_of

__all__ = [
    "UnsuitablePlant",
    "board_of",
    "canonical_text",
    "clean_plant_json",
    "model_of",
    "own_model",
    "parts_of",
    "plant_of",
    "read_plant_file",
    "without_hold",
]

RUN_SAMPLES = 400  # of a run
MOST_STATES = 30  # of a plant that lessons take
LONGEST_NAME, LONGEST_UNIT, LONGEST_TITLE = 18, 10, 40
ON_BOARD = 10  # most poles on one board
MAX_RATE_FACTOR = 25.0  # poles faster than this many typical rates are left off the board
MAX_NUMBER, MAX_STEP_S = 1e30, 1e9  # of a matrix, and s between two samples: beyond, products overflow
ALLOWED = frozenset(" .,-+/()°·²³⁻¹µ%_")
BEYOND_REACH = text("The numbers of a plant must lie between −10³⁰ and 10³⁰, its sampling time below 10⁹ s; choose other units.")


class UnsuitablePlant(EngineError):
    """A plant that a lesson or the lab cannot take; `text` says why in every language."""

    def __init__(self, said: Text) -> None:
        super().__init__(said.id, **dict(said.values))
        self.text = said

    def __str__(self) -> str:
        return str(self.text)

    def __reduce__(self) -> tuple[object, ...]:
        return UnsuitablePlant, (self.text,)


# --- the gate ----------------------------------------------------------------------------------------------------------
def read_plant_file(name: str, data: bytes) -> str:
    """The canonical text of the plant in a file of that name (.json or .mat), with at most 30 states. Raises Misfit, in one sentence."""
    try:
        return _canonical_of(read_content(name, data))
    except EngineError as problem:
        raise UnsuitablePlant(text_in("file", "{why}", why=error_words(problem))) from problem


def _canonical_of(content: Content) -> str:
    plant = reduced_to(content.plant, MOST_STATES)
    if plant is not content.plant and content.more:
        raise EngineError("A bilinear plant may have at most {most} states; this one has {n}.", most=MOST_STATES, n=content.plant.n)
    return canonical_text(plant, extras_of(content.more, plant))


def clean_plant_json(text: str) -> str:
    """The canonical text of a plant in any JSON text. Raises Misfit."""
    return canonical_text(*parts_of(text))


def canonical_text(plant: Plant, beyond: PlantExtras = NO_EXTRAS) -> str:
    """The plant as the text that a design carries: JSON that reads back exactly, its names made plain words."""
    largest = max(float(np.max(np.abs(matrix), initial=0.0)) for matrix in (plant.A, plant.B, plant.C, plant.D))
    if largest > MAX_NUMBER or plant.dt > MAX_STEP_S:
        raise UnsuitablePlant(BEYOND_REACH)
    names = {name: _plain(name, LONGEST_NAME) for name in (*plant.state_names, *plant.input_names, *plant.output_names)}
    units = tuple((names[k], _plain(v, LONGEST_UNIT)) for k, v in plant.units if k in names)

    def called(given: tuple[str, ...], letter: str) -> tuple[str, ...]:
        return tuple(names[name] or f"{letter}{i + 1}" for i, name in enumerate(given))
    return plant_json(Plant(plant.A, plant.B, plant.C, plant.D, plant.dt, called(plant.state_names, "x"),
                         called(plant.input_names, "u"), called(plant.output_names, "y"), units,
                         _plain(plant.name, LONGEST_TITLE), plant.notes), beyond)


def _plain(words: str, longest: int) -> str:
    """Letters, digits and a few signs: nothing that HTML, Markdown or LaTeX would take for its own."""
    kept = "".join(c if c.isalnum() or c in ALLOWED else " " for c in words)
    return " ".join(kept.split())[:longest].strip(" _")


def plant_of(text: str) -> Plant:
    """The plant of a canonical text, or of any other JSON of a plant with at most 30 states. Raises Misfit."""
    return parts_of(text)[0]


def parts_of(text: str) -> tuple[Plant, PlantExtras]:
    """The same with F and K of a bilinear plant. Raises Misfit."""
    try:
        content = read_content("plant.json", text.encode(errors="replace"))
        plant = reduced_to(content.plant, MOST_STATES)
        return plant, extras_of(content.more, plant)
    except EngineError as problem:
        raise UnsuitablePlant(text_in("plant", "{why}", why=error_words(problem))) from problem


def without_hold(plant: Plant) -> Plant:
    """The continuous plant behind a sampled one. Raises Misfit where there is none."""
    try:
        return continuous_of(plant)
    except EngineError as problem:
        raise UnsuitablePlant(text("{why} This lesson is about continuous time; the sandbox takes the plant as it is.",
                          why=error_words(problem))) from problem


# --- the model ---------------------------------------------------------------------------------------------------------
def model_of(text: str, *, held: bool) -> Model:
    """The model of a canonical text, with F and K of a bilinear plant; `held`: a sampled plant stays as it is. Raises Misfit."""
    plant, beyond = parts_of(text)
    return replace(own_model(plant if held else without_hold(plant)), beyond=beyond)


@dataclass(frozen=True)
class ShownPoles:
    """The poles that stand on a board, in conjugate pairs, and its window."""

    poles: tuple[complex, ...]
    window: Window


def own_model(plant: Plant) -> Model:
    """A plant with starting gains, boards, a run that shows something, signals and a body; both times, up to 30 states.

    Gains: Riccati gains in units that the plant itself suggests. Boards show the poles that can be moved, without those
    far faster than the rest. The run begins one unit away from rest and is as long as the slowest of these poles needs.
    """
    K, L = starting_feedback(plant), starting_observer(plant)
    left, right = (board_of(found, plant.dt) for found in (K, L))
    horizon, dt = _grid(plant, K, L)
    x0 = _start(plant)
    run = _first_run(plant, K.gain, L.gain, x0, horizon, dt)
    full = np.maximum(np.abs(run.x).max(axis=0), np.abs(run.xhat).max(axis=0))
    full = np.where(full > 0, full, 1.0)
    asked = np.abs(run.u_asked).max(axis=0)
    strongest = float(asked.max()) if asked.max() > 0 else 1.0
    alone = _measured_alone(plant)
    return Model(
        id="own", label=title_of(plant), plant=plant,
        body=tubes_body([signal_name(plant, name) for name in plant.state_names], full.tolist(), tuple(alone),
                        np.where(asked > 0, asked, 1.0).tolist()),
        x0=tuple(x0.tolist()), guess=(0.0,) * plant.n, horizon=horizon, dt=dt,
        controller_poles=left.poles, observer_poles=right.poles, controller_window=left.window,
        observer_window=right.window, kick=_kick(plant, x0), watched=_watched(plant, alone),
        u_max=_round(0.5 * strongest), input_unit=plant.unit(plant.input_names[0]),
        source="the user's own plant", controller=K, observer=L)


def _round(value: float) -> float:
    return float(f"{value:.2g}")


def board_of(found: StartingGain, dt: float) -> ShownPoles:
    """The poles to show, in conjugate pairs, and a window that holds them with room to drag."""
    heads = sorted((p for p in found.moved if p.imag >= 0), key=abs if not dt else _slowness)
    if not dt and heads:
        typical = max(abs(heads[(len(heads) - 1) // 2]), 1e-300)
        heads = [p for p in heads if abs(p) <= MAX_RATE_FACTOR * typical]
    shown: list[complex] = []
    for p in heads:
        pair = [complex(p)] if p.imag == 0 else [complex(p).conjugate(), complex(p)]
        if len(shown) + len(pair) <= ON_BOARD and (p.imag == 0 or np.any(found.moved == np.conj(p))):
            shown += pair
    shown.sort(key=lambda p: (p.real, p.imag))
    return ShownPoles(tuple(shown), _disc_window(shown) if dt else _window(shown, found.bolted))


def _slowness(pole: complex) -> float:
    return -abs(pole)


def _window(shown: list[complex], bolted: np.ndarray) -> Window:
    size = max((abs(p) for p in shown), default=0.0) or max((abs(p) for p in bolted), default=0.0) or 1.0
    near = [p for p in bolted if abs(p) <= 2 * size]
    low = max(-min((p.real for p in (*shown, *near)), default=-size), 0.3 * size)
    high = max(max((p.real for p in (*shown, *near)), default=0.0), 0.0)
    tall = max(max((abs(p.imag) for p in (*shown, *near)), default=0.0), 0.4 * size)
    return Window(-_round(2.0 * low), _round(max(0.4 * low, 1.3 * high)), _round(1.4 * tall))


def _disc_window(shown: list[complex]) -> Window:
    reach = max(1.25, 1.15 * max((max(abs(p.real), abs(p.imag)) for p in shown), default=1.0))
    return Window(-_round(reach), _round(reach), _round(reach))


def _grid(plant: Plant, K: StartingGain, L: StartingGain) -> tuple[float, float]:
    """Horizon and step in s: long enough for the slowest pole that can be moved, bounded where something grows."""
    rate = typical_rate(plant)
    real = np.concatenate([np.real(_exponents(found.moved, plant.dt)) for found in (K, L)])
    settling = -real[real < -1e-9 * rate]
    span = float(np.clip(6.0 / settling.min(), 4.0 / rate, 80.0 / rate)) if settling.size else 12.0 / rate
    growing = max((float(np.real(_exponents(found.bolted, plant.dt)).max()) for found in (K, L) if found.bolted.size), default=0.0)
    if growing > 1e-6 * rate:
        span = min(span, 6.0 / growing)
    if plant.dt:
        return plant.dt * int(np.clip(round(span / plant.dt), 30, RUN_SAMPLES)), plant.dt
    span = _round(span)
    return span, span / RUN_SAMPLES


def _exponents(poles: np.ndarray, dt: float) -> np.ndarray:
    """λ of e^{λt}; a pole of a sampled plant at zero is as fast as e^{−12 t/dt}."""
    return np.log(np.where(np.abs(poles) > 6e-6, poles, 6e-6).astype(complex)) / dt if dt else poles


def _start(plant: Plant) -> np.ndarray:
    """x(0): every state off rest by its own typical size, signs alternating, the largest entry one."""
    pattern = np.array([(-1.0) ** i * (1.0, 0.7, 0.5)[i % 3] for i in range(plant.n)])
    x0 = natural_scale(plant.A, plant.B, plant.C) * pattern
    return np.array([_round(v) for v in x0 / np.abs(x0).max()])


def _kick(plant: Plant, x0: np.ndarray) -> tuple[float, ...]:
    """A jump of the state as a blow on the first input gives it, as large as the start."""
    scale = natural_scale(plant.A, plant.B, plant.C)
    push = next((column for column in plant.B.T if np.any(column)), x0)
    return tuple((push / np.linalg.norm(push / scale) * np.linalg.norm(x0 / scale)).tolist())


def _first_run(plant: Plant, K: np.ndarray, L: np.ndarray, x0: np.ndarray, horizon: float, dt: float) -> Run:
    return simulate(Scenario(plant, K, L, x0=x0, xhat0=np.zeros(plant.n), horizon=horizon, dt=dt))


def _measured_alone(plant: Plant) -> dict[int, int]:
    """State → output, for outputs that read one state and nothing else."""
    found: dict[int, int] = {}
    for i, row in enumerate(plant.C):
        where = np.flatnonzero(row)
        if len(where) == 1 and not np.any(plant.D[i]):
            found.setdefault(int(where[0]), i)
    return found


def _watched(plant: Plant, alone: dict[int, int]) -> tuple[Signal, ...]:
    """An output first, then states that nothing measures by itself, then the rest."""
    outputs = [Signal(text("output {name}", name=signal_name(plant, name)), tuple(row.tolist()), plant.unit(name))
               for name, row in zip(plant.output_names, plant.C, strict=True)]
    unit = np.eye(plant.n)
    states = [Signal(text("state {name}", name=signal_name(plant, name)), tuple(unit[i].tolist()), plant.unit(name))
              for i, name in enumerate(plant.state_names)]
    hidden = [signal for i, signal in enumerate(states) if i not in alone]
    seen = [signal for i, signal in enumerate(states) if i in alone]
    return (*outputs[:1], *hidden, *outputs[1:], *seen)
