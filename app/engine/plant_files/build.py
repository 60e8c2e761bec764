"""Turn a file's variables into a plant; every key is used, harmless, or named."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..structure.decomposition import kalman_decomposition
from ..systems.errors import EngineError, Phrase, ShapeError
from ..systems.fractions import Fraction, realised_by_entries
from ..systems.plant import Plant
from ..systems.records import record
from ..systems.spectrum import frequency_response
from .delays import with_delays
from .found import Found
from .fractions_given import fractions
from .input_gate import MAX_STATES, matrix
from .labels import labels_of
from .notes import decoded, note

__all__ = ["MAX_SIGNALS", "Content", "bounded", "built", "realised", "solved"]

MAX_SIGNALS = 16
_MOST_NAMED = 6
_FORMAT = "observer-lab plant"
WORST_CONDITION = 1e12  # of E, beyond which E⁻¹ is rounding
SAME = 1e-7  # how well the smaller realisation must give the same frequency response, relative to its size


@record()
class Content:
    """What a file holds: the plant, and by their names the further matrices F, F1, F2, … (n×n) and K (r×n) of a bilinear one."""

    plant: Plant
    more: Mapping[str, np.ndarray]


def bounded(plant: Plant) -> Plant:
    """The plant itself. Raises EngineError beyond 200 states or 16 inputs or outputs, or without states."""
    if not 1 <= plant.n <= MAX_STATES:
        raise EngineError("A plant needs 1 to {max_states} states; this one has {n}.",
                          max_states=MAX_STATES, n=plant.n)
    if not (1 <= plant.m <= MAX_SIGNALS and 1 <= plant.p <= MAX_SIGNALS):
        raise EngineError("A plant needs 1 to {max_signals} inputs and outputs; this one has {m} and {p}.",
                          max_signals=MAX_SIGNALS, m=plant.m, p=plant.p)
    return plant


def built(found: Found) -> Content:
    """The plant of a file's variables. Raises EngineError and ShapeError, in one sentence."""
    if found.take("format", _FORMAT) != _FORMAT or found.take("version", 1) != 1:
        raise EngineError("This JSON is not a plant of version 1; leave out its keys \"format\" and \"version\", or write "
                          "\"{format}\" and 1.", format=_FORMAT)
    period = found.period()
    given = found.take("changes", None)
    notes = () if given is None else decoded(given)
    (plant, said), more = (_of_matrices(found, period) if found.has("A") else (_of_fractions(found, period), {}))
    plant, late = with_delays(plant, *found.delays(plant.m, plant.p))
    if late and more:
        raise EngineError("A plant with delays and a bilinear term is not supported; remove the delays, or F.")
    found.refuse_the_rest()
    left = found.not_used()
    notes = (*notes, *said, *late, *((note("unused", names=_row(left)),) if left else ()))
    return Content(bounded(replace(plant, notes=notes)), more)


def _row(names: list[str]) -> str:
    plain = [re.sub(r"\W", " ", name)[:24].strip() for name in names]
    return ", ".join(plain[:_MOST_NAMED]) + (", …" if len(plain) > _MOST_NAMED else "")


def _of_matrices(found: Found, period: float) -> tuple[tuple[Plant, tuple[Phrase, ...]], dict[str, np.ndarray]]:
    missing = [key for key in "ABC" if not found.has(key)]
    if missing:
        raise EngineError("The file has no matrix {missing}; a plant needs A, B and C (D may be left out).",
                          missing=missing[0])
    A, _ = found.matrix("A")
    if not A.size:
        raise EngineError("{key} is empty; a plant needs at least one state.", key=found.key("A"))
    n = len(A)
    B, C = found.matrix("B", lying=n == 1)[0], found.matrix("C", lying=n != 1)[0]
    D = _feedthrough(found, C.shape[0], B.shape[1])
    more = _bilinear(found, n)
    said: tuple[Phrase, ...] = ()
    E, key = found.matrix("E")
    if E.size:
        F = [name for name in more if name != "K"]
        A, (B, *solved_F), said = solved(E, _square(A, n), [_tall(B, n), *(more[name] for name in F)], key)
        more |= dict(zip(F, solved_F, strict=True))
    return (Plant(A, B, C, D, period, *labels_of(found)), said), more  # type: ignore[arg-type]


def _square(A: np.ndarray, n: int) -> np.ndarray:
    return Plant(A, np.zeros((n, 1)), np.zeros((1, n))).A  # says what is wrong with it


def _tall(B: np.ndarray, n: int) -> np.ndarray:
    return Plant(np.zeros((n, n)), B, np.zeros((1, n))).B


def _feedthrough(found: Found, p: int, m: int) -> np.ndarray | None:
    """D: None where it is left out, empty, or one zero for all channels."""
    D, _ = found.matrix("D", lying=p == 1)
    return None if not D.size or (D.size == 1 and D.item() == 0 and (p, m) != (1, 1)) else D


def _bilinear(found: Found, n: int) -> dict[str, np.ndarray]:
    """F, F1, … and K, where there is an F; K alone is not used."""
    names = [name for name in found.rest() if re.fullmatch(r"F\d*", name)]
    more = {name: matrix(found.use(name), name) for name in names}
    more = {name: F for name, F in more.items() if F.size}
    if more and found.holds("K"):
        K = matrix(found.use("K"), "K", lying=n != 1)
        more |= {"K": K} if K.size else {}
    return more


def _of_fractions(found: Found, period: float) -> tuple[Plant, tuple[Phrase, ...]]:
    entries = fractions(found, period)
    if entries is None:
        raise found.nothing()
    plant, said = realised(entries, period)
    states, inputs, outputs, units, name = labels_of(found)
    if states and len(states) != plant.n:
        states = ()  # the states of a transfer function are the lab's own choice
    return replace(plant, state_names=states or plant.state_names, input_names=inputs or plant.input_names,
                   output_names=outputs or plant.output_names, units=units, name=name), said


def solved(E: np.ndarray, A: np.ndarray, others: list[np.ndarray], key: str) -> tuple[np.ndarray, list[np.ndarray], tuple[Phrase, ...]]:
    """E⁻¹A, E⁻¹M for each other M, and the note that says so; no note where E = I.

    E and A n×n. Raises EngineError where E is singular or too near to it, ShapeError where it does not fit A.
    """
    if E.shape != A.shape:
        raise ShapeError("{name} must be {n}×{n}, as A is; it is {rows}×{columns}.", name=key, n=len(A), rows=E.shape[0],
                         columns=E.shape[1])
    if not np.isfinite(E).all():
        raise EngineError("{name} must hold finite numbers only.", name=key)
    if np.array_equal(E, np.eye(len(E))):
        return A, others, ()
    rows = np.abs(E).max(axis=1, initial=0.0)
    scaled = E / np.where(rows > 0, rows, 1.0)[:, None]  # the unit of an equation decides nothing
    columns = np.abs(scaled).max(axis=0, initial=0.0)
    condition = float(np.linalg.cond(scaled / np.where(columns > 0, columns, 1.0)))
    if not condition < WORST_CONDITION:
        raise EngineError("{name} is singular: some equations of this plant have no derivative; eliminate them and leave out {name}.",
                          name=key)
    return np.linalg.solve(E, A), [np.linalg.solve(E, M) for M in others], (note("descriptor", condition=condition),)


def realised(entries: Sequence[Sequence[Fraction]], dt: float) -> tuple[Plant, tuple[Phrase, ...]]:
    """The plant of a p×m matrix of fractions, and the note that says whether it is minimal.

    Raises EngineError for an improper or empty fraction, and for one without finite coefficients.
    """
    plant = realised_by_entries(entries, dt)
    if not plant.n:
        raise EngineError("The transfer function is a plain gain without states; there is nothing to observe.")
    return _least(plant)


def _least(plant: Plant) -> tuple[Plant, tuple[Phrase, ...]]:
    """The part that is reached and seen, where it gives the same frequency response; else the plant as it is."""
    try:
        found = kalman_decomposition(plant)
        small, hidden = found.minimal, plant.n - found.sizes[0]
    except EngineError:
        return plant, (note("not_minimal", after=plant.n),)
    if not hidden:
        return plant, (note("realised", after=plant.n),)
    if not small.n or not _same(plant, small):
        return plant, (note("not_minimal", after=plant.n),)
    made = Plant(small.A, small.B, small.C, small.D, plant.dt)
    return made, (note("minimal", after=made.n, gone=hidden),)


def _same(plant: Plant, small: Plant) -> bool:
    size = max(float(np.abs(plant.poles).max(initial=0.0)), 1e-300)
    grid = np.linspace(0.05, 3.0, 17) / plant.dt if plant.dt else size * np.geomspace(1e-4, 1e2, 25)
    with np.errstate(all="ignore"):
        one, two = (frequency_response(part.A, part.B, part.C, part.D, grid, dt=plant.dt) for part in (plant, small))
    return bool(np.isfinite(two).all() and np.abs(one - two).max() <= SAME * max(np.abs(one).max(), 1e-300))
