"""Draw plant files of the kinds that people have, with what each must give; `python tests/engine/plant_files/generated_files.py 2000`.

The law: every key of a file is used, known as harmless, or named in a note or in the refusal; no file is read as another plant.
What is expected is computed here from the drawn numbers alone: by a frequency response, or as a word of the refusal.
"""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.io import savemat
from scipy.sparse import csc_matrix

from observer_lab.engine import EngineError, Plant
from observer_lab.engine.plant_files import read_plant

Response = Callable[[complex], np.ndarray]  # the p×m transfer function at a point of the plane
PADE_ERROR = 2e-3  # of a fraction of order 3 where |ω delay| ≤ 1


@dataclass
class Drawn:
    """One file: its keys, what they must come to, and what must be named."""

    keys: dict[str, Any]
    at: Response
    period: float = 0.0
    tolerance: float = 1e-8
    refused: list[str] = field(default_factory=list)
    noted: list[str] = field(default_factory=list)
    delayed: bool = False


def drawn(seed: int) -> tuple[str, bytes, Drawn]:
    """The name, the bytes and the expectation of one file."""
    rng = np.random.default_rng(seed)
    n, m, p = (int(rng.integers(1, high)) for high in (5, 4, 4))
    A, B, C = rng.standard_normal((n, n)) - 1.5 * np.eye(n), rng.standard_normal((n, m)), rng.standard_normal((p, n))
    D = rng.standard_normal((p, m)) * (rng.random() < 0.5)
    found = Drawn({"A": A, "B": B, "C": C, "D": D},
                  lambda s: C @ np.linalg.solve(s * np.eye(n) - A, B) + D)
    matlab = bool(rng.random() < 0.5)
    for change in (_lower_case, _through, _period, _descriptor, _delay, _harmless, _strange, _unknown):
        change(found, rng, matlab)
    name, data = _as_mat(found, rng) if matlab else _as_json(found, rng)
    return name, data, found


def _lower_case(file: Drawn, rng: np.random.Generator, matlab: bool) -> None:
    if rng.random() < 0.15:
        file.keys = {key.lower(): value for key, value in file.keys.items()}


def _key(file: Drawn, letter: str) -> str:
    return letter if letter in file.keys else letter.lower()


def _through(file: Drawn, rng: np.random.Generator, matlab: bool) -> None:
    key = _key(file, "D")
    if not np.any(file.keys[key]):
        way = rng.integers(4)
        if way == 0:
            del file.keys[key]
        elif way == 1:
            file.keys[key] = np.zeros((0, 0))
        elif way == 2:
            file.keys[key] = np.zeros((1, 1))


def _period(file: Drawn, rng: np.random.Generator, matlab: bool) -> None:
    if rng.random() < 0.4:
        period = float(rng.choice([0.0, 0.1, 0.5, 2.0]))
        file.keys[str(rng.choice(["Ts", "ts", "dt", "sampling_period", "SampleTime", "sample_time"]))] = period
        file.period = period
    elif rng.random() < 0.15:
        key, value = [("Ts", -1.0), ("dt", -0.1), ("h", 0.1), ("fs", 100.0), ("TimeUnit", "minutes")][int(rng.integers(5))]
        file.keys[key] = value
        file.refused.append(key)


def _descriptor(file: Drawn, rng: np.random.Generator, matlab: bool) -> None:
    if rng.random() < 0.25:
        A, B, C = (file.keys[_key(file, letter)] for letter in "ABC")
        D = file.at(1e300)
        n = len(A)
        E = np.eye(n) + 0.3 * rng.standard_normal((n, n))
        if rng.random() < 0.3:
            E[-1] = E[0] if n > 1 else 0.0
            file.refused.append(_key(file, "A").replace("A", "E").replace("a", "e"))
        elif abs(np.linalg.det(E)) < 1e-3:
            E = np.eye(n) * 2.0
        file.keys["E" if "A" in file.keys else "e"] = E
        file.at = lambda s: C @ np.linalg.solve(s * E - A, B) + D
        if not np.array_equal(E, np.eye(n)):
            file.noted.append("E⁻¹")


def _delay(file: Drawn, rng: np.random.Generator, matlab: bool) -> None:
    if rng.random() < 0.25:
        m, p = file.keys[_key(file, "B")].shape[1], len(file.keys[_key(file, "C")])
        key, count = ("InputDelay", m) if rng.random() < 0.5 else ("output_delay", p)
        late = rng.integers(0, 4, count).astype(float) if file.period else rng.choice([0.0, 0.05, 0.2], count)
        if rng.random() < 0.1:
            late[0] = -0.5
            file.refused.append(key)
        elif file.period and rng.random() < 0.1:
            late[0] = 0.5
            file.refused.append(key)
        file.keys[key] = late[:, None] if matlab else late.tolist()
        before, period = file.at, file.period
        file.delayed = bool(late.any())
        if file.delayed:
            file.noted.append("elays of up to")
            file.tolerance = 1e-8 if period else PADE_ERROR

        def shift(s: complex) -> np.ndarray:
            return np.diag(s ** -late if period else np.exp(-s * late))
        file.at = (lambda s: before(s) @ shift(s)) if key == "InputDelay" else (lambda s: shift(s) @ before(s))


def _harmless(file: Drawn, rng: np.random.Generator, matlab: bool) -> None:
    for key in rng.choice(["comment", "description", "author", "notes", "date", "source"], int(rng.integers(3)), replace=False):
        file.keys[str(key)] = "some words"
    if rng.random() < 0.2:
        file.keys["InternalDelay"] = np.zeros((0, 1)) if matlab else []
    if rng.random() < 0.3 and not matlab:
        file.keys["states"] = [f"s{i}" for i in range(len(file.keys[_key(file, "A")]))]


def _strange(file: Drawn, rng: np.random.Generator, matlab: bool) -> None:
    """What changes a plant and is not supported, or says a thing twice."""
    if rng.random() < 0.1:
        file.keys["InternalDelay"] = 0.3
        file.refused.append("InternalDelay")
    if file.period and rng.random() < 0.1:
        other = "sampling_time"
        file.keys[other] = 2 * file.period
        file.refused.append(other)


def _unknown(file: Drawn, rng: np.random.Generator, matlab: bool) -> None:
    """A name that nobody foresaw: named in the refusal of a JSON file, in the note of a workspace."""
    if rng.random() < 0.25:
        key = "".join(rng.choice(list("qwxyvjl"), 6))
        file.keys[key] = float(rng.standard_normal()) if rng.random() < 0.5 else "text"
        (file.noted if matlab else file.refused).append(key)


def _as_json(file: Drawn, rng: np.random.Generator) -> tuple[str, bytes]:
    flat = bool(rng.random() < 0.5)  # as jsonencode of MATLAB writes vectors and scalars
    return "plant.json", json.dumps({key: _plain(value, flat) for key, value in file.keys.items()}).encode()


def _plain(value: Any, flat: bool) -> Any:
    if not isinstance(value, np.ndarray):
        return value
    if not value.size:
        return []
    if flat and value.size == 1:
        return value.item()
    return value.ravel().tolist() if flat and 1 in value.shape else value.tolist()


def _as_mat(file: Drawn, rng: np.random.Generator) -> tuple[str, bytes]:
    way = int(rng.integers(5))
    keys = {key: value for key, value in file.keys.items() if key != "states"}
    if way == 0:
        return "plant.mat", _octave(keys).encode()
    buffer = io.BytesIO()
    if way == 1:
        savemat(buffer, {key: np.atleast_2d(value) if not isinstance(value, str) else value for key, value in keys.items()}, format="4")
    elif way == 2:
        savemat(buffer, {key: csc_matrix(value) if key in "ABC" else value for key, value in keys.items()})
    elif way == 3:
        savemat(buffer, {"sys": keys}, do_compression=True)
    else:
        savemat(buffer, keys, do_compression=bool(rng.random() < 0.5))
    return "plant.mat", buffer.getvalue()


def _octave(keys: dict[str, Any]) -> str:
    """The text that Octave saves."""
    out = ["# Created by Octave 9.2.0, by a script"]
    for key, value in keys.items():
        out.append(f"# name: {key}")
        if isinstance(value, str):
            out += ["# type: string", "# elements: 1", f"# length: {len(value)}", value, "", ""]
        elif np.size(value) == 1:
            out += ["# type: scalar", repr(float(np.reshape(value, -1)[0])), "", ""]
        else:
            rows, columns = value.shape
            out += ["# type: matrix", f"# rows: {rows}", f"# columns: {columns}",
                    *(" " + " ".join(map(repr, row)) for row in value.tolist()), "", ""]
    return "\n".join(out)


def fault(seed: int) -> str:
    """What is wrong with how one drawn file is read, "" where nothing is."""
    name, data, expected = drawn(seed)
    try:
        plant = read_plant(name, data)
    except EngineError as problem:
        said = str(problem)
        if not expected.refused:
            return f"{seed}: refused, {said}"
        if not any(key in said for key in expected.refused) or not said.endswith("."):
            return f"{seed}: none of {expected.refused} is named in: {said}"
        return ""
    if expected.refused:
        return f"{seed}: read in spite of {expected.refused}"
    notes = " ".join(plant.notes)
    silent = [word for word in expected.noted if word not in notes]
    if silent:
        return f"{seed}: {silent} not said in: {notes}"
    return _differs(seed, plant, expected)


def _differs(seed: int, plant: Plant, expected: Drawn) -> str:
    if plant.dt != expected.period:
        return f"{seed}: period {plant.dt} instead of {expected.period}"
    points = np.exp(1j * np.array([0.3, 1.1, 2.5])) * 1.0 if plant.dt else 1j * np.array([0.1, 0.9, 4.0])
    for s in points:
        want = expected.at(complex(s))
        got = plant.C @ np.linalg.solve(s * np.eye(plant.n) - plant.A, plant.B) + plant.D
        if np.abs(got - want).max() > expected.tolerance * max(np.abs(want).max(), 1.0):
            return f"{seed}: another plant by {np.abs(got - want).max():.2g}"
    return ""


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    faults = [said for said in map(fault, range(count)) if said]
    print("\n".join(faults), f"{count} files, {len(faults)} faults", sep="\n")
    sys.exit(bool(faults))
