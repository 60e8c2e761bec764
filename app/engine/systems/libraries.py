"""Take plants of python-control and scipy.signal without loading either library."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import block_diag

from .errors import EngineError
from .plant import Plant

__all__ = ["plant_like", "realised"]


def plant_like(value: Any) -> Plant | None:
    """The plant that a system is: ours, python-control's StateSpace or TransferFunction, SciPy's lti or dlti; None for the rest.

    A transfer function with several inputs or outputs is realised entry by entry, which need not be minimal. Raises EngineError
    for a sampled system whose period is not known, and for a transfer function with more zeros than poles.
    """
    if isinstance(value, Plant):
        return value
    library = type(value).__module__.split(".")[0]
    if library == "control" and type(value).__name__ in ("StateSpace", "TransferFunction"):
        return _of_control(value)
    if library == "scipy" and ".signal" in type(value).__module__ and hasattr(value, "to_ss"):
        return _of_scipy(value)
    return None


def _of_control(system: Any) -> Plant:
    if system.dt is True:
        raise EngineError("The sampling period is unspecified (dt=True); give it in seconds.")
    dt = float(system.dt or 0.0)
    if type(system).__name__ == "TransferFunction":
        return realised(system.num, system.den, dt)
    return Plant(*(np.asarray(getattr(system, key)) for key in "ABCD"), dt=dt)


def _of_scipy(system: Any) -> Plant:
    from scipy.signal import zpk2tf  # late: it brings all of scipy.stats, 0.6 s

    if system.dt is True:
        raise EngineError("The sampling period is unspecified (dt=True); give it in seconds.")
    dt = float(system.dt or 0.0)
    if hasattr(system, "A"):
        return Plant(system.A, system.B, system.C, system.D, dt)
    if hasattr(system, "zeros") and not hasattr(system, "num"):
        num, den = zpk2tf(system.zeros, system.poles, system.gain)
    else:
        num, den = system.num, system.den
    return realised([[num]] if np.ndim(num) == 1 else [[row] for row in num], [[den]] * max(1, np.ndim(num) > 1 and len(num)), dt)


def realised(num: Any, den: Any, dt: float) -> Plant:
    """y_i = Σ_j num_ij / den_ij u_j, one realisation beside the other."""
    outputs, inputs = len(num), len(num[0])
    parts, B, C, D = [], [], [], np.zeros((outputs, inputs))
    for i in range(outputs):
        for j in range(inputs):
            top, bottom = np.trim_zeros(np.atleast_1d(num[i][j]), "f"), np.trim_zeros(np.atleast_1d(den[i][j]), "f")
            if len(top) > len(bottom):
                raise EngineError("This transfer function has more zeros than poles; no plant with states can be made of it.")
            if not len(top):
                continue
            lead, states = bottom[0], len(bottom) - 1
            top, bottom = np.concatenate([np.zeros(states + 1 - len(top)), top]) / lead, bottom / lead
            D[i, j] = top[0]
            if states:
                parts.append(np.vstack([-bottom[1:], np.eye(states - 1, states)]))
                B.append(np.eye(states, 1) @ np.eye(inputs)[[j]])
                C.append(np.eye(outputs)[:, [i]] @ (top[1:] - top[0] * bottom[1:])[None])
    if not parts:
        return Plant(np.zeros((0, 0)), np.zeros((0, inputs)), np.zeros((outputs, 0)), D, dt)
    return Plant(block_diag(*parts), np.vstack(B), np.hstack(C), D, dt)
