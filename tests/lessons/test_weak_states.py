"""Lesson 12: ranks hang on the clock, Hankel values do not; the weak pair has a face; nobody misses it."""

from __future__ import annotations

from functools import lru_cache

import control
import mpmath
import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from observer_lab.engine import balanced_truncation, controllability, hankel_singular_values, observability
from observer_lab.lessons.weak_states import reduced_regulator
from observer_lab.lessons.weak_states.balanced_platform import (
    MASSES_AGAINST_MODE,
    MASSES_TOGETHER_MODE,
    VERTICAL_MODE,
    closed_forms,
    system,
)
from observer_lab.lessons.weak_states.body import BODY, NOMINAL, SWING_S, share
from observer_lab.lessons.weak_states.lesson import LESSON
from observer_lab.lessons.weak_states.reduced_regulator import STATES_ALIKE, WEIGHT_OUTPUTS
from observer_lab.lessons.weak_states.study import cut
from observer_lab.plants.platform.model import Parameters, in_time_units, plant
from observer_lab.published.platform import RECORDS
from observer_lab.published.record import verify_one


def outcome(**changes):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def metrics(**changes):
    return outcome(**changes).metrics


def gramian(A, B):
    """Wc in 40 digits: the linear equations A W + W Aᵀ = −B Bᵀ for the entries of a symmetric W."""
    n = len(A)
    place = {(i, j): k for k, (i, j) in enumerate((i, j) for i in range(n) for j in range(i, n))}
    M, right = mpmath.zeros(len(place)), mpmath.zeros(len(place), 1)
    for (i, j), row in place.items():
        for k in range(n):
            M[row, place[min(k, j), max(k, j)]] += mpmath.mpf(float(A[i, k]))
            M[row, place[min(i, k), max(i, k)]] += mpmath.mpf(float(A[j, k]))
        right[row] = -sum((mpmath.mpf(float(B[i, k])) * mpmath.mpf(float(B[j, k])) for k in range(B.shape[1])), mpmath.mpf(0))
    solved = mpmath.lu_solve(M, right)
    W = mpmath.zeros(n)
    for (i, j), row in place.items():
        W[i, j] = W[j, i] = solved[row]
    return W


@lru_cache(maxsize=1)
def balanced_by_svd():
    """Hankel values, T and its inverse from an SVD in 40 digits: the oracle for what double precision must find."""
    P = plant()
    with mpmath.workdps(40):
        reach, see = mpmath.cholesky(gramian(P.A, P.B)), mpmath.cholesky(gramian(P.A.T, P.C.T))
        U, S, V = mpmath.svd_r(see.T * reach)
        T, left = reach * V.T, (see * U).T
        for k in range(P.n):
            for i in range(P.n):
                T[i, k] /= mpmath.sqrt(S[k])
                left[k, i] /= mpmath.sqrt(S[k])
        return tuple(np.array(M.tolist(), dtype=float) for M in (S, T, left))


def response(P, f):
    """G(j2πf) by python-control, (n_f, p, m)."""
    return np.moveaxis(control.ss(P.A, P.B, P.C, P.D).frequency_response(2 * np.pi * f, squeeze=False).complex, 2, 0)


# --- rank ----------------------------------------------------------------------------------------------------------------
def test_the_usual_rank_in_seconds_is_four_and_six():
    P = plant()
    blocks, rows = [P.B], [P.C]
    for _ in range(9):
        blocks.append(P.A @ blocks[-1])
        rows.append(rows[-1] @ P.A)
    assert np.linalg.matrix_rank(np.hstack(blocks)) == 4 and np.linalg.matrix_rank(np.vstack(rows)) == 6
    m = metrics(tolerance=1e-9)
    assert (m["rank_controllability"], m["rank_observability"]) == (4, 4)


def test_in_five_milliseconds_the_same_plant_has_rank_ten():
    for tolerance in (1e-6, 5e-5):
        m = metrics(clock=5e-3, tolerance=tolerance)
        assert (m["rank_controllability"], m["rank_observability"]) == (10, 10)


def test_by_the_millisecond_controllability_falls_from_ten_to_six_over_the_reports_range():
    found = [metrics(measure="absolute", clock=1e-3, tolerance=t)["rank_controllability"] for t in (1e-12, 1e-9, 1e-7, 1e-6)]
    assert found[0] == 10 and found[-1] == 6 and found == sorted(found, reverse=True)
    assert metrics(measure="absolute", tolerance=1e-6)["rank_controllability"] == 10  # in seconds it does not


def test_the_clock_changes_ranks_and_not_hankel_values():
    P = plant()
    for unit in (1e-3, 5e-3, 0.1):
        counted = in_time_units(P, unit)
        assert np.allclose(hankel_singular_values(counted), hankel_singular_values(P), rtol=1e-6)
        assert np.allclose(counted.poles, P.poles * unit, rtol=1e-9)
    quick = in_time_units(P, 5e-3)
    assert controllability(quick).matrix_rank(1e-6) == observability(quick).matrix_rank(1e-6) == 10


# --- Hankel values and truncation ---------------------------------------------------------------------------------------------
@pytest.mark.slow
def test_hankel_values_are_those_of_forty_digits():
    assert system(NOMINAL).hankel == pytest.approx(balanced_by_svd()[0].ravel(), rel=1e-6)


@pytest.mark.parametrize("order", [4, 6, 8])
def test_truncations_are_those_of_an_svd_in_forty_digits(order):
    """Pairs of equal values leave the coordinates open: transfer functions are compared."""
    P, s = plant(), system(NOMINAL)
    _, T, left = balanced_by_svd()
    small = control.ss(left[:order] @ P.A @ T[:, :order], left[:order] @ P.B, P.C @ T[:, :order], np.zeros((4, 5)))
    f = s.frequencies
    oracle = np.moveaxis(small.frequency_response(2 * np.pi * f, squeeze=False).complex, 2, 0)
    assert np.abs(response(s.reduced(order)[0], f) - oracle).max() < 1e-5 * cut(s, order).peak
    assert np.abs(response(balanced_truncation(P, order).plant, f) - oracle).max() < 1e-5 * cut(s, order).peak


@pytest.mark.parametrize("order", range(1, 10))
def test_the_error_keeps_below_twice_the_sum_of_what_is_cut(order):
    """The truth from python-control over 4000 frequencies and a fine comb about every mode."""
    s = system(NOMINAL)
    comb = [m.frequency * (1 + m.damping * np.linspace(-2, 2, 401)) for m in s.motions]
    f = np.unique(np.concatenate([np.geomspace(1e-3, 1e3, 4000), *comb]))
    error = np.linalg.norm(response(s.plant, f) - response(s.reduced(order)[0], f), 2, axis=(1, 2)).max()
    m = metrics(order=order)
    assert error <= m["bound"] * (1 + 1e-6)
    assert m["error"] == pytest.approx(error, rel=2e-3)


def test_ten_to_eight_is_half_the_bound_at_thirty_hertz():
    m = metrics(order=8)
    assert m["error"] == pytest.approx(1.771e-4, abs=1e-7) and m["error_at"] == pytest.approx(30.2, abs=0.05)
    assert m["bound"] == pytest.approx(3.541e-4, abs=1e-7)
    assert m["error"] == pytest.approx(m["sigma9"] + m["sigma10"], rel=1e-3)
    assert m["sharp"] == pytest.approx(2 * m["sigma9"], rel=1e-12) and m["error"] == pytest.approx(m["sharp"], rel=1e-4)


def test_the_wider_gap_lies_after_six():
    s = system(NOMINAL)
    ratio = s.hankel[:-1] / s.hankel[1:]
    assert int(ratio.argmax()) + 1 == 6 and ratio[5] == pytest.approx(798, abs=1)
    assert pytest.approx(798, abs=1) == 43.0305 / 0.0539 and pytest.approx(539, abs=1) == 0.0539 / 0.0001  # as printed
    m = metrics(order=6)
    assert m["error"] == pytest.approx(0.108, abs=5e-4) and m["error_at"] == pytest.approx(30.3, abs=0.05)
    assert metrics(order=5)["error"] == pytest.approx(86, abs=0.5)


# --- motions -------------------------------------------------------------------------------------------------------------------
def test_the_weak_pair_is_the_test_masses_against_each_other():
    s = system(NOMINAL)
    assert [m.kind for m in s.motions] == [VERTICAL_MODE, 1, 2, MASSES_TOGETHER_MODE, MASSES_AGAINST_MODE]
    weak = s.motions[-1]
    assert weak.frequency == pytest.approx(30.21, abs=0.01)
    assert abs(weak.shape[3] + weak.shape[4]) < 1e-6 * abs(weak.shape[3] - weak.shape[4])


def test_strengths_from_eigenvectors_are_the_hankel_values():
    for p in (NOMINAL, Parameters(h=0.05), Parameters(s=0.15, mu=0.2), Parameters(a=0.2, kp=500)):
        s = system(p)
        assert [m.strength for m in s.motions] == pytest.approx(s.hankel[::2], rel=5e-3)


@pytest.mark.parametrize("changes", [{}, {"h": 0.05}, {"s": 0.16}, {"mu": 0.02}, {"a": 0.2}, {"kp": 20000.0}])
@pytest.mark.parametrize("unit", [1.0, 1e-2, 1e-3, 1e-4])
def test_closed_forms_of_the_geometry(changes, unit):
    """Whatever the unit of the ground: each form stands beside the pair of its own motion."""
    s = system(Parameters(**changes), unit)
    for kind, value in closed_forms(s.parameters, unit):
        assert value == pytest.approx(s.hankel[2 * s.pair(kind)], rel=0.06), kind


@pytest.mark.parametrize("unit, after_six, after_eight", [(1.0, 798, 609), (1e-3, 5720, 25), (1e-4, 7120, 20)])
def test_hankel_values_know_no_clock_but_the_unit_of_the_ground(unit, after_six, after_eight):
    """Step 2: other coordinates and clocks leave them alone, another unit of an input does not."""
    s = system(NOMINAL, unit)
    assert s.hankel[5] / s.hankel[6] == pytest.approx(after_six, rel=0.01)
    assert s.hankel[7] / s.hankel[8] == pytest.approx(after_eight, rel=0.03)
    for clock in (1e-3, 0.1):
        from_clock = hankel_singular_values(in_time_units(s.plant, clock))
        assert from_clock == pytest.approx(s.hankel, rel=1e-5)


@pytest.mark.parametrize("pressed", [WEIGHT_OUTPUTS, STATES_ALIKE])
def test_the_unit_of_the_ground_is_not_felt_by_the_deck(pressed):
    """The report's cost on ten states and the spectra do not hang on it; where balanced states count, the unit is in the cost."""
    one, other = (outcome(ground=unit, order=6, pressed=pressed).study.compared for unit in (1.0, 1e-3))
    assert other.free == pytest.approx(one.free, rel=1e-6)
    if pressed == WEIGHT_OUTPUTS:
        assert other.full.cost == pytest.approx(one.full.cost, rel=1e-5)
        assert other.full.densities == pytest.approx(one.full.densities, rel=1e-4)


@pytest.mark.parametrize("tolerance, wanted", [(1e-9, (4, 4)), (1e-14, (4, 6))])
def test_the_ranks_in_seconds_at_the_tolerances_that_are_named(tolerance, wanted):
    m = metrics(tolerance=tolerance)
    assert (m["rank_controllability"], m["rank_observability"]) == wanted


def test_the_weakest_pair_takes_two_lengths_and_no_stop():
    task = next(t for t in LESSON.tasks if t.id == "geometry")
    for values in ({"s": 0.18}, {"h": 0.06}, {"s": 0.1, "h": 0.06}, {"s": 0.1}, {"s": 0.1, "h": 0.052, "ground": 1e-3}, {"kp": 300.0}):
        assert not task.check(outcome(**values)).solved, values
    assert task.check(outcome(s=0.1, h=0.052)).solved and task.check(outcome(s=0.095, h=0.058)).solved


def test_a_stiffer_servo_makes_the_weak_pair_faster_and_no_weaker():
    soft, stiff = (metrics(kp=k, pair="5") for k in (900.0, 18000.0))
    assert stiff["frequency"] > 4 * soft["frequency"]
    assert stiff["sigma9"] == pytest.approx(soft["sigma9"], rel=0.02)
    assert metrics(s=0.17)["sigma9"] > 10 * metrics()["sigma9"]
    assert metrics(h=0.06)["sigma9"] == pytest.approx(5.1 * metrics()["sigma9"], rel=0.02)


def test_the_ghost_lacks_what_the_model_lacks():
    s = system(NOMINAL)
    assert [round(share(s, m, 8)) for m in s.motions] == [1, 1, 1, 1, 0]
    assert [round(share(s, m, 6)) for m in s.motions] == [1, 1, 1, 0, 0]
    stage = outcome(pair="5", order=8).stage
    assert stage is not None and stage.xhat is not None
    ball = [BODY.pose(row.tolist(), BODY.gain)["test mass left"].position[2] for row in stage.x]
    still = [BODY.pose(row.tolist(), BODY.gain)["test mass left"].position[2] for row in stage.xhat]
    assert np.ptp(ball) > 0.1 and np.ptp(still) < 1e-3
    right = [BODY.pose(row.tolist(), BODY.gain)["test mass right"].position[2] for row in stage.x]
    assert np.corrcoef(ball, right)[0, 1] < -0.99
    swings = np.diff(np.flatnonzero(np.diff(np.sign(np.array(ball) - np.mean(ball))) > 0))
    assert np.allclose(np.diff(stage.t)[0] * swings, SWING_S, atol=0.06)


# --- LQG -------------------------------------------------------------------------------------------------------------------------
def test_nobody_misses_the_weak_pair():
    m = metrics(order=8)
    assert m["gap"] < 3e-5 and abs(m["extra"]) < 1e-9 and abs(m["growth"]) < 1e-6
    for v0 in (1e-12, 1e-6):
        m = metrics(order=8, v0=v0)
        assert m["gap"] < 1e-3 and abs(m["extra"]) < 1e-8


def test_not_even_when_every_state_counts_alike():
    o = outcome(order=8, pressed="alike")
    c = o.study.compared
    assert 0.03 < c.growth < 0.05 and abs(c.full.force / c.small.force - 1) == pytest.approx(1.5e-5, abs=0.3e-5)


def test_cutting_too_much_is_dear():
    assert metrics(order=4)["extra"] == pytest.approx(0.17, abs=0.005)
    assert "extra" not in metrics(order=4, v0=1e-12)  # unstable
    assert not next(c for c in outcome(order=4, v0=1e-12).checks if c.id == "stable").holds
    assert abs(metrics(order=6)["extra"]) < 1e-6


def test_the_gains_on_eight_states_are_those_of_scipys_riccati_equation():
    s, o = system(NOMINAL), outcome(order=8)
    small = s.reduced(8)[0]
    Q = 100 * small.C.T @ np.diag([1e8, 1e10, 1e8, 1e10]) @ small.C
    B, R = small.B[:, :3], 0.1 * np.eye(3)
    K = np.linalg.solve(R, B.T @ solve_continuous_are(small.A, B, Q, R))
    assert np.allclose(o.gains["K"], K, rtol=1e-4, atol=1e-6 * np.abs(K).max())


def test_published_lines_of_chapter_three_hold():
    for record in RECORDS:
        if any(word in record.item for word in ("rank", "order", "LQG on", "Hankel", "gap")):
            assert verify_one(record).holds, record.item


def test_nothing_is_compared_with_itself_while_all_states_are_kept() -> None:
    figures = {f.id: f for f in LESSON.figures(LESSON.compute(LESSON.start()))}
    for name in ("spectrum", "gains", "costs"):
        assert "All ten states are kept" in figures[name].caption("en")
    fewer = {f.id: f for f in LESSON.figures(LESSON.compute(LESSON.apply(LESSON.start(), {"order": 8})))}
    assert len(fewer["gains"].curves) == 2 * len(figures["gains"].curves)
    assert "kept" not in fewer["gains"].caption("en")


def test_a_loop_on_the_edge_of_stability_tells_no_variance(monkeypatch: pytest.MonkeyPatch) -> None:
    """The slowest pole of this loop is at some −1e-11 … −1e-8 rad/s, as the processor rounds; where the edge begins is ours to say."""
    monkeypatch.setattr(reduced_regulator, "AXIS_POLE_RAD_S", 1e-6)
    reduced_regulator._on.cache_clear()
    edge = outcome(order=1, s=0.17122848483517683, h=0.025801420435433667, a=0.10739045461079666, mu=0.01,
                   kp=855.0626120101867, v0=1e-06)
    reduced_regulator._on.cache_clear()
    small = edge.study.compared.small
    assert -1e-6 < small.rightmost < 0 and not small.stable
    assert small.cost is None and small.force is None and "extra" not in edge.metrics


@pytest.mark.parametrize(("kind", "name"), [(0, "height"), (1, "across"), (2, "tilt"), (3, "left mass"), (4, "right mass")])
def test_the_stage_marks_what_swings_as_the_run_begins(kind: int, name: str) -> None:
    """An arrow points where its part is at the start of the run, as long as it is far; its name, and the longest bar's, is the part's."""
    pair = system(NOMINAL).pair(kind) + 1
    found = outcome(pair=str(pair))
    stage, figure = found.stage, next(f for f in LESSON.figures(found) if f.id == "pair")
    assert stage is not None and stage.u is not None

    def ways(x: np.ndarray) -> dict[str, float]:
        return {"across": x[0] / 3.6e-3, "height": x[1] / 3.6e-3, "tilt": x[2] / 16e-3, "left mass": (x[3] - x[1] + x[11] * x[2]) / 2.2e-3,
                "right mass": (x[4] - x[1] - x[11] * x[2]) / 2.2e-3}
    far = ways(stage.x[0])
    most = max(map(abs, far.values()))
    assert abs(far[name]) > 0.99 * most
    for sample in (0, 7, 24, 31, 45):  # at every moment an arrow points where its part is
        arrows = stage.body.arrows(stage.x[sample].tolist(), stage.u[0].tolist(), stage.body.gain)
        drawn = dict(zip(("across", "height", "tilt down", "tilt", "left mass", "right mass"), arrows, strict=True))
        for part, way in ways(stage.x[sample]).items():
            along = sum(h - t for h, t in zip(drawn[part].head, drawn[part].tail, strict=True))
            assert along == pytest.approx(0.62 * way / most if abs(far[part]) > 0.08 * most else 0.0, abs=1e-6)
    shown = {words("en") for words, _ in stage.body.labels}
    assert shown == {part for part, way in far.items() if abs(way) > 0.08 * most} and name in shown
    bars = {next(n("en") for at, n in figure.names if abs(at - curve.x[0]) < 0.3): curve.y[1] for curve in figure.curves
            if curve.role == "plant"}
    assert bars[name] == pytest.approx(1.0)


@pytest.mark.parametrize(("changes", "numbers"), [
    ({}, (4, 4)), ({"clock": 0.001, "tolerance": 5e-7}, (10, 9)), ({"clock": 0.03}, (10, 10)),
    ({"measure": "absolute", "tolerance": 0.1}, None)])
def test_the_columns_above_the_plate_are_those_that_count(changes: dict[str, object], numbers: tuple[int, int] | None) -> None:
    """Powers of A in the unit of time, their singular values over the largest: each column is as high, the plate as the tolerance."""
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"columns": True, **changes}))
    stage, plant, clock = outcome.stage, outcome.study.system.plant, outcome.design["clock"]
    assert stage is not None
    scale = np.where(np.arange(10) < 5, 1.0, clock)  # velocities in metres per unit of time
    A, B, C = clock * plant.A / scale[None] * scale[:, None], clock * scale[:, None] * plant.B, plant.C / scale[None]
    poses = stage.body.pose(stage.x[0].tolist(), stage.body.gain)
    powers = [np.linalg.matrix_power(A, k) for k in range(10)]
    for row, M in enumerate((np.hstack([p @ B for p in powers]), np.vstack([C @ p for p in powers]))):
        values = np.linalg.svd(M, compute_uv=False)
        level = poses[f"plate {row}"].position[2] - poses[f"value {row} 0"].position[2]
        bars = [poses[f"value {row} {k}"] for k in range(10)]
        heights = np.array([bar.scale[2] for bar in bars])
        sure = np.array([values[k] / values[0] > 1e-13 for k in range(10)])
        assert heights[sure] == pytest.approx(0.62 * (1 + np.log10(values[sure] / values[0]) / 18), abs=0.02)
        grey = {bar.colour for bar in bars} - {bars[0].colour}
        counted = sum(bar.colour not in grey for bar in bars)
        assert counted == int((heights > level).sum()) == outcome.metrics[("rank_controllability", "rank_observability")[row]]
        if numbers is not None:
            relative = outcome.design["tolerance"]
            assert level == pytest.approx(0.62 * (1 + np.log10(relative) / 18), abs=1e-9) and counted == numbers[row]


@pytest.mark.parametrize("order", [8, 9])
def test_the_bars_before_the_deck_are_the_errors_of_the_smaller_model(order: int) -> None:
    """Responses of plant and model at 0.01 Hz and at the weakest mode, written out here; HR = −HL gives HL twice."""
    found = outcome(order=order)
    whole, model, stage = found.study.system.plant, found.study.cut.model, found.stage
    poles = np.linalg.eigvals(whole.A)
    weakest = found.study.system.motions[-1].pole
    assert np.abs(poles - weakest).min() < 1e-9

    def response(P, f: float) -> np.ndarray:
        return P.C @ np.linalg.solve(2j * np.pi * f * np.eye(P.n) - P.A, P.B) + np.asarray(P.D)
    errors = []
    for f in (0.01, abs(weakest) / (2 * np.pi)):
        errors.append(np.linalg.norm(response(whole, f) - response(model, f), 2))
    poses, x = stage.body.pose(stage.x[0].tolist(), 1.0), stage.x[0].tolist()
    long = [poses[f"score bar {k}"].scale[0] for k in range(2)]
    assert long == pytest.approx([2.0 * max(each / 2e-4, 0.004) for each in errors], rel=1e-3)
    numbers = [words.replace("·10", "e").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) for words, _, _ in
               stage.body.marks(x, x, 1.0).words]
    assert [float(each) for each in numbers] == pytest.approx(errors, rel=6e-3)


def test_the_deck_rests_and_asks_before_the_weakest_pair_is_shown() -> None:
    asked = outcome(rest=True)
    assert np.abs(asked.stage.x[:, :10]).max() == np.abs(asked.stage.xhat[:, :10]).max() == 0.0
    x = asked.stage.x[0].tolist()
    assert [words for words, _, _ in asked.stage.body.marks(x, x, 1.0).words] == ["?"] * 3 and not asked.stage.body.labels
    assert asked.live("en") == "On the stage the deck rests."
