"""The six-state bilinear plant: four states measured, one functional of all six wanted."""

from __future__ import annotations

import numpy as np

from ..engine.bilinear import BilinearPlant

__all__ = ["PLANT", "POLE", "X0", "K"]

PLANT = BilinearPlant(
    A=np.array([[-12, 4, -11, 4, -7, -3], [15, -6, -19, 6, -10, -1], [1, 0, -2, 0, 1, -3],
                [35, -22, 47, -17, 25, 11], [17, -10, 23, -8, -10, 7], [-2, 1, 0, 3, 4, -6]]),
    B=np.array([[1], [3], [1], [2], [5], [4]]),
    F=np.array([[-3, 0, 0, 1, -2, 0], [2, -1, 3, 0, 0, 1], [0, 0, -1, 0, 1, 2],
                [-2, -1, 1, -2, 0, 1], [2, -1, 0, 1, 0, -1], [0, 1, 0, 0, 1, -1]]),
    C=np.eye(6)[:4],
)
"""Worked example of "Synthesis of functional observers for bilinear plants", Avtometriya 53 (2017) no. 4."""

K = np.array([[1.0, 2, 3, 4, 5, 6]])
POLE = -30.0
X0 = (1.0,) * 6

K.setflags(write=False)
