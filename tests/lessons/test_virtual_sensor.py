"""Lesson 1: the open-loop copy forgets only as the chip does; the observer forgets as it is told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.signal import lfilter

from observer_lab.lessons import LESSONS
from observer_lab.lessons.virtual_sensor.knobs import RUNAWAY_ID
from observer_lab.lessons.virtual_sensor.lesson import LESSON
from observer_lab.lessons.virtual_sensor.study import burst, stable_trusts
from observer_lab.plants import MODELS


def outcome(**changes):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def words(language: str) -> str:
    w = LESSON.words[language]
    return "\n".join([w.introduction, w.reveal, *(body for _, body in w.steps),
                      *(task.solution for task in w.tasks.values())])


@pytest.mark.parametrize("plant", ["chip", RUNAWAY_ID])
def test_the_copy_error_is_the_matrix_exponential_of_the_plant_whatever_the_power(plant):
    model = MODELS[plant]
    for power in (0.0, 10.0, 37.0):
        copy = outcome(plant=plant, power=power).study.copy
        e0 = np.subtract(model.x0, (0.0, 0.0))
        for k in (100, 300, 500):
            assert copy.e[k] == pytest.approx(expm(model.plant.A * copy.t[k]) @ e0, abs=1e-9)


def test_the_copy_never_recovers_an_unstable_start_and_the_observer_does():
    m = outcome(plant=RUNAWAY_ID).metrics
    assert m["slowest_copy"] > 0 > m["slowest_observer"]
    assert m["copy_core_error"] > 80 and m["core_error"] < 1e-6


def test_only_the_share_of_the_start_in_the_unstable_mode_is_never_forgiven():
    values, vectors = np.linalg.eig(MODELS[RUNAWAY_ID].plant.A)
    stable = vectors[:, np.argmin(values)].real
    start = np.array(MODELS[RUNAWAY_ID].x0) - 10.0 * stable
    copy = outcome(plant=RUNAWAY_ID, guess_core=float(start[0]), guess_case=float(start[1])).study.copy
    assert np.linalg.norm(copy.e[-1]) < 1e-3 * np.linalg.norm(copy.e[0])


def test_no_trust_is_the_copy():
    o = outcome(trust=0.0)
    assert np.array_equal(o.run.xhat, o.study.copy.xhat)
    assert o.poles["observer"] == pytest.approx(o.poles["copy"])


def test_the_gain_is_trust_times_the_gain_of_the_poles():
    half, full = outcome(trust=0.5), outcome()
    assert half.gains["L"] == pytest.approx(0.5 * full.gains["L"], rel=1e-12)
    assert full.poles["observer"] == pytest.approx([-1.6 - 0.5j, -1.6 + 0.5j])


def test_least_trust_is_where_the_observer_of_the_runaway_chip_becomes_stable():
    plant = MODELS[RUNAWAY_ID].plant
    L = outcome(plant=RUNAWAY_ID).gains["L"]
    theta, most = stable_trusts(plant, L)
    slow = [max(np.linalg.eigvals(plant.A - k * theta * L @ plant.C).real) for k in (0.999, 1.001)]
    assert slow[0] > 0 > slow[1] and most > 2
    assert stable_trusts(MODELS["chip"].plant, L)[0] < 0


@pytest.mark.parametrize("plant", ["chip", RUNAWAY_ID])
@pytest.mark.parametrize("poles", [(-1.6 - 0.5j, -1.6 + 0.5j), (-4.0, 0.5), (-3.9, 0.9),
                                   (0.2 - 1j, 0.2 + 1j), (0.5, 0.8), (-0.05, -0.06)], ids=str)
@pytest.mark.parametrize("trust", [0.0, 0.3, 1.0, 2.0])
def test_too_small_too_large_and_forgives_are_said_of_eigenvalues_that_say_so(plant, poles, trust):
    o = outcome(plant=plant, observer_poles=poles, trust=trust)
    L = outcome(plant=plant, observer_poles=poles).gains["L"]
    model = MODELS[plant].plant
    grid = np.linspace(0, 2, 401)
    stable = np.array([max(np.linalg.eigvals(model.A - theta * L @ model.C).real) < -1e-9 for theta in grid])
    live, locus = o.live("en"), next(f for f in LESSON.figures(o) if f.id == "locus").caption("en")
    if "too small" in live:
        assert stable[grid > trust].any() and not stable[grid <= trust].any()
    if "too large" in live:
        assert stable[grid < trust].any() and not stable[grid >= trust].any()
    assert ("grows" in live) == (o.metrics["slowest_observer"] >= 0)
    assert ("No θ" in locus) == (not stable.any())
    if "forgives" in locus:
        assert stable.all()
    if "between" in locus:
        assert stable.any() and not stable[-1]
    if "needs θ above" in locus:
        assert not stable[0] and stable[-1]


def test_the_locus_starts_at_the_copy_and_passes_the_present_poles():
    o = outcome(trust=1.0)
    assert np.sort_complex(o.study.poles[0]) == pytest.approx(o.poles["copy"])
    at = int(np.argmin(np.abs(o.study.trusts - 1.0)))
    assert np.sort_complex(o.study.poles[at]) == pytest.approx(o.poles["observer"])


def test_a_noisier_sensor_shakes_the_trusting_observer_more():
    def shake(trust: float) -> float:
        return float(np.std(outcome(trust=trust, noise=1.0, guess_core=45, guess_case=20).run.e[:, 0]))
    assert 0.0 < shake(0.1) < 0.5 * shake(2.0)


@pytest.mark.parametrize("language", ["en", "zh"])
def test_the_numbers_in_the_text_are_the_engines(language):
    text = words(language)
    tame, wild = outcome(), outcome(plant=RUNAWAY_ID)
    fast = outcome(observer_poles=(-3.0, -3.5))
    little = outcome(plant=RUNAWAY_ID, trust=0.1)
    slow, grow = tame.metrics["slowest_copy"], wild.metrics["slowest_copy"]
    fan = [outcome(air_error=40, trust=theta).metrics for theta in (0.3, 1.0)]
    L, quick, small = tame.gains["L"], fast.gains["L"], little.gains["L"]
    pole = little.poles["observer"][1]
    for number in (
            f"{slow:.3g}", f"{-1 / slow:.1f} s", f"{tame.study.copy.e[-1, 0]:.2f} K", f"{tame.metrics['known_after']:.2f} s",
            rf"L=({L[0, 0]:.3g},\ {L[1, 0]:.3g})", f"{grow:+.3f}", f"{math.log(2) / grow:.1f} s",
            f"{wild.metrics['copy_core_error']:.1f} K", f"{wild.metrics['least_trust']:.4f}",
            *(f"{m[key]:.2f} K" for m in fan for key in ("case_error", "core_error")),
            rf"L=({quick[0, 0]:.3g},\ {quick[1, 0]:.3g})", f"{fast.metrics['largest_guess']:.0f} K",
            rf"({small[0, 0]:.3g},\ {small[1, 0]:.3g})", rf"{pole.real:.3g}\pm{pole.imag:.3g}j",
            f"{little.metrics['core_error']:.3f} K"):
        assert number in text, number


@pytest.mark.parametrize("air_error", [-50.0, -30.0, 40.0])
def test_a_core_gain_of_one_keeps_a_wrong_fan_away_from_the_core(air_error):
    run = outcome(air_error=air_error, trust=1.0 / outcome(air_error=air_error).gains["L"][0, 0]).run
    assert run.e[:, 0] == pytest.approx(45.0 * np.exp(-run.t), abs=1e-9)
    assert np.max(np.abs(run.e[-50:, 1])) > 0.1


def test_more_trust_is_not_more_truth_when_the_fan_is_wrong():
    few, many = (outcome(air_error=40, trust=theta).metrics for theta in (0.3, 1.0))
    assert many["case_error"] < few["case_error"] and many["core_error"] > few["core_error"]


def test_the_power_is_a_burst_and_a_rest():
    u = burst(8.0)[:, 0]
    assert len(u) == 501 and u[0] == u[99] == 8.0 and u[100] == u[199] == 2.0 and u[200] == 8.0


@settings(max_examples=40)
@given(st.sampled_from(["chip", RUNAWAY_ID]), st.floats(0, 2), st.floats(-4, 1), st.floats(-4, 1), st.floats(-50, 50),
       st.floats(0, 2), st.floats(-1, 15))
def test_every_setting_gives_figures_of_one_length(plant, trust, p, q, air, noise, kick):
    o = outcome(plant=plant, trust=trust, observer_poles=(p, q), air_error=air, noise=noise, kick=kick)
    for figure in LESSON.figures(o):
        assert np.all(np.isfinite([value for entry in figure.entries() for value in entry if isinstance(value, float)]))


@pytest.mark.parametrize("pole", [-0.7, -1.6, -3.0])
@pytest.mark.parametrize("plant", ["chip", RUNAWAY_ID])
def test_the_reduced_order_core_follows_its_pole_alone(plant, pole):
    """ė₁ = (a₁₁ − ℓ a₂₁) e₁ on a true model, whatever the power; the case is the reading."""
    o = outcome(plant=plant, reduced=True, observer_poles=(pole, pole - 0.5), power=23.0)
    e = o.run.x - o.study.reduced
    np.testing.assert_allclose(e[:, 0], e[0, 0] * np.exp(pole * o.run.t), atol=1e-8)
    assert e[0, 0] == pytest.approx(o.run.x[0, 0]) and np.abs(e[:, 1]).max() < 1e-9


@pytest.mark.parametrize("guess", [-60.0, 60.0])
@pytest.mark.parametrize("poles", [(1.0, 0.9), (1.0, -4.0), (0.5, 0.5)])
@pytest.mark.parametrize("trust", [0.0, 1.0, 3.0])
def test_curves_end_together_where_one_of_the_observers_diverges(trust, poles, guess):
    lesson = LESSONS["virtual-sensor"]
    knob = lesson.knob("guess_core")
    design = lesson.apply(lesson.start(), {"reduced": True, "observer_poles": poles, "trust": min(trust, lesson.knob("trust").high),
                                           "guess_core": min(max(guess, knob.low), knob.high)})
    outcome = lesson.compute(design)
    assert len(outcome.study.reduced) == len(outcome.run.t) > 1
    assert all(len(curve.y) == len(figure.x) for figure in lesson.figures(outcome) for curve in getattr(figure, "curves", ())
               if curve.x is None)


@pytest.mark.parametrize("pole", [-0.7, -1.0, -1.6])
def test_the_noise_that_the_reduced_observer_passes_on_is_that_of_many_readings(pole):
    """Its recursion written out here, over a hundred thousand readings, beside the closed form."""
    (a11, a12), (a21, a22) = MODELS["chip"].plant.A
    gain, dt = (a11 - pole) / a21, 0.03
    v = np.random.default_rng(4).standard_normal(100_000)
    drive = (pole * gain + a12 - gain * a22) * math.expm1(pole * dt) / pole
    w = lfilter([0.0, drive], [1.0, -math.exp(pole * dt)], v)
    told = outcome(reduced=True, noise=1.0, observer_poles=(pole, pole - 1)).metrics["reduced_sigma"]
    assert told == pytest.approx(np.std(w + gain * v), rel=0.02)


def test_the_full_observer_filters_the_noise_that_the_reduced_one_passes_at_once():
    m = outcome(reduced=True, noise=1.0).metrics
    assert m["reduced_sigma"] > 10 * m["core_sigma"] > 0
