"""Simulate the healthy bank of lesson 17, fit the mean number of samples to a false alarm, print `run_length_table.py`.

`python tests/benchmarks/run_lengths.py [MILLIONS [SEED [FILE.npz]]]` simulates millions of samples, 100 unless told; with names of such
files in place of these it puts them together. A window is tested at every sample; after
an alarm it is emptied and counting starts again, for each member by itself and for the bank as a whole.
"""

from __future__ import annotations

import sys

import numpy as np
from numba import njit
from scipy.linalg import block_diag, cholesky
from scipy.stats import chi2

from observer_lab.lessons.fault_diagnosis.observer_bank import guard, model

WINDOWS = (1, 2, 3, 5, 8, 12, 18, 25, 37, 55, 80, 115, 150)
RATES = 10.0 ** -np.arange(1.0, 6.01, 0.5)
CHAINS, STEPS, SETTLING = 400, 250, 4


def system() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """z⁺ = F z + G n, ρ = H z + J n for z = (x, states of the bank) and white n of unit covariance; no force is commanded."""
    kf, bank = model(), guard().bank.system
    m, n = kf.B.shape[1], len(kf.A)
    noise = block_diag(_root(kf.Q), cholesky(kf.R, lower=True))
    to_x, to_y = noise[:n], noise[n:]
    By, Dy = bank.B[:, m:], np.asarray(bank.D)[:, m:]
    F = np.block([[kf.A, np.zeros((n, len(bank.A)))], [By @ kf.C, bank.A]])
    return F, np.vstack([to_x, By @ to_y]), np.hstack([Dy @ kf.C, bank.C]), Dy @ to_y


def _root(Q: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(Q)
    return vectors * np.sqrt(np.maximum(values, 0))


@njit(fastmath=True)
def count(rho, ring, at, energy, total, last_of, last_all, found, windows, limits):
    """Count alarms and samples with a full window: rho (steps, chains, 7, 3), limits (2, windows, rates) ascending.

    found (4, 2, windows, rates): full of members and of the bank, alarms of members and of the bank.
    """
    steps, chains, members, q = rho.shape
    size = ring.shape[0]
    for c in range(chains):
        for k in range(steps):
            time = at + k
            now = time % size
            ring[now, c] = rho[k, c]
            for i in range(len(windows)):
                N = windows[i]
                old = (time - N) % size
                top = np.zeros(2)
                for m in range(members):
                    change, mean = 0.0, 0.0
                    for j in range(q):
                        new, gone = ring[now, c, m, j], ring[old, c, m, j]
                        change += new * new - gone * gone
                        total[i, c, m, j] += new - gone
                        mean += total[i, c, m, j] ** 2
                    energy[i, c, m] += change
                    for s in range(2):
                        value = energy[i, c, m] if s == 0 else mean / N
                        top[s] = max(top[s], value)
                        for r in range(limits.shape[2]):
                            if value <= limits[s, i, r]:
                                break
                            full = time - last_of[s, i, r, c, m] - (N - 1)
                            if full > 0:
                                found[0, s, i, r] += full
                                found[2, s, i, r] += 1
                                last_of[s, i, r, c, m] = time
                for s in range(2):
                    for r in range(limits.shape[2]):
                        if top[s] <= limits[s, i, r]:
                            break
                        full = time - last_all[s, i, r, c] - (N - 1)
                        if full > 0:
                            found[1, s, i, r] += full
                            found[3, s, i, r] += 1
                            last_all[s, i, r, c] = time


def simulated(millions: float, seed: int) -> np.ndarray:
    """Samples with a full window of members and of the bank, alarms of members and of the bank: (4, 2 statistics, windows, rates)."""
    F, G, H, J = system()
    rng, windows = np.random.default_rng(seed), np.array(WINDOWS)
    shape = (2, len(WINDOWS), len(RATES))
    limits = np.array([[chi2.isf(RATES, 3 * N) for N in WINDOWS], [chi2.isf(RATES, 3)] * len(WINDOWS)])
    z, ring = np.zeros((CHAINS, len(F))), np.zeros((max(WINDOWS) + 1, CHAINS, 7, 3))
    energy, total = np.zeros((len(WINDOWS), CHAINS, 7)), np.zeros((len(WINDOWS), CHAINS, 7, 3))
    last_of, last_all = np.full((*shape, CHAINS, 7), -1), np.full((*shape, CHAINS), -1)
    found, rho, at = np.zeros((4, *shape), dtype=np.int64), np.empty((STEPS, CHAINS, 7, 3)), 0
    for block in range(SETTLING + round(millions * 1e6 / (CHAINS * STEPS))):
        for k in range(STEPS):
            n = rng.standard_normal((CHAINS, G.shape[1]))
            rho[k] = (z @ H.T + n @ J.T).reshape(CHAINS, 7, 3)
            z = z @ F.T + n @ G.T
        if block >= SETTLING:
            count(rho, ring, at, energy, total, last_of, last_all, found, windows, limits)
            at += STEPS
    N = windows[:, None, None]  # what has run since the last alarm counts too
    found[0] += np.maximum(at - 1 - last_of - (N[..., None] - 1), 0).sum(axis=(3, 4))
    found[1] += np.maximum(at - 1 - last_all - (N - 1), 0).sum(axis=3)
    return found


def fitted(full: np.ndarray, alarms: np.ndarray, each: float) -> np.ndarray:
    """Per window the coefficients of log(α · samples to an alarm with a full window) over log₁₀ α + 3.5, (2, windows, 5).

    `each`: the standard deviation of a count, over its root: alarms of members that share sensors come together.
    """
    V, out = np.vander(np.log10(RATES) + 3.5, 5, increasing=True), []
    for s in range(2):
        for i in range(len(WINDOWS)):
            good = alarms[s, i] > 10
            G = np.log(full[s, i][good] / alarms[s, i][good] * RATES[good])
            weight = 1 / np.hypot(0.003, each / np.sqrt(alarms[s, i][good]))
            out.append(np.linalg.lstsq(V[good] * weight[:, None], G * weight, rcond=None)[0])
    return np.reshape(out, (2, len(WINDOWS), 5))


def main() -> None:
    """Simulate or read what was simulated, and print the tables."""
    if sys.argv[1:] and sys.argv[1].endswith(".npz"):
        found = np.sum([np.load(name)["arr_0"] for name in sys.argv[1:]], axis=0)
    else:
        found = simulated(float(sys.argv[1]) if len(sys.argv) > 1 else 100.0, int(sys.argv[2]) if len(sys.argv) > 2 else 1)
        if len(sys.argv) > 3:
            np.savez(sys.argv[3], found)
    for name, full, alarms, each in (("MEMBER", found[0], found[2], 1.5), ("BANK", found[1], found[3], 1.0)):
        for kind, rows in zip(("ENERGY", "MEAN"), fitted(full, alarms, each), strict=True):
            print(f"{name}_{kind} = (")
            for row in rows:
                print("    (" + ", ".join(f"{v:.4f}" for v in row) + "),")
            print(")")


if __name__ == "__main__":
    main()
