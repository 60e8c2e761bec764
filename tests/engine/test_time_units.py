"""Laws of the unit of time: what the engine decides of a plant is the same from seconds of 1e-9 to seconds of 1e9."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from unit_cases import Case, ones, random_case
from unit_laws import LAWS, breach

from observer_lab.engine import Plant, bilinear_functional_observer, functional_observer, observer_gain, place
from observer_lab.engine.design import diophantine
from observer_lab.engine.observers import existence
from observer_lab.engine.systems import EngineError

FACTORS = (1e-9, 1e-6, 1e6, 1e9)


def _in_time(case: Case, factor: float) -> Case:
    return case.to(replace(ones(case), tau=factor))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("law", LAWS)
def test_a_law_of_units_holds_nine_decades_of_time_away(law: str, seed: int) -> None:
    case = random_case(np.random.default_rng((77, seed)))
    for factor in FACTORS:
        assert not breach(law, case, replace(ones(case), tau=factor)), factor


@pytest.mark.parametrize("seed", range(6))
def test_a_functional_observer_is_the_same_in_any_unit_of_time(seed: int) -> None:
    """F and L are rates, T, N and M are none; and the ranks that say whether it exists do not change."""
    case = random_case(np.random.default_rng((78, seed)))
    K = np.random.default_rng(seed).standard_normal((1, case.plant.n))
    order = case.plant.n - len(case.plant.C)
    poles = -np.linspace(1.0, 2.0, order) * np.abs(case.plant.poles).max() if order else []
    answers = []
    for factor in (1.0, *FACTORS):
        plant = _in_time(case, factor).plant
        found = existence(plant, K, np.asarray(poles) * factor)
        answers.append((found.rank, found.with_K, found.exists))
        if order and found.exists:
            observer = functional_observer(plant, K, order, poles=np.asarray(poles) * factor)
            np.testing.assert_allclose(np.poly(observer.F / factor), np.poly(poles), rtol=1e-6)
            assert observer.dynamics_residual < 1e-9 and observer.output_residual < 1e-6  # of eight states
    assert all(one == answers[0] for one in answers)


def _word(call, *arguments, **options) -> str:
    try:
        call(*arguments, **options)
    except EngineError as problem:
        return type(problem).__name__ + str(problem)[:20]
    return "found"


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(("call", "through"), [(place, [[0.0], [1.0]]), (observer_gain, [[0.0, 1.0]])])
def test_a_fast_request_is_granted_in_any_unit_of_time(call, through, factor: float) -> None:
    A = np.array([[0.0, 1.0], [2.0, 0.0]]) if call is place else np.array([[0.0, 2.0], [1.0, 0.0]])
    found = call(A * factor, through, np.array([-1e5, -2e5]) * factor)
    assert found.error < 1e-9 * 2e5 * factor


@pytest.mark.parametrize("shared", [True, False])
def test_a_common_factor_is_found_in_any_unit_of_time(shared: bool) -> None:
    """(s + 1)(s + 2) and s + 1 have one, (s + 1)(s + 2) and s + 3 have none."""
    words = set()
    for factor in (1.0, *FACTORS):
        num, den = np.array([1.0, 1.0 if shared else 3.0]), np.array([1.0, 3.0, 2.0])
        wanted = np.poly([-4.0, -5.0, -6.0])
        powers = factor ** np.arange(4)
        words.add(_word(diophantine, den * powers[:3], num * powers[:2], wanted * powers)[:9])
    assert words == ({"EngineErr"} if shared else {"found"})


@pytest.mark.parametrize("seed", range(3))
def test_a_bilinear_observer_exists_in_every_unit_of_time_or_in_none(seed: int) -> None:
    rng = np.random.default_rng((79, seed))
    A, B, F = rng.standard_normal((3, 3)) - 3 * np.eye(3), rng.standard_normal((3, 1)), 0.3 * rng.standard_normal((3, 3))
    C, K = np.eye(2, 3), rng.standard_normal((1, 3))
    words = {_word(bilinear_functional_observer, f * A, f * B, f * F, C, K, -4.0 * f)[:9] for f in (1.0, *FACTORS)}
    assert len(words) == 1, words


def test_a_plant_sampled_for_ages_in_nanoseconds_is_a_plant() -> None:
    assert Plant([[0.5]], [[1.0]], [[1.0]], dt=3e9).dt == 3e9
