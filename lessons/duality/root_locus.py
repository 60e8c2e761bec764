"""Draw the symmetric root loci of lesson 5: the poles of LQR and LQE over the ratio of the weights."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.optimize import linear_sum_assignment

from observer_lab.course.figures.records import Curve, PlaneFigure, Point
from observer_lab.course.lesson import Design
from observer_lab.engine import Plant
from observer_lab.text import Text, text

from .dual_quantities import Setting

LOCUS_TAB = text("Root locus")
LOW, HIGH = 1e-6, 1e6  # the ratios of the weights
SAMPLES, FEWEST = 1200, 97  # samples of the locus times states, so that its corners are sharp; and at least


def ratios(n: int) -> np.ndarray:
    """The ratios at which the locus of n states is drawn."""
    return np.geomspace(LOW, HIGH, max(FEWEST, SAMPLES // n))


def locus(A: np.ndarray, B: np.ndarray, Q: np.ndarray, R: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The 2n roots of det(R/ρ + Bᵀ(−sI − Aᵀ)⁻¹ Q (sI − A)⁻¹B) = 0 for each ratio ρ in `at` (k,).

    The result is (k, 2n), each branch in a column.

    They are the eigenvalues of the Hamiltonian matrix [A, −ρ B R⁻¹Bᵀ; −Q, −Aᵀ]. With each root s, −s is one; those on the left are the
    poles that LQR chooses for ρQ and R. Source: Kailath, Linear Systems (1980), section 3.4: the symmetric root locus.
    """
    push = B @ np.linalg.solve(R, B.T)
    roots = np.array([np.linalg.eigvals(np.block([[A, -ratio * push], [-Q, -A.T]])) for ratio in at], dtype=complex)
    for before, after in pairwise(roots):
        after[:] = after[linear_sum_assignment(np.abs(before[:, None] - after))[1]]
    return roots


@lru_cache(maxsize=16)
def _branches(here: Setting, plant: Plant, filtering: bool) -> np.ndarray:
    given = (plant.A.T, plant.C.T, here.W, here.V) if filtering else (plant.A, plant.B, here.Q, here.R)
    return locus(*given, ratios(plant.n))


def locus_figures(here: Setting, design: Design) -> tuple[PlaneFigure, PlaneFigure]:
    """The locus of the regulator over α_Q/α_R and that of the filter over α_W/α_V."""
    q, r = design["q"], design["r"]
    w, v = (q, r) if design["mirror"] else (design["w"], design["v"])
    return (_figure(here, design, False, q / r, text("symmetric root locus of the LQR"),
                    text("α_Q/α_R from 10⁻⁶ to 10⁶. Crosses: LQR poles at the present ratio {ratio:.3g}. Circles: their mirror images.",
                         ratio=q / r)),
            _figure(here, design, True, w / v, text("symmetric root locus of the LQE"),
                    text("α_W/α_V from 10⁻⁶ to 10⁶. Crosses: LQE poles at the present ratio {ratio:.3g}. Circles: their mirror images.",
                         ratio=w / v)))


def _figure(here: Setting, design: Design, filtering: bool, ratio: float, title: Text, caption: Text) -> PlaneFigure:
    plant, role = here.plant(design), "estimate" if filtering else "plant"
    given = (plant.A.T, plant.C.T, here.W, here.V) if filtering else (plant.A, plant.B, here.Q, here.R)
    wide, high = -here.window.re_low, here.window.im_high
    curves = []
    for branch in _branches(here, plant, filtering).T:
        seen = branch[(np.abs(branch.real) <= wide) & (np.abs(branch.imag) <= high)]
        if len(seen) > 1:
            stable = float(np.median(seen.real)) < 0
            curves.append(Curve(text("chosen") if stable else text("mirror image"), seen.imag, role if stable else "muted",
                                "solid" if stable else "dash", 2.0, seen.real))
    now = locus(*given, np.array([ratio]))[0]
    points = [Point(float(s.real), float(s.imag), role if s.real < 0 else "muted", "cross" if s.real < 0 else "circle") for s in now
              if abs(s.real) <= wide and abs(s.imag) <= high]
    return PlaneFigure("filter-locus" if filtering else "regulator-locus", title, tuple(curves), tuple(points), "Re s", "Im s",
                       (-wide, wide), (-high, high), tab=LOCUS_TAB, caption=caption)
