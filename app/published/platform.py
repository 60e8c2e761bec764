"""Check source 003, platform: Hankel values and the plant reconstructed from them."""

from __future__ import annotations

from functools import lru_cache
from math import pi, sqrt

import numpy as np

from ..engine import (
    Plant,
    balanced_truncation,
    controllability,
    frequency_response,
    hankel_singular_values,
    lqe,
    noisy_loop,
    observability,
)
from ..engine.systems import amplitude_response
from ..plants.platform import model
from ..plants.platform.lqg_weights import Weights, coils, ground, lqg
from .record import Published

SOURCE = "003 platform report"
RECONSTRUCTED = "the plant is reconstructed from this list"
PLATFORM_PARAMETERS = model.Parameters()


@lru_cache(maxsize=1)
def plant() -> Plant:
    """The ten states with all five inputs."""
    return model.plant()


@lru_cache(maxsize=1)
def hankel() -> np.ndarray:
    """Its ten Hankel singular values."""
    return hankel_singular_values(plant())


def modes() -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in Hz, ascending, and damping ratios of the five modes."""
    upper = sorted((p for p in plant().poles if p.imag > 0), key=abs)
    return np.abs(upper) / (2 * pi), np.array([-p.real / abs(p) for p in upper])


def truncation_error() -> tuple[float, float]:
    """Largest gain of the difference to the 8-state plant over frequency, and where it lies in Hz."""
    full, cut = plant(), balanced_truncation(plant(), 8).plant
    f = np.unique(np.concatenate([np.geomspace(0.01, 1000, 400), np.linspace(29.8, 30.8, 2001)]))
    gap = frequency_response(full.A, full.B, full.C, full.D, 2 * pi * f) - frequency_response(
        cut.A, cut.B, cut.C, cut.D, 2 * pi * f)
    size = np.linalg.norm(gap, 2, axis=(1, 2))
    return float(size.max()), float(f[size.argmax()])


def gaps() -> tuple[float, float]:
    """σ6/σ7 and the order after which the largest gap of the list lies."""
    ratios = hankel()[:-1] / hankel()[1:]
    return float(ratios[5]), float(ratios.argmax() + 1)


def single_mode(zeta: float, omega: float, velocity: bool) -> Plant:
    """s or 1 over s² + 2ζω s + ω²."""
    return Plant(np.array([[0, 1], [-(omega**2), -2 * zeta * omega]]), np.array([[0], [1]]),
                 np.array([[0, 1] if velocity else [1, 0]]))


def closed_form(velocity: bool) -> float:
    """Largest relative distance of a mode's Hankel values from their closed form, over 12 modes."""
    worst = 0.0
    for zeta in (0.003, 0.05, 0.4, 0.9):
        for omega in (0.2, 6.0, 190.0):
            form = (np.full(2, 1 / (4 * zeta * omega)) if velocity else
                    (sqrt(1 + zeta**2) + np.array([zeta, -zeta])) / (4 * zeta * omega**2))
            got = hankel_singular_values(single_mode(zeta, omega, velocity))
            worst = max(worst, float(np.abs(got / form - 1).max()))
    return worst


def geometry() -> tuple[float, float, float]:
    """σ1, σ7, σ9 divided by what the geometry says of them."""
    f, zeta = modes()
    vertical, opposed, together = 2, 3, 4  # by ascending frequency
    w, sigma = 2 * pi * f, hankel()
    forms = (
        sqrt(2) * w[vertical] / (4 * zeta[vertical]),
        sqrt(2) * w[vertical] ** 2 * (2 * PLATFORM_PARAMETERS.mu / PLATFORM_PARAMETERS.m) / (4 * zeta[together] * w[together]),
        sqrt(2)
        * PLATFORM_PARAMETERS.kx
        * PLATFORM_PARAMETERS.h
        * (2 * PLATFORM_PARAMETERS.mu * PLATFORM_PARAMETERS.s**2 / PLATFORM_PARAMETERS.J**2)
        * sqrt(PLATFORM_PARAMETERS.s**2 + PLATFORM_PARAMETERS.h**2)
        / (4 * zeta[opposed] * w[opposed]),
    )
    return float(sigma[0] / forms[0]), float(sigma[6] / forms[1]), float(sigma[8] / forms[2])


def face_of_the_weak_pair() -> float:
    """p_L + p_R over p_L − p_R in the mode at 30.21 Hz, where the report cuts: 0 if they move against each other."""
    values, vectors = np.linalg.eig(plant().A)
    mode = vectors[:, int(np.argmin(np.abs(values - sorted((v for v in values if v.imag > 0), key=abs)[3])))]
    return float(abs(mode[3] + mode[4]) / abs(mode[3] - mode[4]))


def ranks(tolerance: float) -> tuple[int, int]:
    """Singular values above an absolute tolerance, of the controllability and of the observability matrix."""
    values = controllability(plant()).singular_values, observability(plant()).singular_values
    return int((values[0] > tolerance).sum()), int((values[1] > tolerance).sum())


def rank_by_the_millisecond() -> tuple[int, int]:
    """Rank of the controllability matrix above 1e-12 and above 1e-6, time counted in milliseconds."""
    values = controllability(model.in_time_units(plant(), 1e-3)).singular_values
    return int((values > 1e-12).sum()), int((values > 1e-6).sum())


def usual_ranks() -> tuple[int, int]:
    """Rank of both matrices at the usual relative tolerance, the larger side times 2.2e-16."""
    return controllability(plant()).matrix_rank(), observability(plant()).matrix_rank()


@lru_cache(maxsize=4)
def designed_on(order: int) -> tuple[float, float, np.ndarray]:
    """The report's LQG on a truncation: ‖K‖, cost on the ten states, densities of the outputs there near the modes."""
    weights, full = Weights(), plant()
    small = balanced_truncation(full, order).plant
    design = lqg(small, weights)
    loop = noisy_loop(coils(full), design.controller, ground(full), weights.W, V=weights.V)
    f = np.concatenate([np.geomspace(0.01, 300, 300), modes()[0]])
    return float(np.linalg.norm(design.K)), sum(loop.cost(weights.Q(full), weights.R)), loop.psd(f)


def eight_against_ten() -> tuple[float, float, float]:
    """Relative: growth of ‖K‖ from 8 to 10 states, extra cost of the design on 8, largest difference of the spectra."""
    ten, eight = designed_on(10), designed_on(8)
    return ten[0] / eight[0] - 1, eight[1] / ten[1] - 1, float(np.abs(eight[2] / ten[2] - 1).max())


def price_of_fewer() -> tuple[float, float]:
    """Extra cost in % on ten states of the design on six and on four."""
    best = designed_on(10)[1]
    return 100 * (designed_on(6)[1] / best - 1), 100 * (designed_on(4)[1] / best - 1)


def right_sensor() -> tuple[float, float]:
    """Rank of C, and the largest entry of HL + HR: outputs VL, HL, VR, HR with the right one turned round."""
    C, names = plant().C, plant().output_names
    return (float(np.linalg.matrix_rank(C)),
            float(np.abs(C[names.index("HL")] + C[names.index("HR")]).max()))


def tiny_noise() -> tuple[float, float]:
    """lqe at W = 1e-12, V = 1e-18: the Riccati residual, and L against the same ratio in units 1e12 times larger."""
    A, B, C = plant().A, plant().B[:, 3:], plant().C
    small, large = (lqe(A, B, C, w * np.eye(2), v * np.eye(4)) for w, v in ((1e-12, 1e-18), (1.0, 1e-6)))
    return small.residual, float(np.abs(small.gain - large.gain).max() / np.abs(large.gain).max())


def peak_channel() -> float:
    """Frequency in Hz of the highest peak of the vertical common channel over ground motion."""
    f = np.linspace(0.5, 3.0, 5001)
    G = frequency_response(plant().A, plant().B[:, 3:4], plant().C, np.zeros((4, 1)), 2 * pi * f)
    return float(f[np.abs(G[:, 0, 0] + G[:, 2, 0]).argmax()])


def rotation_peaks() -> np.ndarray:
    """Frequencies in Hz of the peaks of the rotation channel (VR − VL) over horizontal ground motion."""
    f = np.linspace(0.5, 3.0, 5001)
    both = Plant(plant().A, plant().B[:, 4:5], plant().C[[2]] - plant().C[[0]])
    size = amplitude_response(both.A, both.B, both.C, both.D, 2 * pi * f)[:, 0, 0]
    top = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])) + 1
    return f[top]


RECORDS = (
    Published(SOURCE, "Hankel values σ1 … σ6", "572.7565, 572.7565, 360.3040, 360.2852, 43.0552, 43.0305",
              lambda: hankel()[:6], relative=5e-5, note=RECONSTRUCTED),
    Published(SOURCE, "Hankel values σ7 … σ10", "0.0539, 0.0539, 0.0001, 0.0001", lambda: hankel()[6:]),
    Published(SOURCE, "σ1 … σ6 of the reconstruction", "", lambda: hankel()[:6], "beyond",
              "572.7760, 572.7760, 360.3035, 360.2847, 43.0561, 43.0313"),
    Published(SOURCE, "σ7 … σ10 of the reconstruction", "", lambda: hankel()[6:], "beyond",
              "0.053902, 0.053898, 8.85e-5, 8.85e-5"),
    Published(SOURCE, "error bound of order 8", "", lambda: balanced_truncation(plant(), 8).error_bound, "beyond",
              "3.541e-4", note="from the printed list, whose last values have one digit, it is 4e-4"),
    Published(SOURCE, "H∞ error of order 8, at Hz", "", truncation_error, "beyond", "1.771e-4, 30.2"),
    Published(SOURCE, "σ6/σ7, order at the largest gap", "", gaps, "beyond", "798.3, 6",
              note="the report cuts after 8"),
    Published(SOURCE, "frequencies of the modes in Hz", "", lambda: modes()[0], "beyond",
              "0.995, 1.192, 1.494, 30.21, 30.32"),
    Published(SOURCE, "damping of the modes in %", "", lambda: 100 * modes()[1], "beyond",
              "0.59, 0.47, 0.58, 2.53, 2.54"),
    Published(SOURCE, "vertical resonance in Hz", "near 1–2 Hz", peak_channel, right="1.494"),
    Published(SOURCE, "adjacent peaks of the rotation channel in Hz", "two adjacent modes", rotation_peaks, "beyond",
              "0.995, 1.19"),
    Published(SOURCE, "p_L + p_R in the mode cut away", "no physical reading", face_of_the_weak_pair, "beyond", "0",
              tolerance=1e-6, note="the test masses move against each other"),
    Published(SOURCE, "velocity output: σ1 = σ2 = 1/(4ζω), error", "", lambda: closed_form(True), "beyond", "0",
              tolerance=1e-9),
    Published(SOURCE, "position output: σ = (√(1+ζ²) ± ζ)/(4ζω²), error", "", lambda: closed_form(False), "beyond", "0",
              tolerance=1e-9),
    Published(SOURCE, "σ1, σ7, σ9 over their geometry", "", geometry, "beyond", "1, 1, 1", tolerance=0.02,
              note="to first order in small ζ and μ/m"),
    Published(SOURCE, "rank of controllability, observability at 1e-12", "", lambda: ranks(1e-12), "beyond", "10, 10"),
    Published(SOURCE, "rank of controllability, observability at 1e-6", "6 to 10 for tolerances 1e-12 to 1e-6",
              lambda: ranks(1e-6), "beyond", "10, 10",
              note="in seconds no tolerance of that range takes rank away; see the next line"),
    Published(SOURCE, "rank of controllability at 1e-12, 1e-6, time in ms", "6 to 10 for tolerances 1e-12 to 1e-6",
              rank_by_the_millisecond, right="10, 6", note="a rank has a unit: by the millisecond the range comes out"),
    Published(SOURCE, "rank of both matrices at the usual tolerance", "", usual_ranks, "beyond", "4, 6",
              note="relative to the largest singular value, time in seconds"),
    Published(SOURCE, "LQG on 8 against 10: growth of K, cost, spectra", "weak states ask for large gains",
              eight_against_ten, "beyond", "0, 0, 0", tolerance=5e-5,
              note="with Q = CᵀW_yC the worry of section 3.3 does not arise"),
    Published(SOURCE, "LQG on 6 and on 4: extra cost in %", "", price_of_fewer, "beyond", "0.000, 17.2",
              note="V = 1e-9; the widest gap of the list lies after 6"),
    Published(SOURCE, "rank of C, HL + HR", "outputs VL VR HL HR", right_sensor, "slip", "3, 0",
              note="section 1.2 alone has this order; everything else uses VL HL VR HR, with HR = −HL"),
    Published(SOURCE, "lqe at W = 1e-12, V = 1e-18: residual, L against W/V", "", tiny_noise, "beyond", "0, 0",
              tolerance=1e-7, note="both backends of python-control fail here; L depends on W/V alone"),
)
