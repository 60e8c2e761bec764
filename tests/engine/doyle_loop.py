"""Doyle's loop of 1978."""

import numpy as np

from app.engine.design.optimal import lqe, lqr
from app.engine.feedback.compensator import compensator
from app.engine.systems.plant import Plant

ONES = np.ones((2, 2))
DOYLE = Plant([[1, 1], [0, 1]], [[0], [1]], [[1, 0]])


def doyle(q, sigma):
    K = lqr(DOYLE.A, DOYLE.B, q * ONES, 1).gain
    return compensator(DOYLE, K, lqe(DOYLE.A, [[1], [1]], DOYLE.C, sigma, 1).gain)
