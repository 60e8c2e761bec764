"""Build dead time into a plant: samples where it is sampled, Padé fractions where it is continuous."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from ..systems.errors import EngineError, Phrase
from ..systems.plant import Plant
from .notes import note

__all__ = ["PADE_ORDER", "with_delays"]

PADE_ORDER = 3
_WHOLE = 1e-9  # how far a number of samples may be from a whole one, relative
Block = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def with_delays(plant: Plant, inputs: np.ndarray, outputs: np.ndarray, keys: tuple[str, str]) -> tuple[Plant, tuple[Phrase, ...]]:
    """The plant with its inputs and outputs delayed: s where it is continuous, whole samples where it is sampled; and what to say of it.

    inputs (m,), outputs (p,), or one number for all. The states of the plant come first, then those of the delays.
    Raises EngineError for a delay that is negative or no whole number of samples, or where there are more numbers than channels.
    """
    late = [_each(delays, count, key, plant.dt) for delays, count, key in ((inputs, plant.m, keys[0]), (outputs, plant.p, keys[1]))]
    if not any(part.any() for part in late):
        return plant, ()
    before, after = ([_block(delay, plant.dt) for delay in part] for part in late)
    made = _series(plant, before, after)
    longest, added = max(float(part.max(initial=0.0)) for part in late), made.n - plant.n
    if plant.dt:
        return made, (note("samples", longest=round(longest), added=added),)
    return made, (note("pade", longest=longest, order=PADE_ORDER, added=added),)


def _each(delays: np.ndarray, count: int, key: str, dt: float) -> np.ndarray:
    if delays.size not in (0, 1, count):
        raise EngineError("{key} must have {count} numbers, one for each channel; it has {given}.", key=key, count=count, given=delays.size)
    if not np.isfinite(delays).all() or (delays < 0).any():
        raise EngineError("{key} must hold delays of zero or more.", key=key)
    each = np.zeros(count) if not delays.size else np.broadcast_to(delays, count).astype(float)
    if dt and (np.abs(each - np.round(each)) > _WHOLE * np.maximum(each, 1)).any():
        raise EngineError("{key} must hold whole numbers of samples, because the plant is sampled; divide seconds by the sampling period.",
                          key=key)
    if dt and each.sum() > 1000:
        raise EngineError("{key} is longer than the 200 states a plant may have; sample more slowly.", key=key)
    return np.round(each) if dt else each


def _block(delay: float, dt: float) -> Block:
    """One channel with that delay: A k×k, B k×1, C 1×k, D 1×1."""
    from scipy.signal import tf2ss  # late: it brings all of scipy.stats, 0.6 s

    if not delay:
        return np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1))
    if dt:
        k = int(delay)
        return np.eye(k, k=-1), np.eye(k, 1), np.eye(1, k, k - 1), np.zeros((1, 1))
    from control import pade

    A, B, C, D = tf2ss(*pade(1.0, PADE_ORDER))  # of one second; then the clock is scaled
    return A / delay, B / delay, C, D


def _series(plant: Plant, before: list[Block], after: list[Block]) -> Plant:
    """Blocks, the plant, blocks: states (x, x_before, x_after)."""
    Ai, Bi, Ci, Di = (block_diag(*parts) for parts in zip(*before, strict=True))
    Ao, Bo, Co, Do = (block_diag(*parts) for parts in zip(*after, strict=True))
    A, B, C, D = plant.A, plant.B, plant.C, plant.D
    n, i, o = len(A), len(Ai), len(Ao)
    AA = np.block([[A, B @ Ci, np.zeros((n, o))], [np.zeros((i, n)), Ai, np.zeros((i, o))], [Bo @ C, Bo @ D @ Ci, Ao]])
    BB = np.vstack([B @ Di, Bi, Bo @ D @ Di])
    CC = np.hstack([Do @ C, Do @ D @ Ci, Co])
    names = (*(f"{name} delay {k + 1}" for name, part in zip(plant.input_names, before, strict=True) for k in range(len(part[0]))),
             *(f"{name} delay {k + 1}" for name, part in zip(plant.output_names, after, strict=True) for k in range(len(part[0]))))
    return replace(plant, A=AA, B=BB, C=CC, D=Do @ D @ Di, state_names=(*plant.state_names, *names))
