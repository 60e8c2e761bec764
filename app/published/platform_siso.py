"""Check source 003, chapter 2 and 5.3.3: channels, SISO pair, decoupled LQG."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..engine import Plant, frequency_response, noisy_loop, sensitivity
from ..engine.design import loop_shaped, negated, polynomial_roots
from ..engine.structure import best_mixing, coupling, dominance, mixing_matrix
from ..plants.platform import model
from ..plants.platform import siso_loops as siso
from ..plants.platform.channels import T_u, T_y, in_channels
from ..plants.platform.lqg_weights import FIGURE_WEIGHTS, LITERAL, Weights, coils, ground, lqg
from .record import Published

SOURCE = "003 platform report"
NOT_PRINTED = "not printed there; recomputed from the printed coefficients"
DRIFT = 1e-7  # rad/s: poles nearer to zero stand on the plant's own zero at s = 0
FREQUENCY = np.unique(np.concatenate([np.geomspace(0.01, 100, 1200), np.linspace(0.9, 1.6, 3000)]))  # Hz
BAND_HZ = np.geomspace(0.1, 10.0, 400)  # Hz, the report's working band
VERTICAL_ASD, HORIZONTAL_ASD = 2.5e-7, 6e-9  # m/√Hz at 1 Hz, falling as 1/f²


@lru_cache(maxsize=1)
def plant() -> Plant:
    """The ten states with coils and ground."""
    return model.plant()


@lru_cache(maxsize=8)
def levels(controller: Plant | None, white: bool = True) -> np.ndarray:
    """Highest density of vertical, rotation and horizontal velocity over ground motion, in (m/s)²/Hz.

    Ground: white of 1e-12 m²/Hz, or the ASD above.
    """
    loop = noisy_loop(coils(plant()), controller, ground(plant()), 1.0)
    shape = (np.full((len(FREQUENCY), 2), 1e-12) if white else
             np.column_stack([VERTICAL_ASD**2 / FREQUENCY**4, HORIZONTAL_ASD**2 / FREQUENCY**4]))
    if not white:
        shape[FREQUENCY < 0.1] = 0.0  # the resonance, not the drift of the ground, is what the figures compare
    return loop.psd(FREQUENCY, loop.outputs(T_y[:3]), ground=shape).max(axis=0)


def with_sensors() -> np.ndarray:
    """Highest density with the published pair and sensors of 1e-9 m/s/√Hz: vertical at 1–2, rotation at 1–10, horizontal at 0.8–1.25 Hz."""
    loop = noisy_loop(coils(plant()), siso.published(), ground(plant()), 1.0, V=0.5e-18)
    shape = np.column_stack([VERTICAL_ASD**2 / FREQUENCY**4, HORIZONTAL_ASD**2 / FREQUENCY**4])
    moved, sensed = loop.parts(FREQUENCY, loop.outputs(T_y[:3]), ground=shape)
    inside = [np.abs(np.log(FREQUENCY / middle)) <= np.log(reach) for middle, reach in (
        (np.sqrt(2.0), np.sqrt(2.0)), (np.sqrt(10.0), np.sqrt(10.0)), (1.0, 1.25))]
    return np.array([(moved + sensed)[part, i].max() for i, part in enumerate(inside)])


def suppression(controller: Plant) -> np.ndarray:
    """How far the highest peak of vertical, rotation, horizontal comes down, in dB."""
    return 10 * np.log10(levels(None) / levels(controller))


def rightmost(controller: Plant) -> float:
    """The rightmost pole of the loop, without those at the plant's zero at s = 0."""
    poles = sensitivity(coils(plant()), controller).poles
    return float(poles.real[np.abs(poles) > DRIFT].max())


def roots(polynomial: tuple[float, ...], upper: bool = False) -> np.ndarray:
    """Roots as real and imaginary parts in turn, or only those above the real axis."""
    found = polynomial_roots(polynomial)
    found = found[found.imag > 0] if upper else found
    return np.column_stack([found.real, found.imag]).ravel() if upper else found.real


def cv_in_band() -> tuple[float, float]:
    """Mean gain of C_v over 0.1–10 Hz with its sign, and the largest phase of −C_v there in degrees."""
    c = siso.published_cv()
    H = frequency_response(c.A, c.B, c.C, c.D, 2 * np.pi * BAND_HZ)[:, 0, 0]
    return float(np.mean(np.real(H))), float(np.degrees(np.abs(np.angle(-H))).max())


def ch_facts() -> tuple[float, float, float]:
    """Relative degree, rightmost zero, rightmost pole of C_h."""
    zeros, poles = polynomial_roots(siso.CH_NUMERATOR), polynomial_roots(siso.CH_DENOMINATOR)
    return float(len(poles) - len(zeros)), float(zeros.real.max()), float(poles.real.max())


def dipoles() -> np.ndarray:
    """Of each lightly damped pole pair of C_h: frequency in Hz, distance of the nearest zero in %."""
    zeros, poles = polynomial_roots(siso.CH_NUMERATOR), polynomial_roots(siso.CH_DENOMINATOR)
    light = sorted((p for p in poles if p.imag > 0 and -p.real < 0.35 * abs(p)), key=abs)
    return np.array([(abs(p) / (2 * np.pi), 100 * np.abs(zeros - p).min() / abs(p)) for p in light]).ravel()


def signs() -> np.ndarray:
    """Rightmost pole with (+C_v, −C_h), (−C_v, −C_h), (+C_v, +C_h), (−C_v, +C_h)."""
    cv, ch = siso.published_cv(), siso.published_ch()
    return np.array([rightmost(siso.from_channels(v, None, h)) for h in (negated(ch), ch) for v in (cv, negated(cv))])


def cross_terms() -> tuple[float, float]:
    """Largest |G₁₃|, |G₃₁| over 0.1–10 Hz relative to |G₁₁|: vertical against horizontal, zero by symmetry."""
    G = dominance(_three(), 2 * np.pi * BAND_HZ).response
    return float(np.abs(G[:, 0, 2] / G[:, 0, 0]).max()), float(np.abs(G[:, 2, 0] / G[:, 0, 0]).max())


def row_ratios() -> np.ndarray:
    """Largest row ratio of rotation and of horizontal over 0.1–10 Hz, each with its frequency in Hz."""
    f = np.unique(np.concatenate([BAND_HZ, np.linspace(0.95, 1.25, 3001)]))
    row = dominance(_three(), 2 * np.pi * f).row
    return np.array([(row[:, i].max(), f[row[:, i].argmax()]) for i in (1, 2)]).ravel()


def _three() -> Plant:
    whole = in_channels(plant())
    return Plant(whole.A, whole.B, whole.C[:3])


def mixing(low: float, high: float, count: int = 100) -> np.ndarray:
    """a, b of the least J over a band in Hz, and 10 log₁₀ of what it gains over no mixing."""
    G = dominance(_three(), 2 * np.pi * np.geomspace(low, high, count)).response
    found = best_mixing(G, channels=(1, 2))
    return np.array([found.a, found.b, 10 * np.log10(found.plain_J / found.J)])


def grid_dependence() -> tuple[float, float, float]:
    """Gain in dB of the optimum over 0.1–10 Hz of 100 points on those points and on 400; of the optimum of 400
    points."""
    rough, fine = (dominance(_three(), 2 * np.pi * np.geomspace(0.1, 10, n)).response for n in (100, 400))
    one, best, J = best_mixing(rough, channels=(1, 2)), best_mixing(fine, channels=(1, 2)), coupling(fine,
                                                                                                     channels=(1, 2))
    gains = one.plain_J / one.J, J(0, 0) / J(one.a, one.b), best.plain_J / best.J
    return float(10 * np.log10(gains[0])), float(10 * np.log10(gains[1])), float(10 * np.log10(gains[2]))


def mixing_and_the_ground() -> tuple[float, float]:
    """Suppression of rotation in dB by the published pair, without mixing and with that of least J over 2–10 Hz."""
    a, b, _ = mixing(2, 10)
    mixed = siso.from_channels(siso.published_cv(), None, negated(siso.published_ch()),
                               mixing=mixing_matrix(a, b, size=3, channels=(1, 2)))
    return float(suppression(siso.published())[1]), float(suppression(mixed)[1])


def residual_output() -> float:
    """Largest entry of z₄ = (y₂ + y₄)/2."""
    return float(np.abs(T_y[3] @ plant().C).max())


def pitch_closed() -> np.ndarray:
    """Rightmost pole with the pitch loop at 0.5 rad/s: the published pair, ours, and eight poles placed at will."""
    shaped, pitch = loop_shaped(siso.VERTICAL_SHAPE), siso.pitch_loop(0.5)
    return np.array([
        rightmost(siso.from_channels(siso.published_cv(), pitch, negated(siso.published_ch()))),
        rightmost(siso.from_channels(shaped, pitch, siso.horizontal_by_poles().controller())),
        rightmost(siso.from_channels(shaped, pitch, siso.horizontal_by_poles(*siso.AT_WILL).controller())),
    ])


def lqg_beside_decoupled(weights: Weights) -> np.ndarray:
    """Suppression in dB of vertical, rotation, horizontal: the full LQG, then the decoupled one."""
    return np.concatenate([suppression(lqg(plant(), weights).controller), suppression(siso.decoupled_lqg(weights))])


def at_a_tenth_hertz(weights: Weights) -> np.ndarray:
    """Change of the rotation's density at 0.1 Hz in dB: full LQG, decoupled LQG; positive is amplified."""
    f = np.array([0.1])
    S = []
    for controller in (None, lqg(plant(), weights).controller, siso.decoupled_lqg(weights)):
        loop = noisy_loop(coils(plant()), controller, ground(plant()), 1e-12)
        S.append(loop.psd(f, loop.outputs(T_y[1:2]))[0, 0])
    return 10 * np.log10(np.array(S[1:]) / S[0])


RECORDS = (
    Published(SOURCE, "T_u⁻¹, rows: (u1 + u2)/2, (u1 − u2)/2, u3, eqs (12)–(14)", "0.5, 0.5, 0, 0.5, -0.5, 0, 0, 0, 1",
              lambda: np.linalg.inv(T_u), tolerance=1e-12),
    Published(SOURCE, "z₄ of eq. (8)", "0", residual_output, tolerance=1e-12),
    Published(SOURCE, "|G13|, |G31| over |G11|, 0.1–10 Hz", "much smaller", cross_terms, right="0, 0", tolerance=1e-9,
              note="exactly zero by left-right symmetry"),
    Published(SOURCE, "largest row ratio of rotation at Hz, of horizontal at Hz",
              "clearly diagonal dominant in 0.1–10 Hz", row_ratios, "slip", "3.11, 1.002, 16.2, 1.181",
              note="rotation and horizontal share two resonances: near them neither row is dominant"),
    Published(SOURCE, "least J of eq. (21) over 2–10 Hz: a, b, gain in dB", "", lambda: mixing(2, 10), "beyond",
              "0.1682, 0.0407, 18.8", note="above the resonances mixing decouples"),
    Published(SOURCE, "least J of eq. (21) over 0.1–0.8 Hz: gain in dB", "", lambda: mixing(0.1, 0.8)[2], "beyond",
              "1.96"),
    Published(SOURCE, "J over 0.1–10 Hz, gain in dB: optimum of 100 points there and on 400, optimum of 400",
              "no help for the design", grid_dependence, "beyond", "7.3, 0.93, 1.23",
              note="the sum hangs on the few samples that fall on a resonance"),
    Published(SOURCE, "suppression of rotation in dB, without and with the mixing of 2–10 Hz", "no help for the design",
              mixing_and_the_ground, "beyond", "88.0, 9.3",
              note="the mixed coils no longer push back where the ground pulls"),
    Published(SOURCE, "C_v (26): zeros, real and imaginary part", "", lambda: roots(siso.CV_NUMERATOR, True), "beyond",
              "-5.78e-9, 1.428e-5", note=NOT_PRINTED),
    Published(SOURCE, "C_v (26): poles", "", lambda: roots(siso.CV_DENOMINATOR), "beyond",
              "-1.366e5, -9.8755e-4, 7.94e-11",
              note=NOT_PRINTED + "; the last is an integrator that rounding has made unstable"),
    Published(SOURCE, "C_v in 0.1–10 Hz: gain, largest phase of −C_v in °", "gain with a lead for phase", cv_in_band,
              "slip", "-31252, 0.09", tolerance=0.9,
              note="a pure constant: the lead that the text describes is not there"),
    Published(SOURCE, "C_h (31), (32): relative degree, rightmost zero, rightmost pole", "", ch_facts, "beyond",
              "1, -8.444e-7, -2.058e-9", note=NOT_PRINTED + ": strictly proper, stable, minimum phase"),
    Published(SOURCE, "C_h: light pole pairs, Hz and % to the nearest zero", "damping of the main resonances", dipoles,
              "beyond", "0.00999, 0.1, 0.244, 0.4, 2.526, 0.7",
              note="three pairs all but cancelled inside C_h; none stands at a resonance of this plant"),
    Published(SOURCE, "rightmost pole for (C_v, C_h) as +−, −−, ++, −+", "unit negative feedback, C_h alone said",
              signs, "beyond", "-9.73e-4, 5.02e3, 1.712e4, 1.712e4",
              note="only v = +C_v z with v = −C_h z holds the loop"),
    Published(SOURCE, "peak suppression of the SISO pair, vertical, dB", "90–100 dB by (35), (36)",
              lambda: suppression(siso.published())[0], right="93.5"),
    Published(SOURCE, "peak suppression of the SISO pair, rotation and horizontal, dB",
              "20–30 dB by (37), (38) and 40 dB by (33), (34)", lambda: suppression(siso.published())[1:], "beyond",
              "88.0, 105.0", note="before sensor noise, which sets the printed floors"),
    Published(SOURCE, "open-loop peak, vertical, by (35); horizontal, by (33)", "1e-8 and 1e-11",
              lambda: levels(None, False)[[0, 2]], "beyond", "8.2e-9, 9.5e-12",
              note="ground 2.5e-7/f² vertically, 6e-9/f² horizontally, in m/√Hz"),
    Published(SOURCE, "open-loop peak, rotation, by (37)", "about 1e-11", lambda: levels(None, False)[1], "slip",
              "4.4e-14",
              note="not reached together with the horizontal level: here both come from one horizontal ground motion"),
    Published(SOURCE, "closed-loop peak with sensor noise, vertical, by (36)", "1e-17 to 1e-18", lambda: with_sensors()[0], "beyond",
              "1.9e-17", note="the same ground, sensors of 1e-9 m/s/√Hz"),
    Published(SOURCE, "closed-loop peak with sensor noise, horizontal, by (34); rotation, by (38)", "1e-15; 1e-13 to 1e-14",
              lambda: with_sensors()[[2, 1]], "beyond", "5.0e-19, 4.3e-18",
              note="here the noise of the sensors, far below what is printed; the report does not say what holds its levels up"),
    Published(SOURCE, "pitch closed at 0.5 rad/s, rightmost pole: published, ours, poles at will",
              "horizontal near instability above 0.5 rad/s", pitch_closed, "beyond", "-9.73e-4, -0.018, 6.1",
              note="true only for a C_h that drags the pitch poles away from the zeros of P_h"),
    Published(SOURCE, "V = 1e-9, suppression in dB: full LQG, decoupled LQG (vertical, rotation, horizontal)",
              "decoupled worst in vertical", lambda: lqg_beside_decoupled(FIGURE_WEIGHTS), "slip",
              "31.2, 11.0, 27.2, 31.2, 12.6, 27.2",
              note="the vertical channel is alone by symmetry: decoupling costs nothing there"),
    Published(SOURCE, "V = 1e-18, suppression in dB of vertical: full LQG, decoupled LQG", "",
              lambda: lqg_beside_decoupled(LITERAL)[[0, 3]], "beyond", "110.6, 110.6"),
    Published(SOURCE, "V = 1e-9, rotation at 0.1 Hz in dB: full LQG, decoupled LQG", "full LQG 5–10 dB better",
              lambda: at_a_tenth_hertz(FIGURE_WEIGHTS), "beyond", "31.2, 0.0", tolerance=0.05,
              note="below resonance the full LQG makes the deck pitch; the decoupled one does not"),
)
