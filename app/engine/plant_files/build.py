"""Turn a file's variables into a plant; every key is used, harmless, or named."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..systems.errors import EngineError, Phrase
from ..systems.plant import Plant
from ..systems.records import record
from .delays import with_delays
from .descriptor import solved
from .found import Found
from .fractions_given import fractions
from .input_gate import MAX_STATES, matrix
from .labels import labels_of
from .notes import decoded, note
from .transfer import realised

__all__ = ["MAX_SIGNALS", "Content", "bounded", "built"]

MAX_SIGNALS = 16
_MOST_NAMED = 6
_FORMAT = "observer-lab plant"


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

