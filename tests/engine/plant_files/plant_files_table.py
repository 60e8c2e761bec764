"""Print what each of fifty kinds of plant file gives: `python tests/engine/plant_files/plant_files_table.py`."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
from generated_files import _octave
from scipy.io import savemat
from scipy.sparse import csc_matrix

from observer_lab.engine import EngineError
from observer_lab.engine.plant_files import read_plant

TWO: dict[str, Any] = {"A": [[0, 1], [-2, -3]], "B": [[0], [1]], "C": [[1, 0]]}
FRACTION: dict[str, Any] = {"num": [1, 2], "den": [1, 3, 2]}


def js(**keys: Any) -> tuple[str, bytes]:
    """A JSON file."""
    return "plant.json", json.dumps(keys).encode()


def mat(version: str = "5", packed: bool = False, **keys: Any) -> tuple[str, bytes]:
    """A .mat file."""
    file = io.BytesIO()
    savemat(file, keys, format=version, do_compression=packed)
    return "plant.mat", file.getvalue()


def octave(**keys: Any) -> tuple[str, bytes]:
    """A text of Octave."""
    return "plant.mat", _octave({key: np.array(value, dtype=float) for key, value in keys.items()}).encode()


def with_object(name: bytes, **keys: Any) -> tuple[str, bytes]:
    """A .mat file with an object of MATLAB's class ss beside its variables."""
    def element(kind: int, raw: bytes) -> bytes:
        return struct.pack("<II", kind, len(raw)) + raw + bytes(-len(raw) % 8)
    body = element(6, struct.pack("<II", 17, 0)) + element(1, name) + element(1, b"MCOS") + element(1, b"ss") + element(14, b"")
    data = mat(**(keys or TWO))[1]
    return "plant.mat", (data if keys else data[:128]) + element(14, body)


def files() -> Iterator[tuple[str, tuple[str, bytes]]]:
    """What each file is, and the file."""
    yield "JSON, A B C", js(**TWO)
    for key in ("Ts", "ts", "dt", "sampling_period", "SampleTime"):
        yield f"JSON, {key} = 0.1", js(**TWO, **{key: 0.1})
    yield "JSON, Ts = −1", js(**TWO, Ts=-1)
    yield "JSON, Ts and dt differ", js(**TWO, Ts=0.1, dt=0.2)
    yield "JSON, h = 0.1", js(**TWO, h=0.1)
    yield "JSON, fs = 10", js(**TWO, fs=10)
    yield "JSON, TimeUnit minutes", js(**TWO, TimeUnit="minutes")
    yield "JSON, E regular", js(**TWO, E=[[2, 0], [0, 1]])
    yield "JSON, E = I", js(**TWO, E=[[1, 0], [0, 1]])
    yield "JSON, E singular", js(**TWO, E=[[1, 0], [0, 0]])
    yield "JSON, InputDelay 0.2 s", js(**TWO, InputDelay=0.2)
    yield "JSON, OutputDelay 3 samples", js(**TWO, Ts=0.1, OutputDelay=3)
    yield "JSON, InputDelay 0.5 samples", js(**TWO, Ts=0.1, InputDelay=0.5)
    yield "JSON, InternalDelay", js(**TWO, InternalDelay=[0.1])
    yield "jsonencode: flat vectors, bare scalar", js(A=[[0, 1], [-2, -3]], B=[0, 1], C=[1, 0], D=0)
    yield "jsonencode: one state", js(A=-1, B=1, C=1, D=0)
    yield "JSON, D = 0 for two outputs", js(**TWO | {"C": [[1, 0], [0, 1]]}, D=0)
    yield "JSON, D = []", js(**TWO, D=[])
    yield "JSON, lower case", js(a=TWO["A"], b=TWO["B"], c=TWO["C"])
    yield "JSON, A and a", js(**TWO, a=[[1]])
    yield "JSON, a comment", js(**TWO, comment="from the lab")
    yield "JSON, a key nobody knows", js(**TWO, Tz=0.1)
    yield "JSON, a key twice", ("plant.json", b'{"A": [[1]], "A": [[2]], "B": [[1]], "C": [[1]]}')
    yield "JSON, a plant in an object", js(sys=TWO)
    yield "JSON, Chinese names", js(**TWO, states=["角度", "角速度"])
    yield "JSON, num and den", js(**FRACTION)
    yield "JSON, num and den, sampled", js(num=[1], den=[1, -0.5], Ts=0.1)
    yield "JSON, 2×2 fractions", js(num=[[[1], [2]], [[3], [0]]], den=[[[1, 1], [1, 1]], [[1, 2], [1]]])
    yield "JSON, zeros, poles, gain", js(zeros=[-2], poles=[[-1, 1], [-1, -1]], gain=3)
    yield "JSON, improper fraction", js(num=[1, 0, 0], den=[1, 1])
    yield "JSON, one lonely complex pole", js(zeros=[], poles=[[-1, 1]], gain=1)
    yield "-v6", mat(**TWO, Ts=0.1)
    yield "-v7", mat(packed=True, **TWO, Ts=0.1)
    yield "-v4", mat("4", **TWO, Ts=0.1)
    yield "Octave's text", octave(**TWO, Ts=0.1)
    yield "sparse", mat(**{key: csc_matrix(np.array(value, dtype=float)) for key, value in TWO.items()})
    yield "complex", mat(**TWO | {"A": [[1j, 0], [0, 1]]})
    yield "D = []", mat(**TWO, D=np.zeros((0, 0)))
    yield "a text beside the matrices", mat(**TWO, labels="my plant")
    yield "a workspace", mat(**TWO, Q=np.eye(2), x0=[1, 2], t=np.arange(5.0))
    yield "an object beside the matrices", with_object(b"sysd", **TWO)
    yield "an object alone", with_object(b"sysd")
    yield "a struct", mat(sys={**TWO, "Ts": 0.1})
    yield "two structs", mat(one=TWO, two=TWO)
    yield "num and den in .mat", mat(**FRACTION)
    yield "201 states", mat(A=np.eye(201), B=np.ones((201, 1)), C=np.ones((1, 201)))
    yield "version 7.3", ("plant.mat", b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(100))
    yield "a picture", ("plant.mat", b"\x89PNG" + bytes(300))


def row(name: str, data: bytes) -> str:
    """What a file gives: the plant and its notes, or the refusal."""
    try:
        plant = read_plant(name, data)
    except EngineError as problem:
        return f"refused: {problem}"
    return " ".join([f"{plant.n} states, {plant.m} in, {plant.p} out, dt {plant.dt:g}.", *plant.notes])


if __name__ == "__main__":
    for title, file in files():
        print(f"{title:<40}{row(*file)}")
