"""Define SISO controllers and realise badly scaled polynomials without loss of digits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from ..systems.arrays import as_checked
from ..systems.errors import EngineError, ShapeError, phrase
from ..systems.exact_roots import exact_roots
from ..systems.gates.argument_checks import (
    FINITE,
    NAME,
    POLES,
    count,
    instance,
    items,
    matrix,
    number,
    optional,
    pair,
    passed,
    takes,
    vector,
)
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant, as_matrix
from ..systems.pole_sets import Poles, pair_conjugates
from ..systems.records import record
from ..systems.spectrum import frequency_response
from .repeated_roots import merge_repeated_roots

__all__ = ["LoopShape", "diagonal_controller", "loop_shaped", "negated", "polynomial_roots", "rational",
           "realise", "series"]

PARTIAL_FRACTION_RTOL = 1e-10  # relative error of partial fractions beyond which sections in a row are used


@record(eq=True)
class LoopShape:
    """C(s) = gain · (s + z)/(s + p) · (s/z' + 1)/(s/p' + 1) · 1/(s/ω_r + 1)^order, all corners in rad/s.

    lag = (z, p), p < z: more gain at low frequency, 1 above (p = 0 integrates); lead = (z', p'), z' < p': phase in
    between; roll_off = ω_r with its order: no gain for sensor noise above. What is None is left out. The sign of `gain`
    is the sign of C.
    """

    gain: float
    lag: tuple[float, float] | None = None
    lead: tuple[float, float] | None = None
    roll_off: float | None = None
    order: int = 1

    def __post_init__(self) -> None:
        corners = optional(pair(number(), number()))
        passed(self, gain=number(), lag=corners, lead=corners, roll_off=optional(number()), order=count(1, 6))


@takes(shape=instance(LoopShape))
def loop_shaped(shape: LoopShape) -> Plant:
    """The controller of a `LoopShape`. Raises EngineError for corners that are not positive and finite (only the
    pole of the lag may be 0), or an order outside 1 … 6."""
    zeros: list[complex] = []
    poles: list[complex] = []
    gain = float(shape.gain)
    if shape.lag is not None:
        zero, pole = _corner(shape.lag[0]), _corner(shape.lag[1], True)
        zeros.append(-zero)
        poles.append(-pole)
    if shape.lead is not None:
        zero, pole = _corner(shape.lead[0]), _corner(shape.lead[1])
        zeros.append(-zero)
        poles.append(-pole)
        gain *= pole / zero
    if shape.roll_off is not None:
        corner = _corner(shape.roll_off)
        poles += [-corner] * int(shape.order)
        gain *= corner**shape.order
    return realise(zeros, poles, gain)


def _corner(value: float, may_be_zero: bool = False) -> float:
    if not np.isfinite(value) or value < 0 or (value == 0 and not may_be_zero):
        raise EngineError("A corner frequency must be a positive number in rad/s; it is {value}.", value=value)
    return float(value)


def coefficients(value: object, name: str) -> np.ndarray:
    """Real coefficients from the highest power down, without leading zeros. Raises EngineError with `name` in it."""
    try:
        p = as_matrix(value, name)
    except EngineError:
        p = None
    if p is None or len(p) > 1:
        raise EngineError("{name} must be a list of finite real coefficients, the highest power first.", name=name)
    return np.trim_zeros(p[0], "f")


@takes(polynomial=vector())
def polynomial_roots(polynomial: object) -> Poles:
    """Roots of a polynomial, coefficients from the highest power down, complex ones in exact pairs, sorted by (real, imag).

    They are those of the very coefficients given, to rounding; but where k roots lie so near each other that one of
    multiplicity k gives the same coefficients to rounding, it is one root k times: multiplicity is read from the data,
    the scatter of its copies is not. Raises EngineError for coefficients that are no finite real numbers.
    """
    p = coefficients(polynomial, phrase("The polynomial"))
    whole = np.trim_zeros(p, "b")
    zeros = np.zeros(len(p) - len(whole), dtype=complex)
    if len(whole) < 2:
        return zeros
    near = np.roots(whole).astype(complex)
    return np.sort_complex(np.concatenate([zeros, merge_repeated_roots(whole, exact_roots(whole, near).values)]))


@takes(numerator=vector(), denominator=vector())
def rational(numerator: object, denominator: object) -> Plant:
    """The SISO plant N(s)/D(s), coefficients from the highest power down, realised by its roots (`realise`).

    Raises EngineError for a zero denominator or a numerator of higher degree.
    """
    num, den = coefficients(numerator, phrase("The numerator")), coefficients(denominator, phrase("The denominator"))
    if not den.size:
        raise EngineError("The denominator must not be zero.")
    if not num.size:
        return Plant(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.zeros((1, 1)))
    return realise(polynomial_roots(num), polynomial_roots(den), float(num[0] / den[0]))


@takes(zeros=POLES, poles=POLES, gain=FINITE)
def realise(zeros: Sequence[complex] | np.ndarray, poles: Sequence[complex] | np.ndarray, gain: float) -> Plant:
    """The SISO plant gain · ∏(s − zᵢ)/∏(s − pᵢ): partial fractions in real blocks, or sections in a row where poles
    (nearly) coincide. Either keeps every pole as it is given, however far apart they lie.

    Raises EngineError if there are more zeros than poles, or a complex one without its conjugate.
    """
    z, p = _paired(zeros), _paired(poles)
    if len(z) > len(p):
        raise EngineError("There are {count} zeros and {count2} poles; a controller needs at least as many poles "
                          "as zeros.",
                          count=len(z), count2=len(p))
    if not len(p):
        return Plant(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.full((1, 1), gain))
    modal = _modal(z, p, gain)
    return modal if _error(modal, z, p, gain) < PARTIAL_FRACTION_RTOL else _cascade(z, p, gain)


def _error(plant: Plant, z: np.ndarray, p: np.ndarray, gain: float) -> float:
    """Largest relative error of a realisation where its poles and zeros lie and in between, off the real zeros."""
    corners = np.abs(np.concatenate([z, p]))
    corners = np.sort(corners[corners > 0]) if (corners > 0).any() else np.ones(1)
    s = 1j * np.concatenate([1.01 * corners, np.sqrt(corners[1:] * corners[:-1])])
    right = gain * np.prod(s[:, None] - z, axis=1) / np.prod(s[:, None] - p, axis=1)
    ours = frequency_response(plant.A, plant.B, plant.C, plant.D, s.imag)[:, 0, 0]
    with np.errstate(all="ignore"):
        error = float(np.abs(ours / right - 1).max()) if gain else 0.0
    return error if np.isfinite(error) else np.inf


def _paired(roots: Sequence[complex] | np.ndarray) -> np.ndarray:
    """Real roots first, then those of the upper half plane and their conjugates, each sorted."""
    r = pair_conjugates(roots, rtol=1e-6)
    upper = np.sort_complex(r[np.imag(r) > 0])
    return np.concatenate([np.sort(np.real(r[np.imag(r) == 0])).astype(complex), upper, upper.conj()])


def _modal(z: np.ndarray, p: np.ndarray, gain: float) -> Plant:
    """Σ rᵢ/(s − pᵢ) + D with blocks [σ ω; −ω σ] and inputs and outputs of equal size."""
    blocks, inputs, outputs = [], [], []
    if len(np.unique(p)) < len(p):
        return _cascade(z, p, gain)
    for i in np.flatnonzero(np.imag(p) >= 0):
        pole = p[i]
        others = np.delete(p, i)
        residue = gain * np.prod(pole - z) / np.prod(pole - others)
        k = np.sqrt(abs(residue)) or 1.0
        if pole.imag == 0:
            blocks.append([[pole.real]])
            inputs.append([k])
            outputs.append([residue.real / k])
        else:
            blocks.append([[pole.real, pole.imag], [-pole.imag, pole.real]])
            inputs.append([np.sqrt(2) * k, 0.0])
            outputs.append([np.sqrt(2) * residue.real / k, np.sqrt(2) * residue.imag / k])
    D = gain if len(z) == len(p) else 0.0
    return Plant(np.asarray(block_diag(*blocks)), np.concatenate(inputs)[:, None], np.concatenate(outputs)[None], np.full((1, 1), D))


def _cascade(z: np.ndarray, p: np.ndarray, gain: float) -> Plant:
    """Second order sections in a row, and one of first order where the number of poles is odd."""
    poles, zeros = _factors(p), _factors(z)
    zeros += [np.ones(1)] * (len(poles) - len(zeros))
    whole = Plant(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.full((1, 1), gain))
    for num, den in zip(zeros, poles, strict=True):
        whole = series(_section(num, den), whole)
    return whole


def _factors(roots: np.ndarray) -> list[np.ndarray]:
    """Monic real factors of second order, neighbours in size together, then at most one of first order."""
    pairs = [np.array([1.0, -2 * r.real, abs(r)**2]) for r in roots if r.imag > 0]
    real = sorted((r.real for r in roots if r.imag == 0), key=abs)
    pairs += [np.poly(real[k:k + 2]) for k in range(0, len(real) - 1, 2)]
    return pairs + ([np.array([1.0, -real[-1]])] if len(real) % 2 else [])


def _section(num: np.ndarray, den: np.ndarray) -> Plant:
    """A companion form in the section's own unit of time."""
    n = len(den) - 1
    scale = float(abs(den[-1]) ** (1 / n)) or 1.0
    a = den[1:] / scale ** np.arange(1.0, n + 1)
    top = np.pad(num, (n + 1 - len(num), 0))
    rest = (top[1:] - top[0] * den[1:]) / scale ** np.arange(1.0, n + 1)
    A = np.diag(np.ones(n - 1), 1)
    A[-1] = -a[::-1]
    B = np.zeros((n, 1))
    B[-1, 0] = scale
    return Plant(scale * A, B, rest[::-1][None], np.full((1, 1), top[0]))


@takes(last=PLANT, first=PLANT)
def series(last: Plant, first: Plant) -> Plant:
    """The plant last · first: what `first` gives out goes into `last`. Raises ShapeError where they do not fit."""
    if last.m != first.p or last.dt != first.dt:
        raise ShapeError("The first system has {p} outputs, the last {m} inputs; they must agree, as must dt.",
                         p=first.p, m=last.m)
    D1, D2 = np.asarray(first.D), np.asarray(last.D)
    A = np.block([[first.A, np.zeros((first.n, last.n))], [last.B @ first.C, last.A]])
    return Plant(A, np.vstack([first.B, last.B @ D1]), np.hstack([D2 @ first.C, last.C]), D2 @ D1, first.dt)


@takes(plant=PLANT)
def negated(plant: Plant) -> Plant:
    """−G: outputs with their sign turned."""
    return Plant(plant.A, plant.B, -plant.C, -np.asarray(plant.D), plant.dt, plant.state_names, plant.input_names,
                 plant.output_names, plant.units, plant.name)


@takes(channels=items(optional(PLANT), 1000), outputs=matrix(), inputs=matrix(), name=NAME)
def diagonal_controller(channels: Sequence[Plant | None], outputs: object, inputs: object, *, name: str = "") -> Plant:
    """u = T_u diag(C₁, …, C_k) T_y y: SISO controllers, signs included, between virtual outputs and virtual inputs.

    `outputs` is T_y (k×p), `inputs` T_u (m×k); None leaves a channel open. Raises ShapeError where they do not fit.
    """
    T_y, T_u = as_checked(outputs), as_checked(inputs)
    k = len(channels)
    if T_y.shape[0] != k or T_u.shape[1] != k:
        raise ShapeError("{k} channels need a T_y of {k} rows and a T_u of {k} columns; they are {rows}×{columns} "
                         "and {rows2}×{columns2}.",
                         k=k, rows=T_y.shape[0], columns=T_y.shape[1], rows2=T_u.shape[0], columns2=T_u.shape[1])
    closed = [(i, c) for i, c in enumerate(channels) if c is not None]
    if any((c.m, c.p) != (1, 1) for _, c in closed) or len({c.dt for _, c in closed}) > 1:
        raise ShapeError("Every channel's controller must have one input and one output, and all the same dt.")
    n = sum(c.n for _, c in closed)
    A, B, C, D = np.zeros((n, n)), np.zeros((n, k)), np.zeros((k, n)), np.zeros((k, k))
    at = 0
    for i, c in closed:
        own = slice(at, at + c.n)
        A[own, own], B[own, i], C[i, own], D[i, i] = c.A, c.B[:, 0], c.C[0], np.asarray(c.D)[0, 0]
        at += c.n
    dt = closed[0][1].dt if closed else 0.0
    return Plant(A, B @ T_y, T_u @ C, T_u @ D @ T_y, dt, name=name)
