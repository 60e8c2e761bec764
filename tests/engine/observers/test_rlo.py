"""Algorithm RLO: finds what is known, keeps to its region, raises the order only when it must."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.engine import EngineError, Plant, functional_observer, rlo
from observer_lab.engine.observers import Region, rlo_steps, vertices, worst_error_gain
from observer_lab.engine.structure import coprime_factors
from observer_lab.plants import MODELS
from observer_lab.plants.duan import EXAMPLE_1, EXAMPLE_2

E1, E2 = EXAMPLE_1, EXAMPLE_2


def plant_of(seed, n, p):
    rng = np.random.default_rng(seed)
    return Plant(rng.standard_normal((n, n)), rng.standard_normal((n, 1)), rng.standard_normal((p, n)))


@pytest.mark.parametrize("norm", [1, 2, "inf"])
@pytest.mark.parametrize("region", [None, Region(-12.3, -0.7)])
def test_example_1_optimum_is_found_in_every_norm(norm, region):
    found = rlo(E1.plant, E1.K, wrong=E1.wrong, norm=norm, region=region)
    assert found.observer.poles[0] == pytest.approx(-5 / 3, abs=1e-6)
    assert found.value == pytest.approx(38 / 9, abs=1e-5) and pytest.approx(found.value, rel=1e-12) == found.observer.J
    assert found.observer.order == 1 and found.evaluations > 20


@pytest.mark.parametrize(("low", "high", "best"), [(-9, -4, -4), (-1.2, -0.2, -1.2)])
def test_example_1_criterion_grows_on_both_sides_of_its_kink(low, high, best):
    found = rlo(E1.plant, E1.K, wrong=E1.wrong, region=Region(low, high))
    assert found.observer.poles[0] == pytest.approx(best, abs=1e-9)
    J = [functional_observer(E1.plant, E1.K, 1, poles=[s], wrong=E1.wrong).J for s in np.linspace(low, high, 12)]
    assert np.all(np.diff(J) < 0 if best == high else np.diff(J) > 0)


@pytest.mark.slow
def test_another_measure_has_another_optimum():
    """The worst |e_u/v| over the sign vertices is least near −1.3, not at −5/3."""
    errors = vertices(E1.wrong, E1.delta_A, E1.delta_C)
    found = rlo(E1.plant, E1.K, wrong=E1.wrong, region=Region(-5, -0.3), measure=lambda o: worst_error_gain(o, errors))
    assert found.observer.poles[0].real == pytest.approx(-1.30, abs=0.03) and 0.81 < found.value < 0.821


@pytest.mark.slow
def test_example_2_raises_the_order_and_runs_to_equal_poles():
    """2-norm, Re s ≤ −2: inf J = 7 + 2√2 = 9.82843 at s1 → s2 → −2, where N has no bound."""
    found = rlo(E2.plant, E2.K, wrong=E2.wrong, norm=2, region=Region(-20, -2), worst_condition=1e6)
    first, second = found.attempts
    assert not first.feasible and first.order == 1 and first.gap > 0.1 and second.feasible
    assert 9.82843 - 5e-6 < found.value < 9.8286
    np.testing.assert_allclose(found.observer.poles, [-2, -2], atol=1e-4)
    assert np.abs(found.observer.N).max() > 1e4
    tame = rlo(E2.plant, E2.K, wrong=E2.wrong, norm=2, region=Region(-20, -2), worst_condition=30)
    assert tame.observer.condition <= 30.001 and tame.value > found.value and np.abs(tame.observer.N).max() < 100


@pytest.mark.slow
def test_example_2_against_a_grid():
    region = Region(-6, -2.5)
    found = rlo(E2.plant, E2.K, wrong=E2.wrong, norm="inf", region=region, worst_condition=50)
    axis, best = np.linspace(-6, -2.5, 60), np.inf
    for s1 in axis:
        for s2 in axis[axis < s1]:
            o = functional_observer(E2.plant, E2.K, 2, poles=[s1, s2], wrong=E2.wrong, norm="inf")
            best = min(best, o.J if o.condition < 50 else np.inf)
    assert found.value <= best * (1 + 1e-9)


def test_one_state_is_enough_where_a_special_pole_does_it():
    """K = (k0, 1.5, 1): only s = −1.5 gives K from C and (s² + 3s + 2, s + 3, 1)."""
    found = rlo(E2.plant, [[0.7, 1.5, 1.0]], wrong=E2.wrong, region=Region(-8, -0.1))
    assert found.observer.order == 1 and found.attempts[-1].order == 1
    assert found.observer.poles[0] == pytest.approx(-1.5, abs=1e-9)
    assert found.observer.output_residual < 1e-9


def test_pairs_are_tried_where_the_region_has_room_for_them():
    found = rlo(E2.plant, E2.K, wrong=E2.wrong, region=Region(-6, -2, 1.0, 3.0))
    s = found.observer.poles
    assert [a.pairs for a in found.attempts] == [1] and s[0] == s[1].conjugate()  # no real pole is allowed
    assert -6 <= s[0].real <= -2 and 1 <= abs(s[0].imag) <= 3
    assert found.observer.output_residual < 1e-10 and found.observer.dynamics_residual < 1e-12


def test_a_region_for_each_pole():
    found = rlo(E2.plant, E2.K, wrong=E2.wrong, region=[Region(-3, -2.5), Region(-9, -8)])
    fast, slow = sorted(found.observer.poles.real)
    assert -9 <= fast <= -8 and -3 <= slow <= -2.5


@pytest.mark.slow
@settings(max_examples=8)
@given(st.integers(0, 10**4), st.sampled_from([(2, 1), (3, 1), (4, 2), (5, 3), (6, 3), (3, 3)]))
def test_any_observable_plant_and_any_row_K(seed, shape):
    n, p = shape
    plant, K = plant_of(seed, n, p), np.random.default_rng(seed + 1).standard_normal((1, n))
    region = Region(-8, -0.4)
    found = rlo(plant, K, region=region)
    o = found.observer
    TA = o.T @ plant.A
    assert np.linalg.norm(TA - o.F @ o.T - o.L @ plant.C) <= 1e-9 * np.linalg.norm(TA)
    assert np.linalg.norm(K - o.N @ o.T - o.M @ plant.C) <= 1e-9 * np.linalg.norm(K)
    assert o.order <= max(1, n - p) and np.all(o.poles.real >= -8) and np.all(o.poles.real <= -0.4)
    rng = np.random.default_rng(seed)
    for _ in range(20):  # no observer of that order drawn at random does better
        poles = -np.sort(rng.uniform(0.4, 8, o.order))
        try:
            other = functional_observer(plant, K, o.order, poles=poles)
        except EngineError:  # an order that only special poles allow
            assert len(found.attempts) < max(1, n - p)
            continue
        if other.condition < 1e4:
            assert found.value <= other.J * (1 + 1e-9)


def test_a_nearly_dependent_output_comes_last_in_its_chain():
    """Plant 882: Aᵀc₂ lies within 1e-4 of the span of c₁, c₂, c₃, Aᵀc₁; chosen before Aᵀc₃ it spoilt every T."""
    plant, K = plant_of(882, 5, 3), np.random.default_rng(883).standard_normal((1, 5))
    assert coprime_factors(plant).indices == (2, 1, 2)
    found = rlo(plant, K, region=Region(-8, -0.4)).observer
    assert found.output_residual < 1e-12 and found.condition < 1e3


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "n", "p"), [(1, 3, 1), (2, 5, 3)])
def test_several_wanted_rows(seed, n, p):
    plant, K = plant_of(seed, n, p), np.random.default_rng(seed + 1).standard_normal((2, n))
    found = rlo(plant, K, region=Region(-8, -0.4))
    assert found.observer.output_residual < 1e-9 and found.observer.dynamics_residual < 1e-12
    assert found.observer.N.shape[0] == 2 and found.observer.order <= n - p


@pytest.mark.slow
def test_steps_report_progress_and_end_with_the_result():
    parts = list(rlo_steps(E2.plant, E2.K, wrong=E2.wrong, region=Region(-6, -2)))
    fractions = [f for f, _ in parts]
    assert fractions == sorted(fractions) and fractions[-1] == 1.0 and len(parts) > 4
    values = [r.value for _, r in parts if r is not None]
    assert values == sorted(values, reverse=True)
    assert parts[-1][1].value == rlo(E2.plant, E2.K, wrong=E2.wrong, region=Region(-6, -2)).value


@pytest.mark.parametrize(("more", "word"), [
    ({"max_order": 1}, "higher order"),
    ({"region": Region(-5, 1)}, "stable"),
    ({"region": Region(-1, -5)}, "re_low"),
    ({"bounds": (-5, float("nan"))}, "finite"),
    ({"region": []}, "needed"),
    ({"max_order": 9}, "between 1 and 3"),
    ({"norm": "nuclear"}, "norm"),
])
def test_requests_that_make_no_sense_get_one_sentence(more, word):
    more = dict(more)
    with pytest.raises(EngineError, match=word):
        region = Region(*more.pop("bounds", (-8, -0.5)))
        rlo(E2.plant, E2.K, **({"region": region} | more))


@pytest.mark.slow
def test_outputs_that_repeat_others_and_stiff_units():
    """The rigid deck: four velocity sensors on three motions; one wanted row needs one state."""
    plant, K = MODELS["deck"].controlled, np.array([[3e4, 1e3, 0, 2e3, -5e2, 1e2]])
    assert plant.p > np.linalg.matrix_rank(plant.C)
    o = rlo(plant, K).observer
    assert o.order <= 3 and o.output_residual < 1e-9 and o.dynamics_residual < 1e-12


def test_a_limit_on_the_condition_that_nothing_meets_is_told_apart():
    with pytest.raises(EngineError, match="condition number"):
        rlo(E2.plant, E2.K, region=Region(-8, -0.5), worst_condition=1.0001)
