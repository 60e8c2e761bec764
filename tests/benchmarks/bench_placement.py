"""Placement and Riccati equations beside scipy and python-control: `python tests/benchmarks/bench_placement.py`.

Prints a markdown table: medians in milliseconds, the ratio peer/ours measured in the same run, and for placement the
ratio of the eigenvector condition numbers ours/peer. Ratios are what counts; machines differ. One thread.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
import time
import warnings
from pathlib import Path

import control
import numpy as np
from scipy.linalg import solve_continuous_are, solve_discrete_are
from scipy.signal import place_poles

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from app.engine import Plant, closed_loop, dlqr, lqe, lqr, observer_gain, place

CASES = 12
# scipy stops YT at a relative change of 1e-3, on random plants after 3 or 4 sweeps; "YT30" is YT left to its limit of 30
PEERS = {
    "YT": {"method": "YT"},
    "YT30": {"method": "YT", "rtol": 1e-9, "maxiter": 30},
    "KNV0": {"method": "KNV0"},
}
HEAD = ("| work | ours ms | peer | peer ms | peer/ours | κ ours/peer median (worst) |", "|---|---|---|---|---|---|")


def random_case(seed, n, m, pairs):
    rng = np.random.default_rng(seed)
    upper = -rng.uniform(1, 5, pairs) + 1j * rng.uniform(1, 5, pairs)
    poles = np.concatenate([-rng.uniform(1, 8, n - 2 * pairs), upper, upper.conj()])
    return rng.standard_normal((n, n)), rng.standard_normal((n, m)), poles


def milliseconds(call, repeats):
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


def condition(A, B, K):
    return np.linalg.cond(np.linalg.eig(A - B @ K)[1])


def placement_row(n, m, pairs, method):
    """Medians over random plants; each plant is timed for both parties, one after the other."""
    ours, theirs, ratios = [], [], []
    for seed in range(CASES):
        A, B, poles = random_case(seed, n, m, pairs)
        ours.append(milliseconds(lambda A=A, B=B, poles=poles: place(A, B, poles), 7))
        theirs.append(milliseconds(lambda A=A, B=B, poles=poles: place_poles(A, B, poles, **PEERS[method]), 1))
        peer = place_poles(A, B, poles, **PEERS[method]).gain_matrix
        ratios.append(condition(A, B, place(A, B, poles).gain) / condition(A, B, peer))
    kind = f"{pairs} pairs" if pairs else "real poles"
    quality = f"{np.median(ratios):.2f} ({max(ratios):.2f})" if m > 1 else "unique K"
    return row(f"place n = {n}, m = {m}, {kind}", np.median(ours), f"scipy {method}", np.median(theirs), quality)


def row(work, ours, peer, theirs, note=""):
    return f"| {work} | {ours:.2f} | {peer} | {theirs:.2f} | {theirs / ours:.1f} | {note} |"


def riccati_rows(n=10, m=3):
    A, B, _ = random_case(1, n, m, 0)
    Q, R = np.eye(n), np.eye(m)
    ours, ours_d = milliseconds(lambda: lqr(A, B, Q, R), 40), milliseconds(lambda: dlqr(A, B, Q, R), 40)
    yield row(f"lqr n = {n}", ours, "scipy CARE alone", milliseconds(lambda: solve_continuous_are(A, B, Q, R), 40))
    yield row(f"lqr n = {n}", ours, "control.lqr", milliseconds(lambda: control.lqr(A, B, Q, R, method="scipy"), 40))
    yield row(f"dlqr n = {n}", ours_d, "scipy DARE alone", milliseconds(lambda: solve_discrete_are(A, B, Q, R), 40))
    theirs = milliseconds(lambda: control.dlqr(A, B, Q, R, method="scipy"), 40)
    yield row(f"dlqr n = {n}", ours_d, "control.dlqr", theirs)
    theirs = milliseconds(lambda: control.lqe(A, B, B.T, R, R, method="scipy"), 40)
    yield row(f"lqe n = {n}", milliseconds(lambda: lqe(A, B, B.T, R, R), 40), "control.lqe", theirs)


def scale_row():
    """How many of the common factors 1e-30 … 1e12 of Q and R leave the gain as it is, to six digits."""
    A, B, _ = random_case(2, 10, 3, 0)
    Q, R, factors = np.eye(10), np.eye(3), (1e-30, 1e-24, 1e-18, 1e-12, 1e-6, 1e6, 1e12)

    def survived(gain):
        plain, count = gain(Q, R), 0
        for factor in factors:
            try:
                count += bool(np.allclose(gain(factor * Q, factor * R), plain, rtol=1e-6, atol=1e-6))
            except Exception:
                continue
        return count

    ours = survived(lambda Q, R: lqr(A, B, Q, R).gain)
    theirs = survived(lambda Q, R: control.lqr(A, B, Q, R, method="scipy")[0])
    return f"Common factors of Q and R survived, of {len(factors)}: ours {ours}, control.lqr {theirs}."


def main():
    warnings.simplefilter("ignore")
    print(*HEAD, sep="\n")
    for n, m, pairs in ((10, 3, 0), (10, 3, 3), (6, 3, 0), (6, 3, 2)):
        print(placement_row(n, m, pairs, "YT"), flush=True)
        print(placement_row(n, m, pairs, "YT30"), flush=True)
        if not pairs:  # scipy's KNV0 knows real poles only
            print(placement_row(n, m, pairs, "KNV0"), flush=True)
    print(placement_row(10, 1, 0, "YT"))
    print(*riccati_rows(), sep="\n")
    A, B, poles = random_case(1, 10, 3, 0)
    plant = Plant(A, B, B.T)
    K, L = place(A, B, poles).gain, observer_gain(A, B.T, 2 * poles).gain
    print(f"| closed_loop n = 10 | {milliseconds(lambda: closed_loop(plant, K, L), 40):.2f} | | | | |")
    print("\n" + scale_row())


if __name__ == "__main__":
    main()
