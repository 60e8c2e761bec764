"""The engine beside python-control: shared names give equal numbers, gains act as arrays, reprs are short, imports are few."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import control
import numpy as np
import pytest
from public_calls import calls, the_call
from scipy import signal

from observer_lab import engine
from observer_lab.engine import Belief, EngineError, KalmanFilter, Plant, Scenario, lqe, lqr, observability, place, simulate

A, B, C = np.array([[0.0, 1.0], [-2.0, -3.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
Q, R = np.diag([10.0, 1.0]), np.array([[0.5]])
LINES = """
sys = ct.ss(A, B, C, 0)
den = ct.tf([1, 3], [1, 3, 2])
K, S, E = ct.lqr(A, B, Q, R)
closed = np.sort_complex(np.linalg.eigvals(A - B @ K))
Ks, Ss, Es = ct.lqr(sys, Q, R)
L, P, F = ct.lqe(A, B, C, np.eye(1), R)
Ls, Ps, Fs = ct.lqe(sys, np.eye(1), R)
Kp = np.asarray(ct.place(A, B, [-4, -5]))
Ka = np.ravel(ct.acker(A, B, [-4, -5]))
reach = np.linalg.matrix_rank(ct.ctrb(A, B)); seen = ct.obsv(A, C)
X, Lx, G = ct.care(A, B, Q, R); Y, Ly, H = ct.dare(A / 4, B, Q, R)
V, D = ct.lyap(A, Q), ct.dlyap(A / 4, Q)
roots = np.sort_complex(ct.poles(den)); zeros = ct.zeros(den)
sampled = ct.c2d(sys, 0.1).A
Kd, Sd, Ed = ct.dlqr(A / 4, B, Q, R); Ld, Pd, Fd = ct.dlqe(A / 4, B, C, np.eye(1), R)
"""


def played(library: object) -> dict[str, np.ndarray]:
    names = {"ct": library, "np": np, "A": A, "B": B, "C": C, "Q": Q, "R": R}
    given = set(names)
    exec(LINES, names)
    return {name: value for name, value in names.items() if name not in given | {"__builtins__", "sys", "den"}}


def test_fifteen_lines_for_python_control_give_its_numbers() -> None:
    ours, theirs = played(engine), played(control)
    assert len(LINES.strip().splitlines()) >= 15 and ours.keys() == theirs.keys()
    for name, value in theirs.items():
        value, mine = np.asarray(value), np.asarray(ours[name])
        if name in ("E", "Es", "F", "Fs", "Lx", "Ly", "Ed", "Fd"):  # eigenvalues come in any order
            value, mine = np.sort_complex(value), np.sort_complex(mine)
        np.testing.assert_allclose(mine, value, rtol=1e-8, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("plant", [Plant(A, B, C), control.ss(A, B, C, 0), signal.lti(A, B, C, np.zeros((1, 1)))],
                         ids=["ours", "python-control", "scipy"])
def test_a_plant_stands_where_matrices_stand(plant: object) -> None:
    def same(call: object, *rest: object, lead: tuple[np.ndarray, ...]) -> None:
        np.testing.assert_array_equal(np.asarray(call(plant, *rest)), np.asarray(call(*lead, *rest)))  # type: ignore[operator]

    same(engine.lqr, Q, R, lead=(A, B))
    same(engine.place, [-3, -4], lead=(A, B))
    same(engine.observer_gain, [-3, -4], lead=(A, C))
    same(engine.lqe, np.eye(1), R, lead=(A, B, C))
    same(engine.frequency_response, [1.0, 2.0], lead=(A, B, C, np.zeros((1, 1))))
    assert observability(A, C).rank == observability(plant).rank == 2  # type: ignore[call-arg, arg-type]
    assert engine.gramians(plant).controllability == pytest.approx(engine.gramians(Plant(A, B, C)).controllability)  # type: ignore[arg-type]
    assert engine.closed_loop(plant, engine.lqr(plant, Q, R), lqe(plant, np.eye(1), R)).poles.size == 4  # type: ignore[arg-type, call-arg]


@pytest.mark.parametrize("system", [control.tf([1, 3], [2, 6, 4]), signal.lti([1, 3], [2, 6, 4]),
                                    signal.ZerosPolesGain([-3], [-1, -2], 0.5), control.tf([2, 7, 7], [2, 6, 4])])
def test_a_transfer_function_is_a_plant(system: object) -> None:
    found = engine.frequency_response(system, [0.1, 1.0, 10.0])[:, 0, 0]  # type: ignore[call-arg]
    s = 1j * np.array([0.1, 1.0, 10.0])
    wanted = (2 * s**2 + 7 * s + 7 if system is not None and "7" in str(getattr(system, "num", "")) else s + 3) / (2 * s**2 + 6 * s + 4)
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


def test_a_transfer_matrix_is_a_plant_entry_by_entry() -> None:
    system = control.tf([[[1], [1, 2]], [[0], [3]]], [[[1, 1], [1, 3]], [[1], [1, 0.5]]])
    s = 1j * 0.7
    found = engine.frequency_response(system, [0.7])[0]  # type: ignore[call-arg]
    np.testing.assert_allclose(found, [[1 / (s + 1), (s + 2) / (s + 3)], [0, 3 / (s + 0.5)]], atol=1e-13)


def test_gramians_by_their_field_names_solve_lyapunovs_equations() -> None:
    Wc, Wo = (engine.gram(Plant(A, B, C), kind) for kind in "co")
    np.testing.assert_allclose(A @ Wc + Wc @ A.T + B @ B.T, 0, atol=1e-12)
    np.testing.assert_allclose(A.T @ Wo + Wo @ A + C.T @ C, 0, atol=1e-12)
    np.testing.assert_allclose(np.square(engine.hsvd(Plant(A, B, C))), np.sort(np.linalg.eigvals(Wc @ Wo).real)[::-1], rtol=1e-9)


def test_what_does_not_fit_a_plant_is_said() -> None:
    sampled = Plant(A / 4, B, C, dt=0.1)
    for call, match in ((lambda: lqr(sampled, Q, R), "use dlqr"), (lambda: engine.dlqr(Plant(A, B, C), Q, R), "use lqr"),  # type: ignore[call-arg]
                        (lambda: lqr(Plant(A, B, C), B, Q, R), "not both"),
                        (lambda: place(control.tf([1, 0, 0], [1, 1]), [-1]), "more zeros"),  # type: ignore[call-arg]
                        (lambda: observability("plant"), "plant must be a Plant; text was given"),  # type: ignore[arg-type]
                        (lambda: observability(control.ss(A, B, C, 0, True)), "period")):  # type: ignore[arg-type]
        with pytest.raises(EngineError, match=match):
            call()


def test_gains_unpack_and_act_as_arrays() -> None:
    found, x = lqr(A, B, Q, R), np.array([1.0, 2.0])
    K, S, E = found
    assert K is found.gain and S is found.solution and E is found.poles and found[0] is K
    placed = place(A, B, [-4, -5])
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(A - B @ placed).real), [-5, -4])
    for record in (found, placed):
        np.testing.assert_array_equal(record @ x, record.gain @ x)
        np.testing.assert_array_equal(-record + 2 * record - record / 2, record.gain / 2)
        np.testing.assert_array_equal(1 - record, 1 - record.gain)
        np.testing.assert_array_equal(np.vstack([record, record]), np.vstack([record.gain, record.gain]))
        assert record.shape == (1, 2) and record.T.shape == (2, 1) and np.array(record, dtype=complex).dtype == complex
    np.testing.assert_array_equal(placed[0], placed.gain[0])


def test_a_filter_starts_from_a_pair_or_from_its_steady_covariance() -> None:
    kf, y = KalmanFilter(A / 4, B, C, np.eye(2), R), np.ones((5, 1))
    np.testing.assert_array_equal(kf.run(([0, 0], np.eye(2)), y).means, kf.run(Belief([0, 0], np.eye(2)), y).means)
    np.testing.assert_array_equal(kf.run(y).means, kf.run(Belief([0, 0], kf.steady.solution), y).means)
    with pytest.raises(EngineError, match=r"start must be a Belief; an array of shape \(2,\) was given"):
        kf.run(np.zeros(2), y)


def test_the_repr_of_every_record_is_short_and_its_table_is_html() -> None:
    kept = [Plant(np.eye(30) / 2, np.ones((30, 9)), np.ones((9, 30)), name="a long name " * 9), lqr(A, B, Q, R), place(A, B, [-1, -2])]
    for name, arguments in calls().items():
        if name.count(".") == 1 and name.split(".")[0] not in ("systems",) and "simulate" not in name:
            kept.append(the_call(name)(**arguments))
    kept += [simulate(Scenario(Plant(A, B, C), K=[[1, 1]], horizon=1.0)), KalmanFilter(A / 4, B, C, np.eye(2), R).run(np.ones((5, 1)))]
    records = [record for record in kept if hasattr(record, "_repr_html_") and type(record).__module__.startswith("observer_lab")]
    assert len(records) > 40
    assert [type(record).__name__ for record in records if len(repr(record)) > 200 or "\n" in repr(record)] == []
    assert all(record._repr_html_().startswith("<table>") and record._repr_html_().endswith("</table>") for record in records)
    html = Plant(A, B, C, name="<b>")._repr_html_()  # type: ignore[attr-defined]
    assert "<b>" not in html and "poles" in html and "−3" in html


def test_poles_and_runs_plot_themselves(monkeypatch: pytest.MonkeyPatch) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    plant = Plant(A, B, C)
    axes = plant.poles.plot()  # type: ignore[attr-defined]
    np.testing.assert_allclose(sorted(axes.lines[-1].get_xdata()), [-2, -1])
    assert len(lqr(A, B, Q, R).poles.plot(sampled=True).lines) == 2  # type: ignore[attr-defined]
    run = simulate(Scenario(plant, K=[[1, 1]], L=[[1], [1]], x0=[1, 0], horizon=1.0))
    panels = run.plot()
    assert [panel.get_ylabel() for panel in panels] == ["x1", "x2", "inputs"]
    np.testing.assert_array_equal(panels[0].lines[0].get_ydata(), run.x[:, 0])
    np.testing.assert_array_equal(panels[0].lines[1].get_ydata(), run.xhat[:, 0])
    track = KalmanFilter(A / 4, B, C, np.eye(2), R).run(np.ones((5, 1)))
    np.testing.assert_allclose(track.plot(dt=0.1)[1].lines[1].get_ydata(), track.means[:, 1] + 2 * np.sqrt(track.variances[:, 1]))
    pyplot.close("all")


def test_what_is_computed_from_poles_is_a_plain_array() -> None:
    poles = Plant(A, B, C).poles
    assert type(poles * 2) is np.ndarray and type(poles.real + 1) is np.ndarray and isinstance(poles.real.max(), float)
    assert repr(poles) == repr(np.asarray(poles))


def test_importing_the_engine_loads_little() -> None:
    code = (
        "import observer_lab.engine, sys; print(sorted({'viser', 'matplotlib', 'numba', 'control', 'daqp'} & set(sys.modules)), "
        "sum(m.split('.')[0] in ('app', 'lessons') for m in sys.modules)); observer_lab.engine.place; print(sum(m.split('.')[0] == 'app' "
        "for m in sys.modules), 'matplotlib' in sys.modules)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=Path(__file__).resolve().parents[2])
    first, second = out.stdout.strip().splitlines()
    assert first.startswith("[] ") and int(first.split()[-1]) <= 60
    assert second.endswith("False") and int(second.split()[0]) < 100
