"""Run affine recursions z⁺ = Φ z + g in parallel blocks."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from ..kernels import as_kernel_array, compiled_kernel
from ..kernels.scan import scan_steps
from .gates.argument_checks import FINITE, MOST_NUMBERS, array, count, matrix, optional, takes, vector

__all__ = ["affine_scan", "held_scan", "step_matrices"]

SHORT_SCAN_STEPS = 24  # below this many steps a plain loop is faster
BLOCK_STEPS = 16
NARROW, SLIM = 48, 20  # states for which the kernel's steps are quicker than products of blocks, and than those of few inputs
HELD_BLOCK_STEPS = 8  # steps a block where the forcing comes from few inputs


@takes(M=matrix("N N"), duration=FINITE)
def step_matrices(M: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Φ = e^{M h} and Φ₁ = ∫₀ʰ e^{M s} ds, both N×N, from one exponential of [M I; 0 0] h."""
    N = len(M)
    block = np.zeros((2 * N, 2 * N))
    block[:N, :N] = M * duration
    block[:N, N:] = np.eye(N) * duration
    with np.errstate(over="ignore", invalid="ignore"):  # an overflow shows as inf and ends the run
        power = expm(block)
    return power[:N, :N], power[:N, N:]


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
        if steps < SHORT_SCAN_STEPS or 2 * q > N or (N <= SLIM and compiled_kernel(scan_steps) is not None):
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
    quick = compiled_kernel(scan_steps) if len(z0) <= NARROW else None
    if quick is not None:
        quick(as_kernel_array(Phi.T), as_kernel_array(forcing), states)
        return states
    for k, push in enumerate(forcing):
        states[k + 1] = z = Phi @ z + push
    return states


def _doubling(Phi: np.ndarray, z0: np.ndarray, steps: int) -> np.ndarray:
    states = np.empty((steps + 1, len(z0)))
    states[0] = z0
    done, power = 1, Phi.T
    while done <= steps:
        count = min(done, steps + 1 - done)
        np.matmul(states[:count], power, out=states[done:done + count])
        done += count
        if done <= steps:
            power = power @ power
    return states


def _blocks(Phi: np.ndarray, forcing: np.ndarray, z0: np.ndarray) -> np.ndarray:
    """One by one where the kernel makes that quick, else in two passes: every block from zero at once, the block ends among
    themselves, then add what each start gives."""
    steps, N = forcing.shape
    if steps < SHORT_SCAN_STEPS or (N <= NARROW and compiled_kernel(scan_steps) is not None):
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
