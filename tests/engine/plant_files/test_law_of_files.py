"""Every key of a plant file is used, known as harmless, or named; what comes of it is the plant that the file means."""

from __future__ import annotations

import io
import json
import struct

import control
import numpy as np
import pytest
import scipy.signal
from generated_files import drawn, fault
from laws import each
from scipy.io import savemat
from scipy.linalg import block_diag

from observer_lab.engine import EngineError, Plant, frequency_response, from_control, from_json, from_mat, from_scipy, to_json
from observer_lab.engine.plant_files import read_plant, reduced_to

SAMPLED = 120  # of the generated files; `python tests/engine/plant_files/generated_files.py 2000` takes more


def test_generated_files_are_read_rightly_or_refused_by_name() -> None:
    assert not [said for said in map(fault, range(1000, 1000 + SAMPLED)) if said]
    kinds = [drawn(seed) for seed in range(1000, 1000 + SAMPLED)]
    assert sum(not expected.refused for *_, expected in kinds) > SAMPLED // 3
    assert sum(bool(expected.refused) for *_, expected in kinds) > SAMPLED // 6


def response(plant: Plant, s: complex) -> np.ndarray:
    return plant.C @ np.linalg.solve(s * np.eye(plant.n) - plant.A, plant.B) + plant.D


def js(**keys: object) -> Plant:
    return from_json(json.dumps(keys))


def mat(**keys: object) -> Plant:
    buffer = io.BytesIO()
    savemat(buffer, keys)
    return from_mat(buffer.getvalue())


TWO = {"A": [[0, 1], [-2, -3]], "B": [[0], [1]], "C": [[1, 0]]}


@each(("keys", "says"), [
    ({**TWO, "E": [[1, 0], [0, 0]]}, "E is singular"), ({**TWO, "E": [[1]]}, "E must be 2×2"), ({**TWO, "Ts": 0.1, "dt": 0.2}, "Ts and dt"),
    ({**TWO, "Tz": 0.1}, "Tz"), ({**TWO, "InputDelay": [1, 2, 3]}, "InputDelay must have 1"), ({**TWO, "OutputDelay": -1}, "OutputDelay"),
    ({**TWO, "Ts": 0.1, "InputDelay": 0.25}, "whole numbers of samples"), ({**TWO, "F": [[0, 0], [0, 1]], "delay": 0.1}, "bilinear"),
    ({**TWO, "a": [[1]]}, "key a "), ({**TWO, "num": [1], "den": [1, 1]}, "key num"), ({"num": [1]}, "num and den"),
    ({"num": [1, 0, 0], "den": [1, 1]}, "more zeros than poles"), ({"num": [1], "den": [0]}, "denominator"),
    ({"zeros": [], "poles": [-1]}, "gain"), ({"zeros": [[0, 1]], "poles": [-1, -2], "gain": 1}, "conjugate"),
    ({"num": [1], "den": [1, 0.5], "Variable": "z"}, "Variable is z"), ({"num": [2], "den": [1]}, "without states"),
    ({**TWO, "changes": [["reduced", {"before": "<b>"}]]}, "changes"), ({**TWO, "changes": [["none", {}]]}, "changes"),
    ({"one": TWO, "two": TWO}, "several plants"),
])
def test_what_cannot_be_taken_is_named(keys: dict[str, object], says: str) -> None:
    with pytest.raises(EngineError, match=says):
        js(**keys)


def test_a_key_that_stands_twice_is_refused() -> None:
    with pytest.raises(EngineError, match="key A stands twice"):
        from_json('{"A": [[1]], "A": [[2]], "B": [[1]], "C": [[1]]}')


@each("seed", range(12))
def test_a_transfer_function_gives_its_own_values_with_the_least_states(seed: int) -> None:
    """Against the polynomials themselves; a common factor is cancelled and said."""
    rng = np.random.default_rng(seed)
    poles, zeros = -rng.uniform(0.3, 5, 3), rng.uniform(-4, 4, 2)
    common = [] if seed % 2 else [-1.7]
    num, den = 2.5 * np.poly([*zeros, *common]), np.poly([*poles, *common])
    for plant in (js(num=num.tolist(), den=den.tolist()), js(zeros=[*zeros, *common], poles=[*poles, *common], gain=2.5),
                  mat(num=num, den=den),
                  js(Numerator=[num.tolist()], Denominator=[den.tolist()], Ts=0, Variable="s"), from_control(control.tf(num, den)),
                  from_scipy(scipy.signal.lti(num, den)), from_scipy(scipy.signal.lti([*zeros, *common], [*poles, *common], 2.5))):
        assert plant.n == 3 and any("transfer function" in note for note in plant.notes)
        assert any("cancels 1 " in note for note in plant.notes) == bool(common)
        for s in (0.3j, 2j, 1 + 5j):
            want = np.polyval(num, s) / np.polyval(den, s)
            assert abs(response(plant, s).item() - want) < 1e-6 * abs(want) + 1e-9


def test_several_channels_share_what_they_can() -> None:
    """[1/(s+1), 2/(s+1); 3/(s+2), 0]: three poles are needed, four fractions are given."""
    plant = js(num=[[[1], [2]], [[3], [0]]], den=[[[1, 1], [1, 1]], [[1, 2], [1]]], outputs=["a", "b"])
    s = 0.7j
    np.testing.assert_allclose(response(plant, s), [[1 / (s + 1), 2 / (s + 1)], [3 / (s + 2), 0]], atol=1e-9)
    assert plant.n == 2 and plant.output_names == ("a", "b")


def test_powers_of_the_delay_are_powers_of_z() -> None:
    plant = js(num=[0, 1], den=[1, -0.5], Ts=0.1, Variable="z^-1")
    assert abs(response(plant, np.exp(0.4j)).item() - np.exp(-0.4j) / (1 - 0.5 * np.exp(-0.4j))) < 1e-12


def test_sampled_systems_of_scipy_and_control_keep_their_period() -> None:
    assert from_scipy(scipy.signal.dlti([1], [1, -0.5], dt=0.2)).dt == from_control(control.tf([1], [1, -0.5], 0.2)).dt == 0.2
    assert from_scipy(scipy.signal.lti([[-1]], [[1]], [[1]], [[0]])).n == 1
    for unknown in (scipy.signal.dlti([1], [1, -0.5]), "text", None):
        with pytest.raises(EngineError, match=r"dt=True|scipy\.signal"):
            from_scipy(unknown)


def test_a_struct_as_matlab_gets_it_from_an_object_is_read() -> None:
    empty = np.zeros((0, 0))
    plant = mat(sys={**TWO, "D": 0, "E": empty, "Scaled": 0, "StateName": np.array([["p"], ["v"]], dtype=object), "InternalDelay": empty,
                     "InputDelay": 0.0, "TimeUnit": "seconds", "Ts": 0.1, "Name": "cart", "Notes": "x",
                     "InputName": np.array([[""]], dtype=object)},
                other=np.ones((50, 50)))
    assert (plant.dt, plant.name, plant.state_names, plant.input_names) == (0.1, "cart", ("p", "v"), ("u1",))
    assert [note for note in plant.notes if "other" in note]


def opaque(name: bytes, of: bytes) -> bytes:
    """An object of a newer class, as MATLAB writes it: no dimensions before its name."""
    def element(kind: int, raw: bytes) -> bytes:
        return struct.pack("<II", kind, len(raw)) + raw + bytes(-len(raw) % 8)
    body = element(6, struct.pack("<II", 17, 0)) + element(1, name) + element(1, b"MCOS") + element(1, of) + element(14, b"")
    return element(14, body)


@pytest.mark.parametrize("name", [b"s", b"sysd", b"system_1", b"a_very_long_name_of_an_object"])
def test_objects_beside_matrices_are_passed_over_and_named_where_they_stand_alone(name: bytes) -> None:
    buffer = io.BytesIO()
    savemat(buffer, TWO)
    plant = from_mat(buffer.getvalue() + opaque(name, b"ss"))
    assert plant.n == 2 and any(name.decode()[:24] in note for note in plant.notes)
    with pytest.raises(EngineError, match=rf"{name.decode()}.*class ss.*ssdata"):
        from_mat(buffer.getvalue()[:128] + opaque(name, b"ss"))


def test_a_mat_file_under_the_name_of_json_is_read() -> None:
    buffer = io.BytesIO()
    savemat(buffer, TWO)
    assert read_plant("plant.json", buffer.getvalue()).n == 2


def test_notes_travel_with_the_plant() -> None:
    plant = js(**TWO, E=[[2, 0], [0, 1]], InputDelay=0.1)
    again = from_json(to_json(plant))
    assert again.notes == plant.notes and len(plant.notes) == 2 and again == plant


def chain(n: int, rng: np.random.Generator, kind: int) -> Plant:
    if kind == 0:
        A = block_diag(*[[[0, w], [-w, -0.05 * w]] for w in np.geomspace(1, 1e3, n // 2)])
    elif kind == 1:
        A = np.diag(-2.0 * np.ones(n)) + np.eye(n, k=1) + np.eye(n, k=-1)
    elif kind == 2:
        A = 0.9 * np.linalg.qr(rng.standard_normal((n, n)))[0]
    else:
        A = rng.standard_normal((n, n)) - np.sqrt(n) * 0.9 * np.eye(n)  # some poles are unstable
    return Plant(A, rng.standard_normal((n, 2)), rng.standard_normal((2, n)), dt=0.1 if kind == 2 else 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", range(4))
@pytest.mark.parametrize("n", [32, 90, 200])
def test_a_reduced_plant_keeps_its_bound(kind: int, n: int) -> None:
    """The error over a dense grid never passes the bound that the note states; unstable poles stay."""
    plant = chain(n, np.random.default_rng(n), kind)
    found = reduced_to(plant, 30)
    assert found.n <= 30 and found.notes
    bound = float(dict(found.notes[-1].values)["bound"])  # type: ignore[attr-defined]
    grid = np.linspace(1e-3, np.pi / 0.1, 800) if plant.dt else np.geomspace(1e-3, 1e4, 1500)
    one, two = (frequency_response(p.A, p.B, p.C, p.D, grid, dt=p.dt) for p in (plant, found))
    assert np.linalg.norm(one - two, 2, axis=(1, 2)).max() <= bound * (1 + 1e-6)
    outside = [sum(np.abs(p.poles) >= 1) if p.dt else sum(p.poles.real >= 0) for p in (plant, found)]
    assert outside[0] == outside[1]


def test_too_many_unstable_states_are_refused() -> None:
    with pytest.raises(EngineError, match="40 of them are not stable"):
        reduced_to(Plant(np.eye(40), np.ones((40, 1)), np.ones((1, 40))), 30)
