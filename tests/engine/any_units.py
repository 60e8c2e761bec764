"""Each law of units × one state, one input, one output, time, all × 1e±9: digits lost beyond those that the problem itself loses.

    python tests/engine/any_units.py [plants] [seed]     prints the table: the worst of all plants

An answer of the plant in other units, told back in its own, is compared with that of its own. What the problem itself loses is how
far the answers move when every entry of the data is rounded to another double.
"""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).resolve().parents[2]), str(Path(__file__).resolve().parent)]

from unit_cases import Case, Units, ones, random_case
from unit_laws import Answer, _asked, _difference
from unit_laws_more import ALL

from observer_lab.engine import Plant

ALLOWED = 3.0  # digits
EPS = float(np.finfo(float).eps)
FAR = 1e9
ROUNDED = 3  # times that the data are rounded otherwise
KINDS = ("state", "input", "output", "time", "all", "every")


def units(case: Case, kind: str, factor: float, rng: np.random.Generator) -> Units:
    """One of them `factor` times as large; "all": one of each, by that or its inverse; "every": each
    state, input and output by the root of that or its inverse, so that no two are farther apart."""
    own = ones(case)
    parts = {"state": own.X.copy(), "input": own.U.copy(), "output": own.Y.copy()}
    if kind == "every":
        X, U, Y, E = (factor ** rng.choice([-0.5, 0.5], len(v)) for v in (own.X, own.U, own.Y, own.E))
        return Units(X, U, Y, E, factor)
    if kind == "time":
        return replace(own, tau=factor)
    for part in parts if kind == "all" else (kind,):
        parts[part][int(rng.integers(len(parts[part])))] = factor if kind != "all" else factor ** rng.choice([-1.0, 1.0])
    return Units(parts["state"], parts["input"], parts["output"], own.E, factor if kind == "all" else 1.0)


def rounded(case: Case, rng: np.random.Generator) -> Case:
    """The same with every entry moved by half a unit in the last place, or so; zeros stay."""
    def move(M: np.ndarray) -> np.ndarray:
        return np.asarray(M) * (1 + EPS * rng.uniform(-1, 1, np.shape(M)))

    def even(M: np.ndarray) -> np.ndarray:
        return np.diag(move(np.diag(M)))
    p = case.plant
    return replace(case, plant=Plant(move(p.A), move(p.B), move(p.C), move(p.D), p.dt), G=move(case.G), Q=even(case.Q), R=even(case.R),
                   W=even(case.W), V=even(case.V))


def gap(own: Answer | str, other: Answer | str) -> float:
    """The largest difference of two answers beside their own size; infinite where only one is refused."""
    if isinstance(own, str) or isinstance(other, str):
        return 0.0 if isinstance(own, str) and isinstance(other, str) else np.inf
    return max((_difference(value, other[key]) for key, value in own.items()), default=0.0) if own.keys() == other.keys() else np.inf


def told(law: str, case: Case, z: Units) -> Answer | str:
    """The answer; a law that an answer breaks by itself is told as a refusal of this plant."""
    try:
        return _asked(law, case, z, ALL)
    except AssertionError as broken:
        return f"broken: {broken}"


def lost(law: str, case: Case, seed: int) -> dict[tuple[str, float], float]:
    """Digits lost for each kind of unit and factor."""
    rng = np.random.default_rng(seed)
    own = told(law, case, ones(case))
    moved = [gap(own, told(law, rounded(case, rng), ones(case))) for _ in range(ROUNDED)]
    floor = max([EPS, *(m for m in moved if np.isfinite(m))])
    found = {}
    for kind in KINDS:
        for factor in (1 / FAR, FAR):
            z = units(case, kind, factor, rng)
            away = gap(own, told(law, case.to(z), z))
            found[kind, factor] = float(np.log10(max(away, floor) / floor))
    return found


def plant_of(seed: int, k: int) -> Case:
    """Every fourth one is sampled."""
    return random_case(np.random.default_rng((seed, k)), sampled=k % 4 == 3)


def row(law: str, plants: int, seed: int) -> dict[tuple[str, float], tuple[float, int]]:
    """The worst of the plants in each column, and which it was."""
    worst: dict[tuple[str, float], tuple[float, int]] = {}
    for k in range(plants):
        for key, digits in lost(law, plant_of(seed, k), k).items():
            if digits >= worst.get(key, (-1.0, 0))[0]:
                worst[key] = digits, k
    return worst


def main(plants: int = 4, seed: int = 5, only: str = "") -> None:
    """Print the table."""
    print(f"{'':16s}" + "".join(f"{kind + f' {factor:.0e}':>15s}" for kind in KINDS for factor in (1 / FAR, FAR)))
    bad = 0
    for law in ALL:
        if only in law:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                found = row(law, plants, seed)
            bad += sum(digits > ALLOWED for digits, _ in found.values())
            cells = "".join(f"{digits:8.1f}" + (f" *({k:3d})" if digits > ALLOWED else 7 * " ") for digits, k in found.values())
            print(f"{law:16s}{cells}", flush=True)
    print(f"{len(ALL)} functions, {bad} of {len(ALL) * 2 * len(KINDS)} lose more than {ALLOWED:g} digits")


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3]), *sys.argv[3:4])
