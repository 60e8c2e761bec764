"""Build residual-generator banks, each ignoring one sensor or input, to isolate faults."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from ..design.optimal import dlqe
from ..filters.linear.linear_filter import LinearFilter
from ..filters.track import as_record
from ..structure.decomposition import unobservable_subspace
from ..systems.arrays import symmetric
from ..systems.balance import balance, without_dust
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import COMPLEX, GENERATOR, NAME, RECORD, array, count, gated, instance, items, matrix, optional, takes
from ..systems.noise import root
from ..systems.plant import Plant, as_matrix
from ..systems.pole_sets import Poles, pole_text, sorted_poles
from ..systems.records import record
from ..systems.recursions import held_scan
from .unknown_input import decoupling

__all__ = ["FaultBank", "ResidualGenerator", "isolate", "residual_generator"]

NO_FAULT, UNCLEAR_FAULT = -1, -2
SEEN_SHARE = 1e-8  # a whitened response above this share of the bank's largest counts as seen


@record()
class ResidualGenerator:
    """z⁺ = F z + G u + K y, ρ = W (N y − C z − M u): white, of unit covariance, as long as nothing fails.

    F r×r, G r×m, K r×p, N q×p, C q×r, M q×m, W q×q. z estimates `project` x (r×n); P (r×r) is the covariance of
    project x − z, S (q×q) that of the innovation ν = W⁻¹ρ, the columns of `basis` (n×r) what z counts. `hidden` are the modes
    left out because no output shows them: the invariant zeros of (A, E, C).
    """

    name: str
    F: np.ndarray
    G: np.ndarray
    K: np.ndarray
    C: np.ndarray
    N: np.ndarray
    M: np.ndarray
    whiten: np.ndarray
    project: np.ndarray
    P: np.ndarray
    S: np.ndarray
    poles: Poles
    hidden: Poles
    basis: np.ndarray

    @property
    def size(self) -> int:
        """Number of states r."""
        return len(self.F)

    @property
    def dof(self) -> int:
        """Number of independent residuals q."""
        return len(self.whiten)


@takes(model=instance(LinearFilter), name=NAME, outputs=items(count(), 1000), E=matrix())
def residual_generator(model: LinearFilter, *, name: str = "", outputs: Sequence[int] | None = None,
                       E: object | None = None) -> ResidualGenerator:
    """The steady Kalman filter of a model on some of its outputs that an unknown input through E (n×q) cannot reach.

    x⁺ = A x + B u + E d + w, y = C x + D u + v. With H, T of `decoupling` weighted with R, s = T x obeys
    s⁺ = T A s + T A H (y − D u) + T B u + T w − T A H v and Nᵀ(y − D u) = Nᵀ C s + Nᵀ v where Nᵀ C E = 0; the two noises are
    uncorrelated, and the modes that Nᵀ C does not see are left out, so that a residual exists even where no observer of the
    whole state does. Without E it is the Kalman filter itself. Raises EngineError where C E loses rank or nothing is left
    to compare, ShapeError.

    >>> model = KalmanFilter(np.diag([0.5, 0.8]), np.ones((2, 1)), np.eye(2), np.eye(2), np.eye(2))
    >>> residual_generator(model, name="sensor 1", outputs=[0]).name
    'sensor 1'
    """
    n, p = model.n, len(model.C)
    chosen = list(range(p)) if outputs is None else [int(i) for i in outputs]
    if not chosen or len(set(chosen)) < len(chosen) or not all(0 <= i < p for i in chosen):
        raise ShapeError("Outputs must be different numbers from 0 to {p}, at least one of them.", p=p - 1)
    pick = np.eye(p)[chosen]
    C, R = model.C[chosen], model.R[np.ix_(chosen, chosen)]
    H, T, N = np.zeros((n, len(chosen))), np.eye(n), np.eye(len(chosen))
    if E is not None:
        known = decoupling(Plant(model.A, model.B, C, dt=model.dt or 1.0), E, weight=R)
        if known.H is None or known.T is None:
            raise EngineError(known.reason)
        if known.rank_E == len(chosen):
            raise EngineError("Every output is needed to work out the unknown input, and nothing is left to "
                              "compare; measure more.")
        H, T = known.H, known.T
        N = np.linalg.svd(C @ np.asarray(E, dtype=float))[0][:, known.rank_E:]
    inner = without_dust(T @ model.A, balance(model.A, None if E is None else np.asarray(E, dtype=float), C).states)
    V, hidden = _seen(inner, N.T @ C)
    A, Cs = V.T @ inner @ V, N.T @ C @ V
    let_in = V.T @ inner @ H
    Q, Rs = V.T @ T @ model.Q @ T.T @ V + let_in @ R @ let_in.T, N.T @ R @ N
    steady = dlqe(A, np.eye(len(A)), Cs, symmetric(Q), symmetric(Rs))
    S = symmetric(Cs @ steady.solution @ Cs.T + Rs)
    L = steady.predictor_gain
    K, Ny = (let_in + L @ N.T) @ pick, N.T @ pick
    return ResidualGenerator(name, A - L @ Cs, V.T @ T @ model.B - K @ model.D, K, Cs, Ny, Ny @ model.D,
                             np.linalg.inv(np.linalg.cholesky(S)), V.T @ T, steady.solution, S, steady.poles, hidden, V)


def _seen(A: np.ndarray, C: np.ndarray) -> tuple[np.ndarray, Poles]:
    """A basis of the states that C sees, and the modes of A that it does not see."""
    basis, count = unobservable_subspace(A, C)
    if not count:
        return np.eye(len(A)), np.empty(0, dtype=complex)
    hidden = basis[:, len(A) - count:]
    return basis[:, :len(A) - count], sorted_poles(hidden.T @ A @ hidden)


@record()
class FaultBank:
    """Residual generators of one model, run as one block system. All have the same number q of residuals.

    Raises ShapeError where there is none, or they differ.
    """

    model: LinearFilter
    members: tuple[ResidualGenerator, ...]

    def __post_init__(self) -> None:
        if not self.members:
            raise ShapeError("A bank needs at least one residual generator.")
        if len({m.dof for m in self.members}) > 1:
            raise ShapeError("The members of a bank must have the same number of residuals, to be compared.")

    @property
    def dof(self) -> int:
        """Number of independent residuals of each member."""
        return self.members[0].dof

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Which states of the block system belong to which member."""
        ends = np.cumsum([m.size for m in self.members])
        return tuple(slice(int(e) - m.size, int(e)) for e, m in zip(ends, self.members, strict=True))

    @cached_property
    def _spreads(self) -> tuple[np.ndarray, ...]:
        return tuple(root(m.P) for m in self.members)

    @cached_property
    def system(self) -> Plant:
        """The block system with inputs (u, y) and the residuals of all members as outputs."""
        F = np.asarray(block_diag(*(m.F for m in self.members)))
        enter = np.vstack([np.hstack([m.G, m.K]) for m in self.members])
        read = np.asarray(block_diag(*(-m.whiten @ m.C for m in self.members)))
        direct = np.vstack([m.whiten @ np.hstack([-m.M, m.N]) for m in self.members])
        return Plant(F, enter, read, direct, self.model.dt or 1.0)

    @gated(x0=array(), rng=optional(GENERATOR))
    def start(self, x0: object, *, rng: np.random.Generator | None = None) -> np.ndarray:
        """States of the block system for the true state x0 (n,): exact, or with errors drawn from each steady covariance.

        With drawn errors every residual is white from the first sample on, as if the bank had been running for ever. One
        draw of n numbers serves all members.
        """
        x = as_matrix(x0, "x0").ravel()
        if x.size != self.model.n:
            raise ShapeError("x0 must have {n} entries; it has {x_size}.", n=self.model.n, x_size=x.size)
        xi = np.zeros(self.model.n) if rng is None else rng.standard_normal(self.model.n)
        return np.concatenate([m.project @ x - spread @ xi[:m.size] for m, spread in zip(self.members, self._spreads, strict=True)])

    @gated(y=RECORD, u=array(), start=array())
    def run(self, y: object, u: object, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals (n_t, members, q) and states (n_t, N) for records y (n_t, p), u (n_t, m).

        Each row of u is held from its sample on. Raises ShapeError.
        """
        s, y = self.system, as_record(y, "y", len(self.model.C))
        known = np.hstack([as_record(u, "u", self.model.B.shape[1], rows=len(y)), y])
        start = np.ravel(start)
        if np.size(start) != s.n:
            raise ShapeError("The start must have {n} entries; it has {start}.", n=s.n, start=np.size(start))
        states = held_scan(s.A, s.B, known[:-1], start)
        residuals = states @ s.C.T + known @ np.asarray(s.D).T
        return residuals.reshape(len(known), len(self.members), self.dof), states

    @gated(z=COMPLEX)
    def response(self, z: complex) -> np.ndarray:
        """What a fault zᵏ adds to the residuals, (members, q, p + m): of each sensor, then of each input (missing part).

        The bank is told the input that was asked for, so that a missing part of it shows as −B d in the plant alone.
        """
        s, m, p = self.system, self.model.B.shape[1], len(self.model.C)
        if min(np.abs(z - poles).min(initial=np.inf) for poles in (s.poles, np.linalg.eigvals(self.model.A))) < 1e-12:
            raise EngineError("z = {z} is a pole of the plant or of the bank, where there is no response; take "
                              "another.",
                              z=pole_text(z))
        of_y = s.C @ np.linalg.solve(z * np.eye(s.n) - s.A, s.B[:, m:]) + np.asarray(s.D)[:, m:]
        plant = self.model.C @ np.linalg.solve(z * np.eye(self.model.n) - self.model.A, self.model.B) + self.model.D
        return np.hstack([of_y, -of_y @ plant]).reshape(len(self.members), self.dof, p + m)

    @cached_property
    def signature(self) -> np.ndarray:
        """Which member sees which fault, bool (members, p + m): sensors, then inputs, by the response at several z."""
        size = np.max([np.linalg.norm(self.response(np.exp(1j * angle)), axis=1) for angle in (0.11, 0.7, 1.9)], axis=0)
        return size > SEEN_SHARE * size.max(axis=0)


@takes(alarms=array(), signature=array())
def isolate(alarms: object, signature: object) -> np.ndarray:
    """Which fault the alarms speak of, int (n_t,): its column, −1 without any alarm, −2 where no single column fits.

    alarms bool (n_t, members), signature bool (members, faults). Raises ShapeError.
    """
    alarms, signature = np.asarray(alarms, dtype=bool), np.asarray(signature, dtype=bool)
    if alarms.ndim != 2 or signature.ndim != 2 or alarms.shape[1] != len(signature):
        raise ShapeError("Alarms must be (n_t, members) and signatures (members, faults); they are {alarms_shape} "
                         "and {signature_shape}.",
                         alarms_shape=alarms.shape, signature_shape=signature.shape)
    fits = (alarms[:, :, None] == signature[None]).all(axis=1)
    single = fits.sum(axis=1) == 1
    return np.where(single, fits @ np.arange(fits.shape[1]), np.where(alarms.any(axis=1), UNCLEAR_FAULT, NO_FAULT))
