"""Margins of a loop: closed forms, laws, peers."""

import control
import numpy as np
import pytest
from doyle_loop import DOYLE, ONES, doyle
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.engine import EngineError, Plant, ShapeError, compensator, dlqe, dlqr, loop_margins, lqe, lqr, recover, sensitivity
from observer_lab.engine.feedback import DiskMargin, margins, state_feedback_margins
from observer_lab.engine.systems import discretise
from observer_lab.plants.platform import model


def lqg(seed, n=4, m=2, p=2):
    rng = np.random.default_rng(seed)
    plant = Plant(rng.standard_normal((n, n)), rng.standard_normal((n, m)), rng.standard_normal((p, n)))
    K = lqr(plant.A, plant.B, np.eye(n), np.eye(m)).gain
    return plant, K, compensator(plant, K, lqe(plant.A, plant.B, plant.C, np.eye(m), np.eye(p)).gain)


def stable(plant, controller, into=None, out=None):
    """Whether plant and controller are stable with gains (possibly complex) `into` each input and `out` of each output."""
    into = np.eye(plant.m) if into is None else np.diag(into)
    out = np.eye(plant.p) if out is None else np.diag(out)
    A = np.block([[plant.A, plant.B @ into @ controller.C], [controller.B @ out @ plant.C, controller.A]])
    poles = np.linalg.eigvals(A)
    return bool((np.abs(poles) < 1).all() if plant.dt else (poles.real < 0).all())


# --- closed forms and published numbers --------------------------------------------------------------------------------
@pytest.mark.parametrize("q, sigma", [(1, 1), (60, 60), (1, 32), (1000, 1000)])
def test_doyle_1978_gain_margin_is_one_plus_one_over_df(q, sigma):
    d, f = 2 + np.sqrt(4 + sigma), 2 + np.sqrt(4 + q)
    margins = loop_margins(DOYLE, doyle(q, sigma)).inputs[0]
    assert margins.gain[1] == pytest.approx(1 + 1 / (d * f), rel=1e-9)
    assert margins.gain_frequencies[1] == 0.0


def test_doyle_1978_comes_nearest_to_minus_one_at_frequency_zero():
    """Published: min|1 + L| = 0.0528 for q = σ = 1, at ω = 0, where a sweep from 1e-3 up does not look."""
    margins = loop_margins(DOYLE, doyle(1, 1)).inputs[0]
    assert margins.nearest == pytest.approx(0.0528, abs=5e-5)
    assert margins.nearest == pytest.approx(1 / (1 + (2 + np.sqrt(5)) ** 2), rel=1e-9)  # |1 − df/(1 + df)|
    assert margins.peak_frequency == 0.0


@pytest.mark.parametrize("gain", [0.5, 1.5, 3.0, 20.0])
def test_integrator_with_lag_in_closed_form(gain):
    """ℓ = k/(s(s+1)): |ℓ| = 1 at ω² = (√(1 + 4k²) − 1)/2, phase margin atan(1/ω), delay that over ω, gain margin ∞."""
    plant = Plant([[0, 1], [0, -1]], [[0], [1]], [[1, 0]])
    w = np.sqrt((np.sqrt(1 + 4 * gain**2) - 1) / 2)
    margins = loop_margins(plant, [[-gain]]).inputs[0]
    assert margins.gain == (0.0, np.inf)
    assert margins.phase == pytest.approx(np.arctan(1 / w), rel=1e-9)
    assert margins.phase_frequency == pytest.approx(w, rel=1e-9)
    assert margins.delay == pytest.approx(np.arctan(1 / w) / w, rel=1e-9)


def test_third_order_gain_margin_in_closed_form():
    """ℓ = k/(s+1)³ is stable up to k = 8, at ω = √3; for negative k down to −1, at ω = 0."""
    plant = Plant([[-1, 1, 0], [0, -1, 1], [0, 0, -1]], [[0], [0], [1]], [[1, 0, 0]])
    margins = loop_margins(plant, [[-2.0]]).inputs[0]
    assert margins.gain[1] == pytest.approx(4, rel=1e-9)
    assert margins.gain_frequencies[1] == pytest.approx(np.sqrt(3), rel=1e-9)
    assert margins.gain[0] == 0.0 and margins.name == "u1"
    assert loop_margins(plant, [[0.5]]).inputs[0].gain == (0.0, pytest.approx(2, rel=1e-9))


def test_loop_below_one_everywhere_has_no_phase_and_no_delay_limit():
    margins = loop_margins(Plant([[-1.0]], [[1.0]], [[1.0]]), [[-0.5]]).inputs[0]
    assert margins.phase == pytest.approx(np.pi) and margins.delay == np.inf


def test_direct_loop_above_one_at_infinity_stands_no_delay():
    """ℓ(∞) = 2: stable as it is, unstable with any delay."""
    assert loop_margins(Plant([[-1.0]], [[1.0]], [[1.0]], [[2.0]]), [[-1.0]]).inputs[0].delay == 0.0


def test_resonance_a_thousand_times_narrower_than_a_sweep_is_not_missed():
    """ζ = 1e-7: the peak of S of a light positive feedback, 1/(1 − g) at resonance."""
    zeta = 1e-7
    plant = Plant([[0, 1], [-1, -2 * zeta]], [[0], [2 * zeta]], [[0, 1]])
    margins = loop_margins(plant, [[0.9]]).inputs[0]  # P(j) = 1
    assert margins.sensitivity_peak == pytest.approx(10, rel=1e-6)
    assert margins.gain[1] == pytest.approx(1 / 0.9, rel=1e-6)


# --- laws --------------------------------------------------------------------------------------------------------------
@settings(max_examples=25)
@given(seed=st.integers(0, 10_000))
def test_lqr_keeps_its_guarantees(seed):
    """One input: |1 + ℓ| ≥ 1, gain margin (≤ ½, ∞), phase ≥ 60°. Kalman (1964)."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 6))
    plant = Plant(rng.standard_normal((n, n)), rng.standard_normal((n, 1)), np.eye(n))
    margins = state_feedback_margins(plant, lqr(plant.A, plant.B, np.eye(n), 1.0).gain).inputs[0]
    assert margins.sensitivity_peak <= 1 + 1e-7
    assert margins.gain[0] <= 0.5 + 1e-7 and margins.gain[1] == np.inf
    assert margins.phase >= np.pi / 3 - 1e-7


@pytest.mark.parametrize("seed", range(6))
def test_gain_and_phase_limits_are_where_stability_ends(seed):
    plant, _, controller = lqg(seed)
    margins = loop_margins(plant, controller)
    assert margins.stable
    for i, channel in enumerate((*margins.inputs, *margins.outputs)):
        def holds(factor, i=i):
            gains = np.ones(4, dtype=complex)
            gains[i] = factor
            return stable(plant, controller, gains[:2], gains[2:])

        low, high = channel.gain
        assert holds(high * (1 - 1e-5)) and not holds(high * (1 + 1e-5)) if np.isfinite(high) else holds(1e5)
        assert holds(low * (1 + 1e-5)) and not holds(low * (1 - 1e-5)) if low else holds(1e-6)
        if channel.phase < np.pi:
            turn = np.exp(1j * channel.phase * (1 + 1e-5))
            assert not (holds(turn) and holds(turn.conjugate()))
        turn = np.exp(1j * channel.phase * (1 - 1e-5))
        assert holds(turn) and holds(turn.conjugate())


@pytest.mark.parametrize("seed", range(4))
def test_every_gain_inside_the_disk_of_all_channels_is_survived(seed):
    plant, _, controller = lqg(seed)
    margins, rng = loop_margins(plant, controller), np.random.default_rng(seed)
    for part, count, radius in ((margins.all_inputs, (2, 0), 0.999), (margins.all_outputs, (0, 2), 0.999),
                                (margins.both, (2, 2), 0.999)):
        assert part.unstructured.alpha <= part.disk.alpha * (1 + 1e-9)
        for _ in range(60):
            delta = radius * np.exp(2j * np.pi * rng.random(sum(count)))
            factor = (1 + delta * part.disk.alpha / 2) / (1 - delta * part.disk.alpha / 2)
            into = factor[:count[0]] if count[0] else np.ones(2)
            out = factor[count[0]:] if count[1] else np.ones(2)
            assert stable(plant, controller, into, out)
    single = [c.disk.alpha for c in margins.inputs]
    assert margins.all_inputs.disk.alpha <= min(single) * (1 + 1e-9)
    assert margins.both.disk.alpha <= min(margins.all_inputs.disk.alpha, margins.all_outputs.disk.alpha) * (1 + 1e-9)


def test_disk_margin_of_one_channel_is_attained():
    """The worst complex factor on the rim puts a pole on the axis: one pair is unstable just outside."""
    plant, controller = DOYLE, doyle(1, 1)
    disk = loop_margins(plant, controller).inputs[0].disk
    angles = np.exp(2j * np.pi * np.arange(3600) / 3600) * 1.001 * disk.alpha / 2
    assert not all(stable(plant, controller, [(1 + d) / (1 - d)]) for d in angles)
    assert all(stable(plant, controller, [(1 + d) / (1 - d)]) for d in angles / 1.002)


def test_disk_margin_gives_its_own_gain_and_phase():
    disk = DiskMargin(2 / 3, 1.0)
    assert disk.gain == pytest.approx((0.5, 2.0)) and disk.phase == pytest.approx(2 * np.arctan(1 / 3))
    assert DiskMargin(2.5, 1.0).gain[1] == np.inf


def test_structured_margin_does_not_depend_on_the_units_of_the_signals():
    plant, _, controller = lqg(1)
    U, Y = np.diag([1e3, 1e-4]), np.diag([1e-6, 1e2])
    scaled = Plant(plant.A, plant.B @ U, Y @ plant.C)
    turned = Plant(controller.A, controller.B @ np.linalg.inv(Y), np.linalg.inv(U) @ controller.C)
    one, other = loop_margins(plant, controller), loop_margins(scaled, turned)
    for name in ("all_inputs", "all_outputs", "both"):
        assert getattr(other, name).disk.alpha == pytest.approx(getattr(one, name).disk.alpha, rel=1e-3)
    assert other.inputs[1].gain == pytest.approx(one.inputs[1].gain, rel=1e-6)


# --- peers -------------------------------------------------------------------------------------------------------------
@pytest.mark.slow
@pytest.mark.skipif(not hasattr(control, "disk_margins"), reason="python-control has them from 0.10.2 on")
@pytest.mark.parametrize("seed", range(4))
def test_python_control_agrees_on_one_channel(seed):
    plant, _, controller = lqg(seed, 4, 1, 1)
    loop = -control.ss(controller.A, controller.B, controller.C, 0) * control.ss(plant.A, plant.B, plant.C, 0)
    ours = loop_margins(plant, controller).inputs[0]
    close = np.linspace(0.98, 1.02, 401)  # the sweep is coarse but for where the extremes are said to be
    omega = np.unique(np.concatenate([[1e-6], np.geomspace(1e-4, 1e4, 2000), ours.disk.frequency * close, ours.peak_frequency * close]))
    omega = omega[(omega > 0) & np.isfinite(omega)]
    alpha, _, _ = control.disk_margins(loop, omega)
    assert ours.disk.alpha == pytest.approx(float(np.asarray(alpha)), rel=1e-4)
    assert ours.sensitivity_peak == pytest.approx((1 / np.abs(1 + loop(1j * omega))).max(), rel=1e-5)
    _, phases, _, _, at, _ = control.stability_margins(loop, returnall=True)
    nearest = np.abs((np.asarray(phases) + 180) % 360 - 180)
    assert np.rad2deg(ours.phase) == pytest.approx(nearest.min(), rel=1e-4)
    assert ours.phase_frequency == pytest.approx(at[nearest.argmin()], rel=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_sensitivity_is_the_inverse_of_one_plus_the_loop(seed):
    plant, _, controller = lqg(seed, 3, 1, 2)
    loop = sensitivity(plant, controller)
    for w in (0.1, 1.0, 30.0):
        P = plant.C @ np.linalg.solve(1j * w * np.eye(3) - plant.A, plant.B)
        Kc = controller.C @ np.linalg.solve(1j * w * np.eye(3) - controller.A, controller.B)
        S = loop.at(np.array([w]))[0]
        np.testing.assert_allclose(S[:1, :1], np.linalg.inv(np.eye(1) - Kc @ P), rtol=1e-9)
        np.testing.assert_allclose(S[1:, 1:], np.linalg.inv(np.eye(2) - P @ Kc), rtol=1e-9)
        np.testing.assert_allclose(loop.along(2)(np.array([w]))[0], S[2, 2], rtol=1e-12)
    np.testing.assert_array_equal(loop.at(np.array([np.inf]))[0], np.eye(3))
    assert loop.omega[0] == 0 and loop.omega[-1] == np.inf


def test_unstable_loop_has_no_margins():
    margins = loop_margins(DOYLE, [[-1.0]])
    assert not margins.stable and margins.inputs[0].gain == (1.0, 1.0) and margins.inputs[0].phase == 0
    assert margins.both.disk.alpha == 0 and margins.outputs[0].sensitivity_peak == np.inf


def test_sampled_loop_is_judged_on_the_unit_circle():
    plant = discretise(DOYLE, 0.05)
    K = dlqr(plant.A, plant.B, ONES, 1).gain
    controller = compensator(plant, K, dlqe(plant.A, np.eye(2), plant.C, 10 * np.eye(2), 1).gain)
    channel = loop_margins(plant, controller).inputs[0]
    for edge, inward in zip(channel.gain, (1 + 1e-5, 1 - 1e-5), strict=True):
        assert stable(plant, controller, [edge * inward]) and not stable(plant, controller, [edge / inward])
    assert sensitivity(plant, controller).omega[-1] == pytest.approx(np.pi / 0.05)


def test_platform_lqg_has_named_margins_and_a_loop_stable_to_them():
    whole = model.plant()
    plant = Plant(whole.A, whole.B[:, :3], whole.C, None, 0.0, whole.state_names, model.COIL_IDS, model.SENSOR_IDS)
    K = lqr(plant.A, plant.B, plant.C.T @ np.diag([1e8, 1e10, 1e8, 1e10]) @ plant.C * 100, 0.1 * np.eye(3)).gain
    L = lqe(plant.A, whole.B[:, 3:], plant.C, 1e-12 * np.eye(2), 1e-9 * np.eye(4)).gain
    controller = compensator(plant, K, L)
    margins = loop_margins(plant, controller)
    assert margins.stable and [c.name for c in margins.inputs] == ["u1", "u2", "u3"]
    assert [c.name for c in margins.outputs] == ["VL", "HL", "VR", "HR"]
    for i, channel in enumerate(margins.inputs):
        for edge, inward in zip(channel.gain, (1 + 1e-4, 1 - 1e-4), strict=True):
            if 0 < edge < np.inf:
                gains = np.ones(3)
                gains[i] = edge * inward
                assert stable(plant, controller, gains)
                gains[i] = edge / inward
                assert not stable(plant, controller, gains)


@pytest.mark.parametrize("call, sentence", [
    (lambda: loop_margins(DOYLE, np.zeros((2, 2))), "1 inputs and 1 outputs"),
    (lambda: loop_margins(DOYLE, Plant([[0.5]], [[1]], [[1]], dt=0.1)), "sampling period"),
    (lambda: loop_margins(Plant([[-1]], [[1]], [[1]], [[2]]), [[0.5]]), "ill-posed"),
    (lambda: recover(DOYLE, [[4, 4]], 1, 1, -1), "at least 0"),
    (lambda: recover(discretise(DOYLE, 0.1), [[4, 4]], 1, 1, 1), "continuous"),
    (lambda: recover(DOYLE, [[4, 4]], 1, 1, 1, G=[[1]]), "G must have 2 rows"),
])
def test_bad_input_gets_one_sentence(call, sentence):
    with pytest.raises((EngineError, ShapeError), match=sentence):
        call()


def test_a_large_static_gain_alone_does_not_make_a_loop_ill_posed() -> None:
    """A plant without a direct path is well posed under any gain, however large."""
    plant = Plant([[-1.0]], [[1.0]], [[1.0]])
    margins = loop_margins(plant, [[-1e9]])
    assert margins.stable and margins.inputs[0].nearest == pytest.approx(1.0)


def test_one_input_says_what_all_inputs_say_of_it() -> None:
    rng = np.random.default_rng(3)
    plant = Plant(-np.eye(3) + 0.5 * rng.standard_normal((3, 3)), rng.standard_normal((3, 2)), rng.standard_normal((2, 3)))
    margins = loop_margins(plant, -0.3 * np.eye(2))
    assert repr(margins.input(1)) == repr(margins.inputs[1])  # NaN where there is no crossing


def test_the_disk_margin_of_all_inputs_by_itself_is_that_of_the_whole_report() -> None:
    rng = np.random.default_rng(5)
    for m in (1, 2, 3):
        plant = Plant(rng.standard_normal((5, 5)) - 3 * np.eye(5), rng.standard_normal((5, m)), rng.standard_normal((2, 5)))
        found = loop_margins(plant, 0.2 * rng.standard_normal((m, 2)))
        assert found.input_disk == found.all_inputs.disk
    runaway = Plant(np.eye(1), np.eye(1), np.eye(1))
    assert loop_margins(runaway, np.array([[1.0]])).input_disk.alpha == 0


def test_the_largest_singular_value_is_the_one_of_a_decomposition() -> None:
    rng = np.random.default_rng(3)
    for size in (1, 2, 3):
        matrices = rng.standard_normal((2, 60, size, size, 2)) @ [1, 1j] * 10.0 ** rng.uniform(-8, 8, (2, 60, size, 1))
        matrices[0, :20, -1] = matrices[0, :20, 0] * (1 + 1e-9)  # nearly singular
        matrices[1, 0] = 0.0
        assert np.allclose(margins._largest(matrices), np.linalg.svd(matrices, compute_uv=False)[..., 0], rtol=1e-13, atol=0)
        assert np.all(margins._structured(matrices) <= (1 + 1e-12) * margins._largest(matrices))
