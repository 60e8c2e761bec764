"""Studies as a person runs them: the same bits by one process, by two, by a real Dask cluster and after a kill, and what each takes.

    python tests/benchmarks/studies.py

Each study runs as `observer-lab study` in a process of its own. The cluster is Dask's own on this machine: a scheduler and two
worker processes; it needs `python -m pip install 'observer-lab[study]'`. One run is killed, one is interrupted, as by Ctrl-C, and
both go on. Verdict lines say what must hold; the exit status is 1 if one does not.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).parents[2]
STUDIES = {
    "recovery map, 21×21": {"lesson": "saturation", "collect": ["check.home", "stopped_at"],
                            "vary": {"angle0": {"from": -16, "to": 16, "count": 21}, "error0": {"from": -8, "to": 8, "count": 21}}},
    "Monte-Carlo, 5×60": {"lesson": "kalman", "seeds": 60, "collect": ["nis_mean", "nees_mean", "check.nis"],
                           "vary": {"q": {"from": 0.1, "to": 10, "count": 5}}},
    "own plant, 9×9": {"lesson": "noise", "plant": "motor", "collect": ["floor", "rms"],
                         "vary": {"A(3,4)": {"from": -2, "to": -0.5, "count": 9},
                                  "inertia": {"from": 0.5, "to": 2, "count": 9, "scale": "log",
                                              "over": ["A(2,1)", "A(2,2)", "A(2,3)", "A(2,4)"]}}},
}
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [str(HERE), os.environ.get("PYTHONPATH", "")])),
               **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")}


def begin(study: Path, out: Path, *words: str) -> subprocess.Popen[str]:
    """The command, begun."""
    return subprocess.Popen([sys.executable, "-m", "observer_lab", "study", str(study), "-o", str(out), *words], cwd=HERE, env=ENVIRONMENT,
                            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def whole(study: Path, out: Path, *words: str) -> tuple[float, bytes, str]:
    """Seconds that the command took, its table and what it said on stderr."""
    began = time.monotonic()
    process = begin(study, out, *words)
    _, told = process.communicate()
    if process.returncode:
        raise SystemExit(told)
    return time.monotonic() - began, (out / "runs.csv").read_bytes() + (out / "study.json").read_bytes(), told


def stopped(study: Path, out: Path, ending: signal.Signals) -> tuple[int, int, list[int], str]:
    """Status and done lines of a run on two processes that is ended on its way, its children that live on, what it said."""
    process = begin(study, out, "--workers", "2")
    record = out / "runs.txt"
    while process.poll() is None and not (record.exists() and record.read_bytes().count(b"\n") > 6):
        time.sleep(0.01)
    children = [int(child) for child in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()]
    process.send_signal(ending)
    _, told = process.communicate()
    end = time.monotonic() + 20
    while (living := [child for child in children if _lives(child)]) and time.monotonic() < end:
        time.sleep(0.05)
    return process.returncode, record.read_bytes().count(b"\n"), living, told


def _lives(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def main() -> None:
    """Print the table and the verdicts."""
    argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0]).parse_args()
    os.environ.update(ENVIRONMENT)  # what the cluster's processes start with
    from distributed import LocalCluster  # type: ignore[import-not-found]

    verdicts: list[tuple[str, bool]] = []
    cluster: Any = LocalCluster(n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None)
    print("| study | runs | one process [s] | two processes [s] | Dask, two workers [s] |\n|---|---|---|---|---|")
    with cluster, tempfile.TemporaryDirectory() as folder:
        top = Path(folder)
        for k, (name, given) in enumerate(STUDIES.items()):
            study = top / f"{k}.json"
            study.write_text(json.dumps(given))
            one, two, dask = (whole(study, top / f"{k}-{kind}", *words) for kind, words in (
                ("one", ("--workers", "1")), ("two", ("--workers", "2")), ("dask", ("--scheduler", cluster.scheduler_address))))
            print(f"| {name} | {len(json.loads((top / f'{k}-one' / 'study.json').read_text())['rows'])} | {one[0]:.1f} | {two[0]:.1f} "
                  f"| {dask[0]:.1f} |", flush=True)
            verdicts += [(f"{name}: two processes give the same bytes as one", one[1] == two[1]),
                         (f"{name}: the cluster gives the same bytes as one", one[1] == dask[1])]
            if k == 0:
                for ending in (signal.SIGKILL, signal.SIGINT):
                    out = top / ending.name
                    status, lines, living, told = stopped(study, out, ending)
                    resumed = whole(study, out, "--workers", "2")
                    verdicts += [(f"{ending.name} after {lines - 1} chunks (status {status}) leaves no process behind", not living),
                                 (f"{ending.name}: the same command goes on ({resumed[2].splitlines()[0]}) to the same bytes",
                                  resumed[1] == one[1] and "done already" in resumed[2])]
                    if ending is signal.SIGINT:
                        verdicts.append((f"Ctrl-C says how to go on ({told.splitlines()[-1]})", "goes on from there" in told and
                                         "Traceback" not in told))
    for words, holds in verdicts:
        print(f"{'holds' if holds else 'FAILS'}  {words}")
    sys.exit(not all(holds for _, holds in verdicts))


if __name__ == "__main__":
    main()
