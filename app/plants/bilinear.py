"""Model the six-state bilinear plant: four measured states, one functional wanted."""

from __future__ import annotations

import numpy as np

from ..engine import BilinearPlant, EngineError
from ..engine.observers import BilinearForm

__all__ = ["BILINEAR_PLANT", "POLE", "PRINTED_FORM", "PRINTED_L", "WANTED_ROW", "X0", "fitting_functional", "with_sensors"]

BILINEAR_PLANT = BilinearPlant(
    A=np.array([[-12, 4, -11, 4, -7, -3], [15, -6, -19, 6, -10, -1], [1, 0, -2, 0, 1, -3],
                [35, -22, 47, -17, 25, 11], [17, -10, 23, -8, -10, 7], [-2, 1, 0, 3, 4, -6]]),
    B=np.array([[1], [3], [1], [2], [5], [4]]),
    F=np.array([[-3, 0, 0, 1, -2, 0], [2, -1, 3, 0, 0, 1], [0, 0, -1, 0, 1, 2],
                [-2, -1, 1, -2, 0, 1], [2, -1, 0, 1, 0, -1], [0, 1, 0, 0, 1, -1]]),
    C=np.eye(6)[:4],
)
"""Worked example of "Synthesis of functional observers for bilinear plants", Avtometriya 53 (2017) no. 4."""

WANTED_ROW = np.array([[1.0, 2, 3, 4, 5, 6]])
POLE = -30.0
X0 = (1.0,) * 6

PRINTED_L = np.array([[-12.49, 17.68, -18.99, 2.29]])
"""Step 7 as the paper prints it; the last entry is a slip."""

PRINTED_FORM = BilinearForm(
    A=np.array([[-30.0]]), Y=np.array([[-273.64, -213.93, 408.38, -198.94]]), B=np.array([[8.85]]),
    U=np.array([[-44.26, 27.98, -81.33, 36.08]]), R=np.zeros((1, 4)), G_y=np.array([[-11.49, 19.68, -15.99, 13.29]]),
    G_z=np.array([[1.0]]))
"""Step 8 as the paper prints it, with two decimals."""

WANTED_ROW.setflags(write=False)
PRINTED_L.setflags(write=False)


def with_sensors(measured: tuple[int, ...]) -> BilinearPlant:
    """The same plant with other states measured, counted from 0."""
    return BilinearPlant(BILINEAR_PLANT.A, BILINEAR_PLANT.B, BILINEAR_PLANT.F, np.eye(BILINEAR_PLANT.n)[list(measured)])


def fitting_functional(plant: BilinearPlant, pole: float) -> tuple[np.ndarray, float]:
    """A row P (1×n) that an observer of order one can watch with n/2 sensors, and its pole: the real one nearest `pole`.

    P F Z = 0 and P A Z = a P Z with Z the states left unmeasured: conditions (15), (16) of the source for P = V₂ − L V₁,
    solved for P instead of L. Raises EngineError where there is no such row with a real pole.
    """
    unseen = np.flatnonzero(~plant.C.any(axis=0))
    null = np.linalg.svd(plant.F[:, unseen].T)[2][len(unseen):].T
    if null.shape[1] != len(unseen):
        raise EngineError("An observer of order one needs half of the states measured, each by a sensor of its "
                          "own; change C.")
    values, vectors = np.linalg.eig(np.linalg.solve(null[unseen], plant.A[:, unseen].T @ null))
    real = np.flatnonzero(np.abs(np.imag(values)) < 1e-9 * np.abs(values))
    if not real.size:
        raise EngineError("No functional of this plant can be watched by an observer with a real pole; take "
                          "another plant.")
    best = int(real[np.argmin(np.abs(np.real(values[real]) - pole))])
    return (null @ np.real(vectors[:, best]))[None, :], float(np.real(values[best]))
