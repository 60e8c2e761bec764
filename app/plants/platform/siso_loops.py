"""Design decoupled SISO controllers of the platform: the published pair and our own.

Channels z = T_y y and u = T_u v as in `channels`; all controllers here run from z to v or from y to u with
their sign inside. The report (003, chapter 2) prints C_v (26) with a minus sign in its numerator and C_h (31), (32)
with plus signs, and writes unit negative feedback only for the latter. On this plant one choice alone holds every
pole but one: v = +C_v z and v = −C_h z. The one is the pole that C_v itself has at +7.94e-11 rad/s.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ...engine import EngineError, Plant, balanced_truncation, lqg
from ...engine.design import Diophantine, LoopShape, diagonal_controller, diophantine, loop_shaped, negated, rational
from ...engine.systems import as_matrix
from . import model
from .channels import CHANNELS, HORIZONTAL, ROTATION, VERTICAL_CHANNEL, Channel, T_u, T_y, in_channels
from .lqg_weights import FIGURE_WEIGHTS, GROUND_UNIT, H_MAG, V_MAG, Weights

NOMINAL = model.Parameters()
THREE = (VERTICAL_CHANNEL, ROTATION, HORIZONTAL)
CV_NUMERATOR = (-4.269e9, -49.34, -0.8706)  # equation (26)
CV_DENOMINATOR = (1.0, 1.366e5, 134.9, -1.071e-8)
CH_NUMERATOR = (1.813e10, 3.92e13, 1.683e14, 1.015e16, 3.834e16, 9.067e16, 1.773e17, 1.615e17, 1.97e17, 8.113e15,
                7.508e14, 6.34e8)  # equation (31)
CH_DENOMINATOR = (1.0, 8.253e4, 5.317e6, 4.423e8, 2.304e9, 1.078e11, 2.12e11, 4.467e11, 4.853e11, 4.096e11, 1.72e10,
                  1.535e9, 3.159)  # equation (32)
VERTICAL_SHAPE = LoopShape(-2000.0, lag=(0.5, 0.05), roll_off=6000.0)
# Closed-loop poles in rad/s, four and four. P_h has zeros at −0.034 ± 7.421j, where the deck pitches while the horizontal
# coil stands still; a loop through that coil cannot move a pole away from there without large gains.
BESIDE_THE_ZEROS = ((-0.034 + 7.421j, -0.034 - 7.421j, -0.2 + 0j, -200 + 0j),
                    (-0.06 + 7.45j, -0.06 - 7.45j, -600 + 450j, -600 - 450j))
AT_WILL = ((-14 + 10j, -14 - 10j, -9 + 9j, -9 - 9j), (-60 + 45j, -60 - 45j, -30 + 30j, -30 - 30j))


@lru_cache(maxsize=8)
def channel_plant(channel: Channel, parameters: model.Parameters = NOMINAL) -> Plant:
    """P_v, P_θ or P_h: from the channel's own force v_i (N) to its velocity z_i (m/s), the other forces at zero.

    Ten states, of which the vertical channel moves four and the others six. Raises EngineError for a channel without a
    coil.
    """
    whole = in_channels(model.plant(parameters))
    if channel.input is None:
        raise EngineError("No coil acts on the channel {id}; take vertical, rotation or horizontal.", id=channel.id)
    return Plant(whole.A, whole.B[:, [channel.input]], whole.C[[channel.output]], None,  # type: ignore[arg-type]
                 name=f"P {channel.id}")


def rigid_polynomials(channel: Channel, mixing: object | None = None,
                      parameters: model.Parameters = NOMINAL) -> tuple[np.ndarray, np.ndarray]:
    """(B, A) of the channel on a rigid deck, coefficients from the highest power down, A monic: of degree 1, 2 in the
    vertical channel and 3, 4 in the others, where pitch and the horizontal mode both show. B has a root at s = 0: no
    constant force gives a velocity. `mixing` (3×3) stands between the channel's input and T_u, eq. (20).
    """
    T = T_u if mixing is None else T_u @ as_matrix(mixing, "The mixing")
    k = model.rigid(parameters)
    keep = [1] if channel is VERTICAL_CHANNEL else [0, 2]
    M, D, K = (m[np.ix_(keep, keep)] for m in (k.M, k.D, k.K))
    push = (k.G[:, :3] @ T)[keep, channel.input or 0]
    read = (T_y @ k.S)[channel.output, keep]
    if len(keep) == 1:
        return np.array([read[0] * push[0], 0.0]) / M[0, 0], np.array([1.0, D[0, 0] / M[0, 0], K[0, 0] / M[0, 0]])

    def entry(i: int, j: int) -> np.ndarray:
        return np.array([M[i, j], D[i, j], K[i, j]])
    # q = adj(Ms² + Ds + K) push / det, z = s read·q
    A = np.polysub(np.polymul(entry(0, 0), entry(1, 1)), np.polymul(entry(0, 1), entry(1, 0)))
    q = (np.polysub(entry(1, 1) * push[0], entry(0, 1) * push[1]), np.polysub(entry(0, 0) * push[1], entry(1, 0) * push[0]))
    B = np.append(np.polyadd(read[0] * q[0], read[1] * q[1]), 0.0)
    return B / A[0], A / A[0]


# --- as published ----------------------------------------------------------------------------------------------------
@lru_cache(maxsize=1)
def published_cv() -> Plant:
    """C_v of equation (26), sign as printed: for v = +C_v z."""
    return rational(CV_NUMERATOR, CV_DENOMINATOR)


@lru_cache(maxsize=1)
def published_ch() -> Plant:
    """C_h of equations (31) and (32), sign as printed: for v = −C_h z."""
    return rational(CH_NUMERATOR, CH_DENOMINATOR)


@lru_cache(maxsize=1)
def published() -> Plant:
    """The report's controller y → u: u = T_u diag(+C_v, 0, −C_h) T_y y, pitch open, eqs (24)–(32)."""
    return from_channels(published_cv(), None, negated(published_ch()), "published SISO pair")


# --- our own ---------------------------------------------------------------------------------------------------------
def from_channels(vertical: Plant | None, rotation: Plant | None, horizontal: Plant | None, name: str = "",
                  mixing: object | None = None) -> Plant:
    """u = T_u S diag(C_v, C_θ, C_h) T_y y; a sign belongs to its controller, None leaves its channel open.

    `mixing` S (3×3) is that of eq. (20), by default none.
    """
    T = T_u if mixing is None else T_u @ as_matrix(mixing, "The mixing")
    return diagonal_controller((vertical, rotation, horizontal), T_y[:3], T, name=name)


def horizontal_by_poles(control: Sequence[complex] = BESIDE_THE_ZEROS[0], observer: Sequence[complex] = BESIDE_THE_ZEROS[1],
                        mixing: object | None = None, parameters: model.Parameters = NOMINAL) -> Diophantine:
    """A E + B F = Φ_c Φ_o for P_h on a rigid deck, eq. (30): four and four poles, a strictly proper controller of order 4.

    Raises PoleError or EngineError as `diophantine` does.
    """
    B, A = rigid_polynomials(HORIZONTAL, mixing, parameters)
    return diophantine(A, B, np.real(np.poly([*control, *observer])))


def pitch_loop(bandwidth: float, roll_off: float = 6000.0) -> Plant:
    """C_θ = −k/(s/ω_r + 1): the loop k P_θ then passes a band of `bandwidth` rad/s (at −3 dB) around the pitch mode.

    P_θ ≈ g s/(s² + 2ζω s + ω²), so the closed loop's s² + (2ζω + k g) s + ω² has that width for k g = bandwidth − 2ζω.
    """
    g, own = _pitch_rate()
    return loop_shaped(LoopShape(-max(bandwidth - own, 0.0) / g, roll_off=roll_off))


@lru_cache(maxsize=1)
def _pitch_rate() -> tuple[float, float]:
    """g of P_θ at high frequency on a rigid deck, and the pitch mode's own 2ζω, both from the rotation alone."""
    k, p = model.rigid(), model.Parameters()
    return p.s * 2 * p.b / float(k.M[2, 2]), float(k.D[2, 2] / k.M[2, 2])


@lru_cache(maxsize=1)
def designed() -> Plant:
    """Our pair y → u: C_v by loop shaping, C_h by poles, pitch open."""
    return from_channels(loop_shaped(VERTICAL_SHAPE), None, horizontal_by_poles().controller(), "designed SISO pair")


# --- decoupled LQG, section 5.3.3 -------------------------------------------------------------------------------------
def reduced_channel(channel: Channel, order: int = 2) -> tuple[Plant, np.ndarray]:
    """The channel's own model: P_i with the ground as further inputs, cut to `order` states; (plant, G (order×2))."""
    whole = model.plant()
    index = CHANNELS.index(channel)
    B = np.hstack([in_channels(whole).B[:, [index]], whole.B[:, 3:]])
    cut = balanced_truncation(Plant(whole.A, B, T_y[[index]] @ whole.C), order).plant
    return Plant(cut.A, cut.B[:, :1], cut.C, np.asarray(cut.D)[:, :1], name=f"{channel.id}, {order} states"), cut.B[:, 1:]


@lru_cache(maxsize=32)
def decoupled_lqg(weights: Weights = FIGURE_WEIGHTS, orders: tuple[int, int, int] = (2, 2, 2)) -> Plant:
    """Three LQG controllers, one for each channel's own reduced model, as one controller y → u.

    The report's weights seen in one channel: z_i² counts twice over its unit of velocity, since the other sensor says the
    same; two coils share a vertical force; the mean of two sensors has half their noise intensity. Were the channels
    really apart, this would be the report's full LQG.
    """
    controllers = []
    for channel, order, magnitude, coils in zip(THREE, orders, (V_MAG, V_MAG, H_MAG), (2, 2, 1), strict=True):
        plant, G = reduced_channel(channel, order)
        Q = weights.alpha_q * 2 / magnitude**2 * plant.C.T @ plant.C
        design = lqg(plant, Q, weights.alpha_r * coils, weights.beta_q * GROUND_UNIT, weights.beta_r * weights.v0 / 2,
                     G=G)
        controllers.append(design.controller)
    return from_channels(*controllers, name="decoupled LQG")
