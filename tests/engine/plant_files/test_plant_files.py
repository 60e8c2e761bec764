"""Plants survive every format exactly; broken, huge and hostile files are one sentence."""

import contextlib
import io
import json
import struct
import zlib

import control
import numpy as np
import pytest
import scipy.sparse
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from laws import each
from scipy.io import savemat

from observer_lab.engine import EngineError, Plant, from_control, from_json, from_mat, load_plant, to_control, to_json, to_mat

FINITE = st.floats(allow_nan=False, allow_infinity=False)
WORD = st.text(st.characters(whitelist_categories=("L", "N"), whitelist_characters=" _-()ẋ"), min_size=1, max_size=12)
CART = Plant([[0, 1], [-1, -0.5]], [[0], [1]], [[1, 0]], [[0.25]], 0.01, ("position", "速度"), ("force",), ("z",),
             (("position", "m"), ("force", "N")), "cart 1")


@st.composite
def plants(draw):
    n, m, p = draw(st.integers(1, 5)), draw(st.integers(1, 3)), draw(st.integers(1, 3))
    A, B, C, D = (draw(arrays(float, shape, elements=FINITE)) for shape in ((n, n), (n, m), (p, n), (p, m)))
    names = [tuple(draw(st.lists(WORD, min_size=k, max_size=k, unique=True))) for k in (n, m, p)]
    units = {name: "m/s²" for name in names[0]}
    return Plant(A, B, C, D, draw(st.floats(0, 10)), *names, units, draw(WORD))  # type: ignore[arg-type]


def mat_bytes(plant):
    buffer = io.BytesIO()
    to_mat(plant, buffer)
    return buffer.getvalue()


def same(one, two):
    return one == two and one.units == two.units and one.D.tobytes() == two.D.tobytes()


@pytest.mark.slow
@given(plants())
@settings(max_examples=60)
def test_json_and_mat_give_back_every_bit(plant):
    assert same(from_json(to_json(plant)), plant)
    assert same(from_mat(mat_bytes(plant)), plant)


def test_files_give_back_the_plant_by_their_suffix(tmp_path):
    (tmp_path / "cart.JSON").write_text(to_json(CART), encoding="utf-8")
    to_mat(CART, tmp_path / "cart.mat")
    assert same(load_plant(tmp_path / "cart.JSON"), CART)
    assert same(load_plant(str(tmp_path / "cart.mat")), CART)


def test_control_gives_back_names_units_and_period():
    system = to_control(CART)
    assert (system.dt, system.input_labels, system.state_labels) == (0.01, ["force"], ["position", "速度"])
    assert same(from_control(system), CART)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_control_sees_the_same_transfer_function(seed):
    rng = np.random.default_rng(seed)
    plant = Plant(*(rng.standard_normal(shape) for shape in ((3, 3), (3, 2), (2, 3), (2, 2))))
    s = 1.3j
    ours = plant.C @ np.linalg.solve(s * np.eye(3) - plant.A, plant.B) + plant.D
    np.testing.assert_allclose(to_control(plant)(s), ours, rtol=1e-9, atol=1e-9)
    assert to_control(plant).isctime()


def test_controls_own_default_names_become_ours():
    plant = from_control(control.ss([[-1]], [[1]], [[1]], [[0]]))
    assert (plant.state_names, plant.input_names, plant.name, plant.dt) == (("x1",), ("u1",), "", 0.0)


def test_what_control_cannot_say_is_refused():
    with pytest.raises(EngineError, match=r"control\.ss"):
        from_control(control.frd([1, 2], [1, 2]))  # type: ignore[arg-type]
    with pytest.raises(EngineError, match="period"):
        from_control(control.ss([[0.5]], [[1]], [[1]], [[0]], True))
    with pytest.raises(EngineError, match="Two signals"):
        to_control(Plant(-np.eye(2), np.ones((2, 1)), np.ones((1, 2)), state_names=("x", "x")))
    assert to_control(Plant([[-1]], [[1]], [[1]], name="1.5 kg")).name == "1_5 kg"


def edited(**changes):
    return json.dumps({**json.loads(to_json(CART)), **changes})


@each(("text", "says"), [
    ("", "JSON"), ("{", "line 1, column 2"), ("{\n\"A\": 1,,", "line 2, column 8"),
    ("[1]", "object"), ("null", "object"), ("[" * 100_000, "JSON"),
    ("{\"A\": " + "9" * 5000 + "}", "JSON|real|rows"), ("{}", "no matrix A"), (" " * 1_000_001, "1 MB"),
    (edited(A="eye(2)"), "rows"), (edited(A=[[1, 2], [3]]), "equally long"), (edited(A=[]), "empty"),
    (edited(A=[[[1]]]), "real numbers"), (edited(A=[[True, 0], [0, 1]]), "real numbers"),
    (edited(A=[["1", 0], [0, 1]]), "real numbers"), (edited(A=[[None, 0], [0, 1]]), "real numbers"),
    (edited(A=[[10**400, 0], [0, 1]]), "too large"), (edited(A=[[float("nan"), 0], [0, 1]]), "NaN"),
    (edited(A=[[float("inf"), 0], [0, 1]]), "Infinity"), (edited(A=[[0] * 201] * 201), "200"),
    (to_json(CART).replace("0.25", "1e999"), "finite"),
    (edited(B=[[1]]), "B must have 2 rows"), (edited(B=[[0] * 17] * 2, D=[[0] * 17], inputs=[]), "16"),
    (edited(dt=-1), "dt"), (edited(dt="1"), "dt"), (edited(dt=True), "dt"), (edited(dt=[1]), "dt"),
    (edited(states="xy"), "list"), (edited(states=["x"]), "names"), (edited(states=["x", 2]), "text"),
    (edited(name="n" * 101), "100"), (edited(name="\u001b[2J"), "plain text"),
    (edited(units=["m"]), "units"), (edited(units={"x": 1}), "unit"), (edited(format="zip"), "version 1"),
    (edited(version=2), "version 1"),
])
def test_broken_json_is_one_sentence(text, says):
    with pytest.raises(EngineError, match=says) as caught:
        from_json(text)
    assert str(caught.value).endswith(".") and len(str(caught.value)) < 200
    assert "again" not in str(caught.value), "a file written by hand is not saved again: say what to change in it"


@pytest.mark.slow
@given(st.recursive(st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
                    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
                    max_leaves=8),
       st.sampled_from(["A", "B", "C", "D", "dt", "name", "states", "inputs", "outputs", "units", "format", "version"]))
@settings(max_examples=200)
def test_any_value_under_any_key_is_a_plant_or_a_sentence(value, key):
    try:
        plant = from_json(edited(**{key: value}))
    except EngineError:
        return
    assert plant.n == 2


def variables(**changes):
    buffer = io.BytesIO()
    savemat(buffer, {"A": CART.A, "B": CART.B, "C": CART.C, **changes})
    return buffer.getvalue()


def test_mat_written_by_hand_needs_only_the_matrices():
    plant = from_mat(variables(other=np.ones((50, 50)), Ts=0.5))
    np.testing.assert_array_equal(plant.A, CART.A)
    assert plant.dt == 0.5 and plant.state_names == ("x1", "x2")
    np.testing.assert_array_equal(plant.D, [[0]])


def test_integers_and_big_endian_files_are_read():
    whole = variables(A=np.array([[0, 1], [-2, -3]], dtype=np.int8), B=np.array([[0], [1]], dtype=np.uint16))
    np.testing.assert_array_equal(from_mat(whole).A, [[0, 1], [-2, -3]])
    body = b""
    for name, value in ((b"A", -2), (b"B", 3), (b"C", 5)):
        part = struct.pack(">IIII IIii HH4s IId", 6, 8, 6, 0, 5, 8, 1, 1, 1, 1, name, 9, 8, value)
        body += struct.pack(">II", 14, len(part)) + part
    plant = from_mat(b"by hand".ljust(124) + b"\x01\x00MI" + body)
    assert (plant.A.item(), plant.B.item(), plant.C.item()) == (-2, 3, 5)


def test_labels_written_by_matlab_as_utf16_are_read():
    text = json.dumps({"states": ["速度"]}, ensure_ascii=False)
    raw = text.encode("utf-16-le")
    parts = [struct.pack("<IIII", 6, 8, 4, 0), struct.pack("<IIii", 5, 8, 1, len(text)),
             struct.pack("<II8s", 1, 6, b"labels"), struct.pack("<II", 4, len(raw)) + raw + bytes(-len(raw) % 8)]
    body = b"".join(parts)
    buffer = io.BytesIO()
    savemat(buffer, {"A": [[-1]], "B": [[1]], "C": [[2]]})
    assert from_mat(buffer.getvalue() + struct.pack("<II", 14, len(body)) + body).state_names == ("速度",)


def bomb():
    """200 MB of zeros in 200 kB, dressed as one compressed variable."""
    packed = zlib.compress(bytes(200_000_000), 9)
    return variables()[:128] + struct.pack("<II", 15, len(packed)) + packed


@each(("data", "says"), [
    (b"", "readable"), (b"\x00" * 40, "readable|matrix"), (b"hello world" * 50, "readable"),
    (bytes(1_000_001), "1 MB"), (variables()[:200], "readable|no matrix"),
    (b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(100), "7.3|-v7"),
    (variables(A=np.eye(201)), "200×200"), (variables(A="eye"), "full real matrix"),
    (variables(A=scipy.sparse.csc_matrix((201, 201))), "full real matrix"),
    (variables(A=np.array([[1, "a"], [2, "b"]], dtype=object)), "full real matrix"),
    (variables(A={"deep": np.eye(2)}), "full real matrix"), (variables(A=np.zeros((2, 2, 2))), "full real matrix"),
    (variables(A=np.array([[1j, 0], [0, 1]])), "real"), (variables(A=np.array([[np.nan, 0], [0, 1]])), "finite"),
    (variables(B=np.ones((3, 1))), "B must have 2 rows"), (variables(Ts=np.ones((2, 2))), "Ts"),
    (variables(Ts=-1.0), "Ts is −1"), (variables(Ts=-2.0), "Ts must be 0"), (b"\x00" * 128, "readable"),
    (variables(labels="{"), "JSON"), (variables(labels="[1]"), "object"),
    (variables(labels=json.dumps({"states": ["x"]})), "names"),
])
def test_broken_mat_is_one_sentence(data, says):
    with pytest.raises(EngineError, match=says) as caught:
        from_mat(data)
    assert str(caught.value).endswith(".") and len(str(caught.value)) < 200


@pytest.mark.slow
def test_a_compressed_bomb_is_not_unpacked():
    import tracemalloc

    data = bomb()
    tracemalloc.start()
    try:
        with pytest.raises(EngineError, match="1 MB"):
            from_mat(data)
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), min_size=1, max_size=12), st.booleans())
@settings(max_examples=200)
def test_flipped_bytes_give_a_plant_or_a_sentence(flips, packed):
    """scipy.io.loadmat ends the whole process with a bus error on some of these."""
    data = bytearray(mat_bytes(CART) if packed else variables(D=CART.D, Ts=0.1))
    for place, value in flips:
        data[place % len(data)] = value
    with contextlib.suppress(EngineError):
        from_mat(bytes(data))


@pytest.mark.parametrize("name", ["none.json", "none.mat", "plant.csv", "plant"])
def test_missing_or_unknown_files_are_one_sentence_without_the_folder(tmp_path, name):
    with pytest.raises(EngineError) as caught:
        load_plant(tmp_path / name)
    assert str(tmp_path) not in str(caught.value)


def test_huge_or_binary_json_files_are_refused(tmp_path):
    (tmp_path / "big.json").write_bytes(b" " * 1_000_001)
    (tmp_path / "bin.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(EngineError, match="1 MB"):
        load_plant(tmp_path / "big.json")
    with pytest.raises(EngineError, match="UTF-8"):
        load_plant(tmp_path / "bin.json")


def test_too_many_states_are_not_written():
    with pytest.raises(EngineError, match="200"):
        to_json(Plant(-np.eye(201), np.ones((201, 1)), np.ones((1, 201))))
