"""Compute spectral densities of a sampled loop from the responses of its two halves."""

from __future__ import annotations

import numpy as np

from ..systems.gates.argument_checks import SERIES, instance, takes
from ..systems.records import record
from ..systems.spectrum import frequency_response
from .sampled_loop import SampledLoop

__all__ = ["MechanicsResponse", "loop_density", "mechanics_response"]


@record()
class MechanicsResponse:
    """Responses of driver, plant and ground filter at z = e^{j2πf dt}, shared by all controllers of one plant.

    force (n_f, p + q, m): from commands, delay included, to readings and recorded outputs; ground (n_f, p + q, r): from
    the unit noise of the loop's `jump` (without that of the bias).
    """

    frequency: np.ndarray
    force: np.ndarray
    ground: np.ndarray


@takes(loop=instance(SampledLoop), frequency=SERIES)
def mechanics_response(loop: SampledLoop, frequency: object) -> MechanicsResponse:
    """The responses of a loop's continuous part, seen at the samples; `frequency` in Hz."""
    f = np.atleast_1d(np.asarray(frequency, dtype=float))
    part, m = loop.mechanics, loop.U.shape[1]
    rows = np.vstack([loop.Y[:, part], loop.outputs[:, part]])
    whole, soon, late = loop.ways
    jump = loop.jump[part]
    jump = jump[:, np.any(jump != 0, axis=0)]
    waits = bool(np.any(late))
    enter = np.hstack([soon, late, jump] if waits else [soon, jump])
    H = frequency_response(loop.F[-1][part, part], enter, rows, np.zeros((len(rows), enter.shape[1])), 2 * np.pi * f,
                           dt=loop.dt)
    back = np.exp(-2j * np.pi * f * loop.dt)[:, None, None]
    force, ground = H[:, :, :m], H[:, :, 2 * m if waits else m:]
    if waits:
        force = force + H[:, :, m:2 * m] * back
    return MechanicsResponse(f, force * back**whole, ground)


@takes(loop=instance(SampledLoop), mechanics=instance(MechanicsResponse))
def loop_density(loop: SampledLoop, mechanics: MechanicsResponse) -> np.ndarray:
    """One-sided densities (n_f, q + m) of the recorded outputs and the commands of the settled loop, in units²/Hz.

    u = K(y + v) closes y = P u + G n: u = (I − K P)⁻¹K(G n + v), at each frequency by itself. Nothing clips; rounding is
    white noise of step²/12; a walking bias adds walk² dt/|z − 1|² to the noise of a reading. The loop's `mechanics` may
    be those of another loop with the same plant, driver, delay, ground and outputs.
    """
    f, (p, m) = mechanics.frequency, (len(loop.Y), loop.U.shape[1])
    own, last = loop.control, -1
    closed = loop.F[last][own, own] + loop.F_s[last][own] @ loop.U[last][:, own]
    enter = loop.F_m[last][own] + loop.F_s[last][own] @ loop.T[last]
    K = frequency_response(closed, enter, loop.U[last][:, own], loop.T[last], 2 * np.pi * f, dt=loop.dt) \
        if own.stop > own.start else np.broadcast_to(loop.T[last].astype(complex), (len(f), m, p))
    P, G = mechanics.force, mechanics.ground
    S = np.linalg.solve(np.eye(m) - K @ P[:, :p], K)  # from readings' noise to u
    from_ground = S @ G[:, :p]
    outputs = np.concatenate([G[:, p:] + P[:, p:] @ from_ground, from_ground], axis=1)
    sensors = np.concatenate([P[:, p:] @ S, S], axis=1)
    spread = loop.reading
    if np.any(spread - np.diag(np.diag(spread))):
        noise = np.maximum(np.einsum("fki,ij,fkj->fk", sensors, spread, sensors.conj(), optimize=True).real, 0.0)
    else:
        noise = (sensors.real**2 + sensors.imag**2) @ np.diag(spread)
    if loop.hardware.walk > 0:
        noise = noise + _walked(loop, f)[:, None] * (sensors.real**2 + sensors.imag**2).sum(axis=2)
    return 2 * loop.dt * ((outputs.real**2 + outputs.imag**2).sum(axis=2) + noise)


def _walked(loop: SampledLoop, f: np.ndarray) -> np.ndarray:
    """What a walking bias adds to the variance of each reading at each frequency (n_f,)."""
    return loop.hardware.walk**2 * loop.dt / np.abs(np.exp(2j * np.pi * f * loop.dt) - 1) ** 2
