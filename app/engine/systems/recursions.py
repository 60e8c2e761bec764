"""Run affine recursions z⁺ = Φ z + g in parallel blocks."""

from __future__ import annotations

from math import factorial

import numpy as np
from scipy.linalg import expm
from scipy.linalg.lapack import dgebal  # pyright: ignore[reportAttributeAccessIssue]

from .balance import UNLIKE
from .gates.argument_checks import FINITE, MOST_NUMBERS, array, count, matrix, optional, takes, vector

__all__ = ["affine_scan", "held_scan", "step_matrices"]

LARGE = 48  # states from which a step is made by doubling: one exponential of twice the size takes longer
SHORT_SCAN_STEPS = 24  # below this many steps a plain loop is faster
BLOCK_STEPS = 16
TAYLOR = np.array([[1 / factorial(k + 1) for k in range(first, first + 4)] for first in (0, 4, 8)])  # of Φ₁/h, in rows of four
HELD_BLOCK_STEPS = 8  # steps a block where the forcing comes from few inputs


@takes(M=matrix("N N"), duration=FINITE)
def step_matrices(M: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Φ = e^{M h} and Φ₁ = ∫₀ʰ e^{M s} ds, both N×N, from one exponential of [M I; 0 0] h, in like units where those of M are unlike."""
    N = len(M)
    if N >= LARGE:
        if (half := _apart(M)) and np.array_equal(M[:half, :half], M[half:, half:]):
            return tuple(np.kron(np.eye(2), part) for part in step_matrices(M[:half, :half], duration))  # type: ignore[return-value]
        return step_by_doubling(M, np.eye(N), duration)
    x = dgebal(M, scale=1, permute=0)[3] if N else np.ones(0)
    unlike = N > 0 and x.max() > UNLIKE * x.min()
    block = np.zeros((2 * N, 2 * N))
    block[:N, :N] = (M * x / x[:, None] if unlike else M) * duration
    block[:N, N:] = np.eye(N) * duration
    with np.errstate(over="ignore", invalid="ignore"):  # an overflow shows as inf and ends the run
        power = expm(block)
        Phi, Phi1 = power[:N, :N], power[:N, N:]
        return (Phi * x[:, None] / x, Phi1 * x[:, None] / x) if unlike else (Phi, Phi1)


def driven_step(M: np.ndarray, B: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """e^{M h} (N×N) and ∫₀ʰ e^{M s} ds B (N×m) of states and inputs in like units, from one exponential of [M B; 0 0] h."""
    N, m = B.shape
    block = np.zeros((N + m, N + m))
    block[:N, :N], block[:N, N:] = M, B
    with np.errstate(over="ignore", invalid="ignore"):
        power = expm(block * duration)
    return power[:N, :N], power[:N, N:]


def _apart(M: np.ndarray) -> int:
    """Half the states where the first half and the second do not act on each other, as a plant and a copy of it; else 0."""
    half = len(M) // 2
    return half if 2 * half == len(M) and not M[:half, half:].any() and not M[half:, :half].any() else 0


def step_by_doubling(M: np.ndarray, B: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """e^{M h} (N×N) and ∫₀ʰ e^{M s} ds B (N×m) of many states: Φ₁ by its Taylor series over h/2ˢ where ‖M‖h/2ˢ ≤ 1/4, Φ = I + M Φ₁,
    then Φ₁(2h) = Φ₁(h) + Φ(h) Φ₁(h). M is balanced first, so that its norm is near that of its rates.
    """
    even, _, _, scale, _ = dgebal(M * duration, scale=1, permute=0)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        size = float(np.linalg.norm(even, 1))
        doublings = max(0, int(np.ceil(np.log2(size))) + 2) if 0 < size < np.inf else 0
        powers = np.empty((3, *even.shape))
        X, squared, cube = powers
        np.multiply(even, 2.0**-doublings, out=X)
        np.matmul(X, X, out=squared)
        fourth = squared @ squared
        fewer = _steps_to_spare(fourth, doublings)
        doublings, X[:], squared[:], fourth = doublings - fewer, X * 2.0**fewer, squared * 4.0**fewer, fourth * 16.0**fewer
        np.matmul(X, squared, out=cube)
        low, middle, high = np.tensordot(TAYLOR[:, 1:], powers, 1)
        for part, first in zip((low, middle, high), TAYLOR[:, 0], strict=True):
            part.flat[::len(M) + 1] += first
        Phi1: np.ndarray = low + fourth @ (middle + fourth @ high)
        Phi: np.ndarray = X @ Phi1
        Phi.flat[::len(M) + 1] += 1.0
        Gamma: np.ndarray = Phi1 @ (B / scale[:, None] * (duration / 2.0**doublings))
        for _ in range(doublings):
            Gamma = Gamma + Phi @ Gamma
            Phi = Phi @ Phi
        return Phi * (scale[:, None] / scale), Gamma * scale[:, None]


def _steps_to_spare(fourth: np.ndarray, doublings: int) -> int:
    """How many doublings fewer keep ‖X⁴‖ below 4⁻⁴, which is what the series' remainder depends on; at most two, so that ‖X‖ ≤ 1.

    Source: Al-Mohy and Higham, "A new scaling and squaring algorithm for the matrix exponential" (2009)."""
    size = float(np.linalg.norm(fourth, 1))
    return min(2, doublings, max(0, int(np.floor(-np.log2(size) / 4)) - 2)) if 0 < size < np.inf else 0


@takes(Phi=matrix("N N"), forcing=optional(array("k N")), z0=vector("N"), steps=count(0, MOST_NUMBERS, beside="N"))
def affine_scan(Phi: np.ndarray, forcing: np.ndarray | None, z0: np.ndarray, steps: int) -> np.ndarray:
    """All states of z[k+1] = Φ z[k] + g[k], z[0] = z0: (steps + 1, N).

    `forcing` g is (steps, N) or None. States that overflow are inf or NaN, and so are those after them;
    the ones before are right.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        states = _doubling(Phi, z0, steps) if forcing is None else _blocks(Phi, forcing, z0)
        if not np.isfinite(states[-1]).all():  # an overflowing power may have spoilt earlier states of its block
            states = _one_by_one(Phi, np.zeros((steps, len(z0))) if forcing is None else forcing, z0)
    return states


@takes(Phi=matrix("N N"), Gamma=matrix("N q"), inputs=array("k q"), z0=vector("N"))
def held_scan(Phi: np.ndarray, Gamma: np.ndarray, inputs: np.ndarray, z0: np.ndarray) -> np.ndarray:
    """All states of z[k+1] = Φ z[k] + Γ u[k], z[0] = z0: (steps + 1, N) for inputs u (steps, q), Γ N×q, few inputs.

    One product [start, inputs of the block] · [powers of Φ; Toeplitz matrix of Φʲ Γ] gives all states of all blocks.
    """
    (steps, q), N = inputs.shape, len(Phi)
    with np.errstate(over="ignore", invalid="ignore"):
        if steps < SHORT_SCAN_STEPS or 2 * q > N:
            return affine_scan(Phi, inputs @ Gamma.T, z0, steps)
        count = -(-steps // HELD_BLOCK_STEPS)
        powers, answers = [Phi.T], [Gamma.T]
        for _ in range(HELD_BLOCK_STEPS - 1):
            powers.append(powers[-1] @ Phi.T)
            answers.append(answers[-1] @ Phi.T)
        table = np.zeros((N + HELD_BLOCK_STEPS * q, HELD_BLOCK_STEPS * N))
        table[:N] = np.hstack(powers)
        for i in range(HELD_BLOCK_STEPS):
            table[N + i * q:N + (i + 1) * q, i * N:] = np.hstack(answers[:HELD_BLOCK_STEPS - i])
        rows = np.zeros((count, N + HELD_BLOCK_STEPS * q))
        whole = steps // HELD_BLOCK_STEPS
        rows[:whole, N:] = inputs[:whole * HELD_BLOCK_STEPS].reshape(whole, HELD_BLOCK_STEPS * q)
        rows[whole:, N:N + (steps - whole * HELD_BLOCK_STEPS) * q] = inputs[whole * HELD_BLOCK_STEPS:].ravel()
        rows[:, :N] = _blocks(powers[-1].T, rows[:, N:] @ table[N:, -N:], z0)[:-1]
        states = np.empty((count * HELD_BLOCK_STEPS + 1, N))
        states[0] = z0
        np.matmul(rows, table, out=states[1:].reshape(count, HELD_BLOCK_STEPS * N))
        states = states[:steps + 1]
        return states if np.isfinite(states[-1]).all() else _one_by_one(Phi, inputs @ Gamma.T, z0)


def _one_by_one(Phi: np.ndarray, forcing: np.ndarray, z0: np.ndarray) -> np.ndarray:
    states = np.empty((len(forcing) + 1, len(z0)))
    states[0] = z = z0
    for k, push in enumerate(forcing):
        states[k + 1] = z = Phi @ z + push
    return states


def _doubling(Phi: np.ndarray, z0: np.ndarray, steps: int) -> np.ndarray:
    if len(z0) >= LARGE and (half := _apart(Phi)):
        if np.array_equal(Phi[:half, :half], Phi[half:, half:]):  # a plant and a copy of it need each power once
            return _powers(Phi[:half, :half], z0.reshape(2, half), steps).reshape(steps + 1, -1)
        return np.hstack([_doubling(Phi[:half, :half], z0[:half], steps), _doubling(Phi[half:, half:], z0[half:], steps)])
    return _powers(Phi, z0[None], steps)


def _powers(Phi: np.ndarray, starts: np.ndarray, steps: int) -> np.ndarray:
    """The states of each step from r starts (r, N) one below the other: ((steps + 1) r, N)."""
    r, N = starts.shape
    states = np.empty(((steps + 1) * r, N))
    states[:r] = starts
    done, end, power = r, len(states), Phi.T
    while done < end:
        count = min(done, end - done)
        np.matmul(states[:count], power, out=states[done:done + count])
        done += count
        if done < end and done >= LARGE * r and N >= LARGE:  # a further power costs more than products with this one
            for k in range(done, end, count):
                last = min(k + count, end)
                np.matmul(states[k - count:last - count], power, out=states[k:last])
            break
        if done < end:
            power = power @ power
    return states


def _blocks(Phi: np.ndarray, forcing: np.ndarray, z0: np.ndarray) -> np.ndarray:
    """In two passes: every block from zero at once, the block ends among themselves, then add what each start gives."""
    steps, N = forcing.shape
    if steps < SHORT_SCAN_STEPS:
        return _one_by_one(Phi, forcing, z0)
    count = -(-steps // BLOCK_STEPS)
    if steps == count * BLOCK_STEPS:
        push = forcing.reshape(count, BLOCK_STEPS, N)
    else:
        push = np.zeros((count, BLOCK_STEPS, N))
        push.reshape(-1, N)[:steps] = forcing
    local, powers, product = np.empty((BLOCK_STEPS, count, N)), np.empty((BLOCK_STEPS, N, N)), np.empty((count, N))
    local[0], powers[0], step = push[:, 0], Phi.T, np.ascontiguousarray(Phi.T)
    for j in range(1, BLOCK_STEPS):
        np.matmul(local[j - 1], step, out=product)
        np.add(product, push[:, j], out=local[j])
        np.matmul(powers[j - 1], step, out=powers[j])
    starts = np.ascontiguousarray(_blocks(powers[-1].T, local[-1], z0)[:-1])
    states = np.empty((count * BLOCK_STEPS + 1, N))
    states[0] = z0
    path = states[1:].reshape(count, BLOCK_STEPS, N)
    for j in range(BLOCK_STEPS):
        np.matmul(starts, powers[j], out=product)
        np.add(product, local[j], out=path[:, j])
    return states[:steps + 1]
