"""Measure the diagonal dominance of a square transfer matrix over frequency."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import SERIES, array, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record
from ..systems.spectrum import frequency_response

__all__ = ["Dominance", "dominance", "dominance_of", "relative_gains"]


SINGULAR = 1e12  # a relative gain beyond this is rounding


@record()
class Dominance:
    """A square response G (n_ω, k, k) over omega (n_ω,) in rad/s, and what its off-diagonal entries weigh.

    row[:, i] = Σ_{j≠i} |g_ij| / |g_ii|: what the other inputs do to output i; below 1 the row is dominant (∞ where
    g_ii = 0). Rescaled outputs leave it alone, rescaled inputs do not.
    column[:, j] = Σ_{i≠j} |g_ij| / |g_jj|: what input j does elsewhere; rescaled inputs leave it alone.
    """

    omega: np.ndarray
    response: np.ndarray
    row: np.ndarray
    column: np.ndarray

    @cached_property
    def scaled(self) -> np.ndarray:
        """(n_ω,): the least that any positive rescaling of inputs and outputs can bring the largest ratio down to.

        The Perron root of |diag G|⁻¹ |off-diagonal G|: below 1 the matrix is dominant in suitable units.
        """
        size = np.abs(self.response)
        own = np.diagonal(size, axis1=1, axis2=2)
        off = size * (1 - np.eye(size.shape[1]))
        ratio = np.divide(off, own[:, :, None], out=np.zeros_like(off), where=own[:, :, None] > 0)
        root = np.abs(np.linalg.eigvals(ratio)).max(axis=1)
        return np.where((own > 0).all(axis=1), root, np.inf)

    @cached_property
    def relative_gains(self) -> np.ndarray:
        """The relative gain array at every frequency, complex (n_ω, k, k)."""
        return relative_gains(self.response)


@takes(plant=PLANT, omega=SERIES)
def dominance(plant: Plant, omega: object) -> Dominance:
    """Row and column dominance of G(jω) = C (jωI − A)⁻¹ B + D, at e^{jω dt} where dt > 0.

    Raises ShapeError for a plant that is not square, EngineError exactly on a pole.
    """
    if plant.m != plant.p:
        raise ShapeError("Dominance is about a square transfer matrix; this one is {p}×{m}.", p=plant.p, m=plant.m)
    w = np.atleast_1d(np.asarray(omega, dtype=float))
    G = frequency_response(plant.A, plant.B, plant.C, plant.D, w, dt=plant.dt)
    if not np.isfinite(G).all():
        raise EngineError("The response is not finite; leave out frequencies that lie on a pole.")
    return dominance_of(w, G)


@takes(omega=SERIES, response=array("… k k", imaginary=True))
def dominance_of(omega: np.ndarray, response: np.ndarray) -> Dominance:
    """The same from a response (n_ω, k, k) that is known already."""
    G = np.asarray(response)
    if G.ndim != 3 or len(G) != len(omega):
        raise ShapeError("A response must be n×k×k with one k×k matrix for each of the n frequencies; it is "
                         "{g_shape}.",
                         g_shape=G.shape)
    size = np.abs(G)
    own = np.diagonal(size, axis1=1, axis2=2)
    off = size * (1 - np.eye(G.shape[1]))

    def ratio(others: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(others > 0, others / own, np.where(own > 0, 0.0, np.inf))
    return Dominance(np.asarray(omega), G, ratio(off.sum(axis=2)), ratio(off.sum(axis=1)))


@takes(response=array("… k k", imaginary=True))
def relative_gains(response: object) -> np.ndarray:
    """Λ = G ∘ (G⁻¹)ᵀ for G (…, k, k), complex: its rows and columns sum to 1, and units do not matter.

    λ_ii = 1: the channel's gain is the same whether the other loops are open or perfectly closed. Raises EngineError
    where G is singular. Source: Bristol, "On a new measure of interaction for multivariable process control" (1966).
    """
    G = np.asarray(response)
    if not G.size:
        raise ShapeError("Relative gains are defined for square matrices; take as many inputs as outputs.")
    try:
        even = _even(_even(G, -1), -2)  # an inverse of entries of like size: the units of G cost no digits
        gains = even * np.swapaxes(np.linalg.inv(even), -1, -2)
    except np.linalg.LinAlgError:
        gains = np.full(G.shape, np.inf)
    if not np.abs(gains).max(initial=0.0) < SINGULAR:
        raise EngineError("G is singular at one of the frequencies, so relative gains are not defined there.")
    return gains


def _even(G: np.ndarray, axis: int) -> np.ndarray:
    size = np.abs(G).max(axis=axis, keepdims=True)
    return G / 2.0 ** np.round(np.log2(np.where(size > 0, size, 1.0)))
