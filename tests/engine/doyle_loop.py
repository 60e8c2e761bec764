"""Doyle's loop of 1978."""

import numpy as np

from observer_lab.engine import Plant, compensator, lqe, lqr

ONES = np.ones((2, 2))
DOYLE = Plant([[1, 1], [0, 1]], [[0], [1]], [[1, 0]])


def doyle(q, sigma):
    K = lqr(DOYLE.A, DOYLE.B, q * ONES, 1).gain
    return compensator(DOYLE, K, lqe(DOYLE.A, [[1], [1]], DOYLE.C, sigma, 1).gain)
