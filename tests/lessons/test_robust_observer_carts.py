"""The two carts of the lesson "robust observer": conditions, J, the optimum in a rectangle and the order, each found another way."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brute, minimize

from observer_lab.lessons.robust_observer.criterion import criterion_4, direct_4
from observer_lab.lessons.robust_observer.lesson import LESSON
from observer_lab.lessons.robust_observer.rectangle import best_in_rectangle
from observer_lab.lessons.robust_observer.study import errors, observer_of

CARTS = LESSON.apply(LESSON.start(), {"example": "4"})
A = np.array([[0, 1, 0, 0], [-9, 0, 9, 0], [0, 0, 0, 1], [9, 0, -9, 0.0]])
C, K = np.eye(4)[:2], np.array([[100, 14, -88, 8.0]])
WRONG_A = (np.array([[0] * 4, [-1, 0, 1, 0], [0] * 4, [1, 0, -1, 0.0]]), np.array([[0] * 4, [0, -1, 0, 1], [0] * 4, [0, 1, 0, -1.0]]))
WRONG_C = np.array([[0] * 4, [0, 1.0, 0, 0]])
ORDER = {"1": 1, "2": 2, "inf": np.inf}


def pair(re, im):
    return complex(re, -im), complex(re, im)


def peer_J(s1, s2, norm="2", first=0j, second=0j):
    """J by linear algebra alone: rows t = (t₁, t₂, t₃, 1) from the columns without a sensor, `first` and `second` added to t₁."""
    T, L = [], []
    for s, more in ((s1, first), (s2, second)):
        t2, t3 = np.linalg.solve(np.array([[9, -s], [0, 1]], dtype=complex), np.array([9, s], dtype=complex))  # columns q₂, v₂
        t = np.array([s * t2 + more, t2, t3, 1])
        T.append(t)
        L.append((t @ A - s * t)[:2])
        assert abs((t @ A - s * t)[2:]).max() < 1e-12
    if abs(s1.imag) > 0:
        T, L = ([rows[0].real, rows[0].imag] for rows in (T, L))
    T, L = np.real(T), np.real(L)
    both = np.linalg.solve(np.vstack([T, C]).T, K[0])
    M = both[None, 2:]
    return (sum(np.linalg.norm(T @ one, ORDER[norm]) for one in WRONG_A) + np.linalg.norm(L @ WRONG_C, ORDER[norm])
            + np.linalg.norm(M @ WRONG_C, ORDER[norm]))


def best(norm="2", **changes):
    *_, (part, found) = best_in_rectangle(LESSON.apply(CARTS, changes), norm, 50.0)
    assert part == 1.0
    return found


@pytest.mark.parametrize("poles", [(-4, -2.5), pair(-0.5, 1.5), pair(-7, 3), (-11.5, -0.3)])
def test_both_conditions_hold_on_the_carts(poles):
    g = LESSON.compute(LESSON.apply(CARTS, {"pair": poles})).gains
    size = np.abs(g["L"]).max() + 1
    np.testing.assert_allclose(g["T"] @ A - g["F"] @ g["T"], g["L"] @ C, atol=1e-11 * size)
    np.testing.assert_allclose(g["N"] @ g["T"] + g["M"] @ C, K, atol=1e-9)
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(g["F"])), np.sort_complex(np.array(poles, dtype=complex)), atol=1e-9)
    assert np.abs(g["L"][:, 1]).max() < 1e-10 * size  # nothing of the tachometer


@pytest.mark.parametrize("norm", ["1", "2", "inf"])
@pytest.mark.parametrize("poles", [(-4 + 0j, -2.5 + 0j), pair(-0.5, 1.5), pair(-3, 0.4)])
def test_the_drawn_J_of_the_carts_is_the_engines_and_that_of_linear_algebra(norm, poles):
    d = LESSON.apply(CARTS, {"pair": poles, "norm": norm, "alpha": 0.5, "second": 1.0, "gamma": 2.0})
    s1, s2 = (np.array(p if poles[0].imag else p.real) for p in reversed(poles))
    assert criterion_4(s1, s2, d).sum() == pytest.approx(observer_of(d).J, rel=1e-9)
    plain = LESSON.apply(CARTS, {"pair": poles, "norm": norm})
    assert pytest.approx(peer_J(poles[1], poles[0], norm), rel=1e-9) == observer_of(plain).J


@pytest.mark.parametrize(("high", "tall"), [(-0.5, 1.5), (-0.5, 3.0), (-1.0, 2.0)])
def test_no_pair_and_no_direction_in_the_rectangle_has_a_smaller_J(high, tall):
    """By brute force over Re s, Im s and both parts of the free number of the direction, then polished by Nelder and Mead."""
    found = best(region_high=high, region_tall=tall)

    def value(v):
        re, im = min(max(v[0], -10.0), high), min(max(v[1], 1e-6), tall)
        s, free = complex(re, im), complex(v[2], v[3])
        return peer_J(s, s.conjugate(), first=free, second=free.conjugate())

    start = brute(value, ((-10, high), (0.05, tall), (-2, 2), (-2, 2)), Ns=7, finish=None)
    polished = min((minimize(value, at, method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-10, "maxiter": 600})
                    for at in (start, [high, tall, 0.1, 0.1], [high - 0.5, 0.9 * tall, 0, 0])), key=lambda fit: fit.fun)
    assert polished.fun >= found.value - 1e-6 and polished.fun == pytest.approx(found.value, rel=2e-3)


def test_the_best_pair_stands_at_both_bounds_until_the_bound_on_im_passes_two():
    for tall, im, J in ((1.0, 1.0, 3.060), (1.5, 1.5, 2.341), (2.0, 2.0, 1.336), (4.0, 2.0, 1.336), (6.0, 2.0, 1.336)):
        found = best(region_tall=tall)
        upper = found.observer.poles[np.argmax(found.observer.poles.imag)]
        assert upper == pytest.approx(complex(-0.5, im), abs=1e-5) and found.value == pytest.approx(J, abs=2e-3)
    assert direct_4(*(np.array(p) for p in pair(-0.5, 2.0))) == pytest.approx(0, abs=1e-12)


def test_the_left_end_decides_the_order():
    second = best()
    assert [(a.order, a.pairs, a.feasible) for a in second.attempts] == [(1, 0, False), (2, 0, True), (2, 1, True)]
    assert second.attempts[1].J > second.attempts[2].J == pytest.approx(second.value)
    one = best(region_low=-11.0).observer
    assert one.order == 1 and one.poles[0] == pytest.approx(-11)
    np.testing.assert_allclose(one.T @ A - one.F @ one.T, one.L @ C, atol=1e-9)
    np.testing.assert_allclose(one.N @ one.T + one.M @ C, K, atol=1e-9)
    # another pole of one state: the rows [t; C] miss K in the columns of q₂ and v₂
    seen = [np.linalg.lstsq(np.vstack([[s * (1 + s * s / 9), 1 + s * s / 9, s, 1], C]).T, K[0], rcond=None)[1] for s in (-10.0, -5, -0.5)]
    assert min(float(rest[0]) for rest in seen) > 0.1
    assert second.attempts[0].gap == pytest.approx(np.sqrt(min(float(rest[0]) for rest in seen)) / np.linalg.norm(K), rel=0.05)


def test_a_bound_of_zero_leaves_real_poles():
    found = best(region_tall=0.0)
    assert not found.observer.poles.imag.any() and found.observer.condition <= 50.01 and found.value > 6


@pytest.mark.parametrize("poles", [(-4, -2.5), pair(-0.5, 2.0)])
def test_the_run_of_the_carts_is_a_matrix_exponential(poles):
    o = LESSON.compute(LESSON.apply(CARTS, {"pair": poles}))
    g, (dA, _, dC) = o.gains, errors(o.design)
    np.testing.assert_allclose(dA, 0.5 * WRONG_A[0] + 0.2 * WRONG_A[1])
    B, seen = np.array([[0], [1], [0], [0.0]]), C + dC
    drive = np.vstack([B, g["T"] @ B])
    whole = np.zeros((8, 8))
    whole[:6, :6] = np.block([[A + dA, np.zeros((4, 2))], [g["L"] @ seen, g["F"]]]) - drive @ np.hstack([g["M"] @ seen, g["N"]])
    whole[:6, 6], whole[6, 7], whole[7, 6] = -4 * drive[:, 0], 5, -5  # sin and cos of 5t + π/2
    end = expm(6 * whole) @ [*[0.1] * 4, 0, 0, 1, 0]
    np.testing.assert_allclose(np.hstack([o.study.true.x[-1], o.study.true.z[-1]]), end[:6], atol=1e-9)


def test_the_worst_case_rises_where_J_falls():
    near, best_pair = (LESSON.compute(LESSON.apply(CARTS, {"pair": pair(-0.5, im)})).metrics for im in (0.5, 2.0))
    assert near["J"] == pytest.approx(3.49, abs=5e-3) and best_pair["J"] == pytest.approx(1.34, abs=5e-3)
    assert near["worst_gain"] == pytest.approx(0.038, abs=5e-4) and best_pair["worst_gain"] == pytest.approx(0.150, abs=5e-4)


def test_the_job_shows_the_pair_in_each_norm_and_what_was_tried():
    *_, (part, last) = LESSON.job.outcomes(LESSON.compute(CARTS))
    assert part == 1.0 and all(last.metrics[f"im_rlo_{norm}"] == pytest.approx(1.5, abs=1e-6) for norm in ORDER)
    rows = next(f for f in LESSON.figures(last) if f.id == "found").rows
    assert [row[2] for row in rows] == ["−0.5 ± 1.5j"] * 3 and all("1: ✗" in row[4] and "2 ±: ✓" in row[4] for row in rows)


def test_the_map_has_the_rectangle_and_its_least_cells_at_the_pair():
    d = LESSON.apply(CARTS, {"pair": pair(-0.5, 1.5)})
    drawn = next(f for f in LESSON.figures(LESSON.compute(d)) if f.id == "map")
    x, y = np.meshgrid(drawn.x, drawn.y)
    inside = (x < -0.49) & (y < 1.51)
    assert drawn.marked == (-0.5, 1.5) and "−0.5 ± 1.5j, about 2.34; now J is 2.34" in drawn.caption("en").replace("-", "−")
    least = inside & (drawn.values == 1)
    assert least[np.isclose(x, -0.5) & np.isclose(y, 1.5)].all() and (x[least] > -0.75).all() and (y[least] > 1.3).all()
    assert not (inside & np.isin(drawn.values, (0, 4))).any() and (drawn.values == 0).any()  # J is smaller outside only
    edge = drawn.values == 4
    assert edge[np.isclose(y, 1.6) & (x < -0.49)].all() and edge[np.isclose(x, -0.45) & (y < 1.51)].all() and edge.sum() == 31 + 15


@pytest.mark.parametrize("example", ["2", "3", "4"])
def test_a_pair_is_named_once(example):
    said = LESSON.compute(LESSON.apply(LESSON.start(), {"example": example, "pair": pair(-0.5, 1.5)})).live("en")
    assert said.replace("-", "−").count("−0.5 ± 1.5j") == 1


def test_J_of_example_2_is_named_with_its_W():
    o = LESSON.compute(LESSON.apply(LESSON.start(), {"example": "2"}))
    drawn = {f.id: f for f in LESSON.figures(o)}
    assert "J = 46.7 for w = 1.2" in o.live("en") and "w = 1.2" in drawn["criterion"].caption("en")
    assert "J (w = 1.2)" in [row[0] for row in drawn["numbers"].rows] and "least J (W = I)" in [c("en") for c in drawn["found"].columns]


def test_the_circle_is_reached_by_a_pair_only():
    task = next(t for t in LESSON.tasks if t.id == "circle")
    assert task.check(LESSON.compute(LESSON.apply(CARTS, {"pair": pair(-1, 3.77)}))).solved
    assert not task.check(LESSON.compute(LESSON.apply(CARTS, {"pair": pair(-1, 3.5)}))).solved
    assert not task.check(LESSON.compute(LESSON.apply(CARTS, {"pair": pair(-0.5, 2)}))).solved
    s1, s2 = np.meshgrid(np.linspace(-12, -1, 200), np.linspace(-12, -1, 200))
    assert criterion_4(s1, s2, CARTS).sum(axis=0).min() > 13


@pytest.mark.parametrize("tall", [0.4, 1.5, 2.6])
def test_green_pairs_of_the_map_have_a_smaller_J_than_all_pairs_in_the_rectangle(tall):
    o = LESSON.compute(LESSON.apply(CARTS, {"pair": pair(-0.5, 0.5), "region_tall": tall}))
    drawn = next(f for f in LESSON.figures(o) if f.id == "map")
    J = np.array([[peer_J(complex(x, y), complex(x, -y)) for x in drawn.x] for y in drawn.y])
    least = J[np.ix_(drawn.y <= tall + 1e-9, drawn.x <= -0.5 + 1e-9)].min()
    edge = drawn.values == 4
    assert ((drawn.values == 0) == (least * (1 - 1e-9) > J))[~edge].all() and ((drawn.values == 1) <= (1.1 * least * (1 + 1e-9) >= J)).all()
    assert ((drawn.values == 3) == (2.0 * least < J))[~edge].all() and (drawn.values == 2).any()
    assert not (drawn.values == 0)[np.ix_(drawn.y <= tall, drawn.x <= -0.5)].any() and edge.any()
