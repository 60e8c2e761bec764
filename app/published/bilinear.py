"""Check source 004, functional observer of a bilinear plant: example, slips, run."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..engine import bilinear_functional_observer, simulate_bilinear
from ..engine.observers import BilinearForm, BilinearObserver, BilinearRun
from ..plants.bilinear import BILINEAR_PLANT, POLE, PRINTED_FORM, PRINTED_L, WANTED_ROW, X0
from .record import Published

SOURCE = "004 bilinear functional observer"


@lru_cache(maxsize=1)
def observer() -> BilinearObserver:
    """The eight steps for the pole −30."""
    return bilinear_functional_observer(BILINEAR_PLANT.A, BILINEAR_PLANT.B, BILINEAR_PLANT.F, BILINEAR_PLANT.C, WANTED_ROW, POLE)


def plain() -> BilinearForm:
    """The form without ẏ, (18) and (19)."""
    form = observer().without_derivative
    assert form is not None
    return form


def gain() -> np.ndarray:
    """L (1×4)."""
    L = observer().L
    assert L is not None
    return L


def pole_as_printed() -> float:
    """The observer's pole (V₂ − L V₁) A T₂ with the last entry of L as printed."""
    L = gain().copy()
    L[0, 3] = PRINTED_L[0, 3]
    return observer().forms(L)[1].A.item()


def run(form: BilinearForm, horizon: float = 6.0) -> BilinearRun:
    """u = sin 2t, x(0) all ones, χ(0) = 0, as in the paper's figure."""
    return simulate_bilinear(BILINEAR_PLANT, form, WANTED_ROW, lambda t: np.sin(2 * t), X0, [0.0], horizon=horizon)


def start() -> tuple[float, float]:
    """g(0) and ε(0)."""
    ours = run(plain(), 0.01)
    return float(ours.g[0, 0]), float(ours.error[0, 0])


def law_gap() -> float:
    """Largest deviation of ε(t) from ε(0) e^{−30t} within 6 s, relative to ε(0)."""
    ours = run(plain())
    law = ours.error[0, 0] * np.exp(POLE * ours.t)
    return float(np.max(np.abs(ours.error[:, 0] - law)) / abs(ours.error[0, 0]))


def floor() -> float:
    """Where |ε| stops falling with the printed decimals: its largest value from 2 s to 6 s."""
    rounded = run(PRINTED_FORM)
    return float(np.max(np.abs(rounded.error[rounded.t >= 2, 0])))


def upper_poles() -> np.ndarray:
    """Re, Im of the three eigenvalues of A in the upper half plane, by real part."""
    poles = np.sort_complex(np.linalg.eigvals(BILINEAR_PLANT.A))
    upper = poles[poles.imag > 0]
    return np.column_stack([upper.real, upper.imag])


RECORDS = (
    Published(SOURCE, "step 1: V₂", "0, 0, 0, 0, 5, 6", lambda: observer().V[1]),
    Published(SOURCE, "step 1: T₂ and T₃, transposed", "0, 0, 0, 0, 0.2, 0, 0, 0, 0, 0, -1.2, 1",
              lambda: np.vstack([observer().T[1].T, observer().T[2].T]), tolerance=1e-9),
    Published(SOURCE, "step 2: Q", "-0.40, 5.40, 2.40; 0, 11.00, 1.00; 0.20, -4.20, 0.80; 0, -19.00, 1.00",
              lambda: observer().Q, tolerance=1e-9),
    Published(SOURCE, "step 2: Q̃ᴸ", "-2.50, 0, 0, 0; 0, 0.09, 0, 0; 0.23, 0.06, 0.47, 0",
              lambda: observer().canonical_Q.unit_left),
    Published(SOURCE, "step 2: Q̄ᴸ", "-0.64, 1.55, -1.28, 1.00", lambda: observer().canonical_Q.zero_left),
    Published(SOURCE, "step 2: Q̃ᴿ", "1.00, 13.50, 4.77; 0, 1.00, -0.09; 0, 0, 1.00",
              lambda: observer().canonical_Q.unit_right),
    Published(SOURCE, "step 2: Q̃", "-1.38, 1.53, 2.23, 0; -0.02, 0.09, -0.04, 0; 0.23, 0.06, 0.47, 0",
              lambda: observer().canonical_Q.summary),
    Published(SOURCE, "steps 3 and 4: columns of Q̄ᴿ, rows of Q̄ᴸ", "Q has no right divisor of zero and a left one",
              lambda: [observer().canonical_Q.zero_right.shape[1], len(observer().canonical_Q.zero_left)],
              right="0, 1"),
    Published(SOURCE, "step 5: A*, B*", "-6.47, 2.53", lambda: [observer().A_star.item(), observer().B_star.item()]),
    Published(SOURCE, "step 6: π", "9.29", lambda: observer().pi),
    Published(SOURCE, "step 7: L", "-12.49, 17.68, -18.99, 2.29", gain, "slip", "-12.49, 17.68, -18.99, 9.29",
              note="the last entry must be π = 9.29; step 8 follows from 9.29"),
    Published(SOURCE, "pole of the observer with L₄ = 2.29", "", pole_as_printed, "beyond", "5.02",
              note="the observer printed in step 7 runs away"),
    Published(SOURCE, "step 8: of y, first coefficient", "-273.64", lambda: plain().Y[0, 0], "slip", "-273.6471",
              note="the last digit was cut off, not rounded: −273.65"),
    Published(SOURCE, "step 8: of y, the others", "-213.93, 408.38, -198.94", lambda: plain().Y[0, 1:]),
    Published(SOURCE, "step 8: of u", "8.85", lambda: plain().B),
    Published(SOURCE, "step 8: of u y", "-44.26, 27.98, -81.33, 36.08", lambda: plain().U),
    Published(SOURCE, "step 8: ĝ, of y", "-11.49, 19.68, -15.99, 13.29", lambda: plain().G_y),
    Published(SOURCE, "step 8: pole, coefficient of χ in ĝ", "-30, 1", lambda: [plain().A.item(), plain().G_z.item()]),
    Published(SOURCE, "u = sin 2t, x(0) = 1, χ(0) = 0: g(0), ε(0)", "", start, "beyond", "21, -15.5058824"),
    Published(SOURCE, "the same run: ε(t) against ε(0) e^(−30 t), relative", "with the given speed", law_gap, "agrees",
              "0", tolerance=1e-9),
    Published(SOURCE, "the same run with the printed decimals: floor of |ε|", "", floor, "beyond", "5.2e-3",
              note="rounded coefficients no longer cancel"),
    Published(SOURCE, "eig A: Re, Im of the upper half", "", upper_poles, "beyond",
              "-18.8987, 9.2476; -4.9342, 3.7176; -2.6671, 7.6014", note="the plant is stable at u = 0"),
)
