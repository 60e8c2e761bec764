"""The engine beside its peers in one run, as Markdown: `python tests/benchmarks/all.py [loops] [filters] [designs] [daily] [drafts]`.

Medians of processor seconds, so that a busy machine hardly counts; ratios are what counts, machines differ.
Without names all but the drafts of the lessons, which take some minutes more (`bench_drafts.py` prints those of chosen ones).
"""

# ruff: noqa: E402 — the thread limits must be set before numpy is imported
from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import platform as machine
import sys
import time
import warnings
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import bench_daily
import bench_designs
import bench_drafts
import bench_filters
import bench_loops
from stopwatch import HEAD

from observer_lab.engine.kernels import COMPILE_CACHE, kernels_off

PARTS = {"loops": bench_loops.rows, "filters": bench_filters.rows, "designs": bench_designs.rows,
         "daily": bench_daily.rows}
PEERS = ("numpy", "scipy", "control", "slycot", "filterpy", "statsmodels", "numba")


def versions() -> str:
    """What this run stands on."""
    found = [f"Python {machine.python_version()}"]
    for name in PEERS:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"no {name}")
    return ", ".join(found)


def main(names: list[str]) -> None:
    """Print the table of the parts named."""
    warnings.simplefilter("ignore")
    compiled = not kernels_off() and COMPILE_CACHE.fill()
    print(f"{time.strftime('%Y-%m-%d')}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the start; {versions()}; "
          f"kernels {'compiled' if compiled else 'plain'}.\n\n{HEAD}", flush=True)
    met, missed = 0, list[str]()
    for name, rows in PARTS.items():
        if names and name not in names:
            continue
        for row in rows():
            print(row.markdown(), flush=True)
            met += row.met is True
            if row.met is False:
                missed.append(f"- {row.work.strip()}: {row.limit or 'see its profile'}.")
    print(f"\nGoals met: {met}; missed: {len(missed)}, and what limits these by their profiles:\n", *dict.fromkeys(missed), sep="\n")
    if "drafts" in names:
        print("\nDrafts of the lessons:\n")
        bench_drafts.main([])


if __name__ == "__main__":
    main(sys.argv[1:])
