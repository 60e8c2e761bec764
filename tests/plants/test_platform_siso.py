"""The platform's decoupled controllers: published coefficients to fifty digits, signs, suppression, the pitch claim."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from observer_lab.engine import Plant, frequency_response, loop_margins, noisy_loop, sensitivity
from observer_lab.engine.design import loop_shaped, negated, polynomial_roots
from observer_lab.engine.structure import mixing_matrix
from observer_lab.engine.systems import match_poles
from observer_lab.plants.platform import model
from observer_lab.plants.platform import siso_loops as siso
from observer_lab.plants.platform.channels import HORIZONTAL, ROTATION, VERTICAL_CHANNEL, T_u, T_y
from observer_lab.plants.platform.lqg_weights import FIGURE_WEIGHTS, coils, ground, lqg

PLANT = model.plant()
COILS, G = coils(PLANT), ground(PLANT)
FREQUENCY = np.unique(np.concatenate([np.geomspace(0.01, 100, 800), np.linspace(0.9, 1.6, 1500)]))
DRIFT = 1e-7  # rad/s


def peaks(controller: Plant, plant: Plant = PLANT) -> np.ndarray:
    """How far each channel's highest peak over ground motion comes down, in dB."""
    tops = []
    for built in (None, controller):
        loop = noisy_loop(coils(plant), built, ground(plant), 1e-12)
        tops.append(loop.psd(FREQUENCY, loop.outputs(T_y[:3])).max(axis=0))
    return 10 * np.log10(tops[0] / tops[1])


def rightmost(controller: Plant) -> float:
    """The rightmost pole of the loop but for those that stand on the plant's zero at s = 0."""
    poles = sensitivity(COILS, controller).poles
    return float(poles.real[np.abs(poles) > DRIFT].max())


@pytest.mark.parametrize("numerator, denominator, plant", [
    (siso.CV_NUMERATOR, siso.CV_DENOMINATOR, siso.published_cv()),
    (siso.CH_NUMERATOR, siso.CH_DENOMINATOR, siso.published_ch()),
])
def test_the_published_controllers_are_their_printed_polynomials(numerator, denominator, plant: Plant) -> None:
    omega = np.geomspace(1e-6, 1e6, 60)
    ours = frequency_response(plant.A, plant.B, plant.C, plant.D, omega)[:, 0, 0]
    with mpmath.workdps(60):
        top, bottom = ([mpmath.mpf(repr(c)) for c in p[::-1]] for p in (numerator, denominator))
        right = [complex(mpmath.polyval(top, mpmath.mpc(0, w), asc=True) / mpmath.polyval(bottom, mpmath.mpc(0, w), asc=True))
                 for w in omega]
    assert np.abs(ours / np.array(right) - 1).max() < 1e-11


def test_cv_is_a_constant_with_a_pole_on_the_wrong_side() -> None:
    zeros, poles = polynomial_roots(siso.CV_NUMERATOR), polynomial_roots(siso.CV_DENOMINATOR)
    assert zeros == pytest.approx([-5.7789e-9 - 1.42806e-5j, -5.7789e-9 + 1.42806e-5j], rel=1e-4)
    assert poles == pytest.approx([-1.366e5, -9.8755e-4, 7.93921e-11], rel=1e-4)
    c = siso.published_cv()
    H = frequency_response(c.A, c.B, c.C, c.D, 2 * np.pi * np.geomspace(0.1, 10, 50))[:, 0, 0]
    assert np.abs(H / -3.1252e4 - 1).max() < 2e-3


def test_ch_is_stable_and_its_three_dipoles_are_no_modes_of_this_plant() -> None:
    zeros, poles = polynomial_roots(siso.CH_NUMERATOR), polynomial_roots(siso.CH_DENOMINATOR)
    assert len(zeros) == 11 and len(poles) == 12
    assert zeros.real.max() < 0 and poles.real.max() < 0
    light = [p for p in poles if p.imag > 0 and -p.real < 0.35 * abs(p)]
    gaps = [float(min(abs(zeros - p))) / abs(p) for p in light]
    assert len(light) == 3 and min(gaps) > 6e-4 and max(gaps) < 7.5e-3
    modes = [abs(p) for p in PLANT.poles if p.imag > 0]
    assert min(abs(abs(p) / w - 1) for p in light for w in modes) > 0.5


def test_one_choice_of_signs_alone_is_stable() -> None:
    """v = +C_v z and v = −C_h z; C_v's own pole stays where the plant's zero at s = 0 hides it."""
    cv, ch = siso.published_cv(), siso.published_ch()
    found = {(a, b): rightmost(siso.from_channels(cv if a > 0 else negated(cv), None, ch if b > 0 else negated(ch)))
             for a in (1, -1) for b in (1, -1)}
    assert found[1, -1] < 0
    assert min(v for k, v in found.items() if k != (1, -1)) > 1e-4


def test_the_loops_own_drift_pole_in_fifty_digits() -> None:
    """1 = C_v P_v near s = 0 keeps C_v's pole within 1e-4 of itself: a loop that grows e-fold in four hundred years."""
    B, A = siso.rigid_polynomials(VERTICAL_CHANNEL)
    with mpmath.workdps(60):
        def characteristic(s: mpmath.mpf) -> mpmath.mpf:
            value = [mpmath.polyval([mpmath.mpf(float(c)) for c in p[::-1]], s, asc=True)
                     for p in (A, siso.CV_DENOMINATOR, B, siso.CV_NUMERATOR)]
            return value[0] * value[1] - value[2] * value[3]
        root = float(mpmath.findroot(characteristic, (mpmath.mpf("7e-11"), mpmath.mpf("9e-11"))))
    assert root == pytest.approx(7.9392e-11, rel=1e-3)
    assert 1 / root / 3.156e7 == pytest.approx(399, rel=0.01)


def test_peaks_come_down_as_far_as_the_facts_say() -> None:
    assert peaks(siso.published()) == pytest.approx([93.5, 88.0, 105.0], abs=0.1)


@pytest.mark.parametrize("millimetres", [2.0, 3.0, 4.5, -2.0, -4.5])
def test_the_rotation_of_the_report_comes_out_with_the_coil_a_few_millimetres_off_the_spring(millimetres: float) -> None:
    down = peaks(siso.published(), model.plant(model.Parameters(lower=1e-3 * millimetres)))
    assert 20 < down[1] < 30 and down[[0, 2]] == pytest.approx([93.5, 105.0], abs=0.1)


@pytest.mark.parametrize("channel", [VERTICAL_CHANNEL, ROTATION, HORIZONTAL])
def test_the_rigid_channels_are_near_the_true_ones(channel) -> None:
    B, A = siso.rigid_polynomials(channel)
    P, s = siso.channel_plant(channel), 2j * np.pi * np.array([0.1, 0.8, 1.1, 1.3, 3.0])
    H = frequency_response(P.A, P.B, P.C, P.D, s.imag)[:, 0, 0]
    assert np.abs(np.polyval(B, s) / np.polyval(A, s) / H - 1).max() < 3e-4


def test_rigid_channels_with_a_mixing_are_those_of_the_mixed_deck() -> None:
    S, deck, w = mixing_matrix(0.17, 0.04, size=3, channels=(1, 2)), model.deck(), 7.0
    H = T_y[:3] @ frequency_response(deck.A, deck.B, deck.C, deck.D, [w])[0] @ T_u @ S
    for i, channel in enumerate(siso.THREE):
        B, A = siso.rigid_polynomials(channel, S)
        assert np.polyval(B, 1j * w) / np.polyval(A, 1j * w) == pytest.approx(H[i, i], rel=1e-9)


def test_our_pair_isolates_with_margins() -> None:
    controller = siso.designed()
    assert rightmost(controller) < -0.01
    assert peaks(controller) == pytest.approx([69.7, 43.7, 67.0], abs=0.3)
    for channel, part in ((VERTICAL_CHANNEL, loop_shaped(siso.VERTICAL_SHAPE)), (HORIZONTAL, siso.horizontal_by_poles().controller())):
        margin = loop_margins(siso.channel_plant(channel), part).inputs[0]
        assert margin.sensitivity_peak < 1.3 and margin.phase > np.radians(60)


def test_the_eight_poles_are_reached_on_the_rigid_deck() -> None:
    for control, observer in (siso.BESIDE_THE_ZEROS, siso.AT_WILL):
        found = siso.horizontal_by_poles(control, observer)
        asked = np.array([*control, *observer])
        assert found.residual < 1e-12
        assert match_poles(asked, found.poles)[1] < 1e-4 * np.abs(asked).max()


@pytest.mark.parametrize("lower", [-0.02, 0.005, 0.02])
def test_a_coil_off_the_springs_line_is_in_the_rigid_polynomials_too(lower: float) -> None:
    k = model.Parameters(lower=lower)
    B, A = siso.rigid_polynomials(HORIZONTAL, None, k)
    P, s = siso.channel_plant(HORIZONTAL, k), 2j * np.pi * np.array([0.1, 0.8, 1.1, 1.3, 3.0])
    H = frequency_response(P.A, P.B, P.C, P.D, s.imag)[:, 0, 0]
    assert np.abs(np.polyval(B, s) / np.polyval(A, s) / H - 1).max() < 3e-4


def test_closing_pitch_hurts_only_a_controller_that_drags_the_pitch_pole_from_its_zero() -> None:
    """The report's claim at 0.5 rad/s: true for poles placed at will, false for its own C_h and for ours."""
    careless = siso.horizontal_by_poles(*siso.AT_WILL).controller()
    shaped = loop_shaped(siso.VERTICAL_SHAPE)
    assert rightmost(siso.from_channels(shaped, None, careless)) < 0
    assert rightmost(siso.from_channels(shaped, siso.pitch_loop(0.5), careless)) > 5
    for bandwidth in (0.1, 0.5, 1.0, 5.0, 50.0):
        pitch = siso.pitch_loop(bandwidth)
        assert rightmost(siso.from_channels(siso.published_cv(), pitch, negated(siso.published_ch()))) < 0
        assert rightmost(siso.from_channels(shaped, pitch, siso.horizontal_by_poles().controller())) < 0


def test_the_pitch_loop_has_the_band_it_is_named_after() -> None:
    """−3 dB points of T_θ on the rotation alone: the product is ω², the difference the bandwidth."""
    k, p, band = model.rigid(), model.Parameters(), 0.5
    C = siso.pitch_loop(band, roll_off=1e7)
    w = np.linspace(5, 10, 200_001)
    s = 1j * w
    P = s * p.s * 2 * p.b / (k.M[2, 2] * s**2 + k.D[2, 2] * s + k.K[2, 2])
    L = -frequency_response(C.A, C.B, C.C, C.D, w)[:, 0, 0] * P
    T = np.abs(L / (1 + L))
    inside = w[T.max() / np.sqrt(2) <= T]
    assert inside[-1] - inside[0] == pytest.approx(band, rel=1e-3)


def test_decoupled_lqg_equals_the_full_one_where_the_channel_is_alone() -> None:
    """Vertical is decoupled by symmetry: nothing is lost there, against the report's figure 25."""
    whole, apart = lqg(PLANT, FIGURE_WEIGHTS).controller, siso.decoupled_lqg(FIGURE_WEIGHTS)
    assert rightmost(apart) < 0
    full, own = peaks(whole), peaks(apart)
    assert own[0] == pytest.approx(full[0], abs=0.01)
    assert full == pytest.approx([31.2, 11.0, 27.2], abs=0.1) and own == pytest.approx([31.2, 12.6, 27.2], abs=0.1)


def test_the_weights_of_one_channel_are_those_of_the_whole() -> None:
    """yᵀW_y y + 0.1 uᵀu, written in z and v: 2 z²/mag² and 0.1 · (2, 2, 1) v²."""
    S = np.diag([1e4, 1e5, 1e4, 1e5])
    back = np.linalg.inv(T_y)
    assert np.allclose(back.T @ S @ S @ back, np.diag([2e8, 2e8, 2e10, 2e10]))
    assert np.allclose(T_u.T @ T_u, np.diag([2, 2, 1]))
    assert np.allclose(T_y @ T_y.T, np.eye(4) / 2)
