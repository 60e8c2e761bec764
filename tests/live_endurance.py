"""A running plant beside `live` for a long time: nothing is lost but what the plant leaves out, memory is flat, each estimate has its bits.

`python tests/live_endurance.py [--seconds 600] [LESSON]` runs the compiled plant at 100 Hz or more, with 1 % of its lines lost and 5 %
late, into `live --stdin`. It prints lines, lost periods, differing bits against the compiled step on the recorded file, and memory.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from device_bodies import STRICT, write_files

from observer_lab.devices import Routine, watching
from observer_lab.engine.systems import discretise
from observer_lab.export.devices.c_project import lab_c, lab_h, simulator_files
from observer_lab.export.devices.folders import device_design
from observer_lab.lessons import LESSONS
from observer_lab.live.simulated import simulated

LOST, JITTER, SLOWEST_S, KNOCKS = 0.01, 0.05, 0.01, 400
LIVE = ("import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "  # also where these tests run behind a shell's `&`
        "signal.signal(getattr(signal, 'SIGHUP', signal.SIGTERM), signal.SIG_DFL); "  # or under `nohup`
        "from observer_lab.cli import main; raise SystemExit(main())")
BEGUN = 0.2  # share of the run after which memory is compared with that at the end
REPLAY = """
#include <stdio.h>
#include <stdlib.h>
#include "lab.h"
int main(void) {
    double y[LAB_P], u[LAB_M];
    int i;
    lab_init();
    for (;;) {
        for (i = 0; i < LAB_M; i++) if (scanf("%lf", u + i) != 1) return 0;
        for (i = 0; i < LAB_P; i++) if (scanf("%lf", y + i) != 1) return 1;
        lab_step(y, u);
        for (i = 0; i < LAB_N; i++) printf("%a ", lab_xhat[i]);
        putchar('\\n');
    }
}
"""


def replayed(folder: Path, routine: Routine, rows: np.ndarray) -> np.ndarray:
    """The estimates of the compiled `lab_step` for the rows of a record, (N, n).

    What the times of a record say: a period without a row is a missing reading under the last input.
    """
    watched, m = watching(routine), len(routine.u_names)
    steps: list[Sequence[float]] = []
    due, kept = rows[0, 0], list[int]()
    for t, *values in rows.tolist():
        gap = round((t - due) / routine.period)
        for _ in range(gap):
            steps.append([*steps[-1][:m], *[float("nan")] * len(routine.y_names)])
        due += (gap + 1) * routine.period
        kept.append(len(steps))
        steps.append(values)
    write_files(folder, {"lab.h": lab_h(watched, False), "lab.c": lab_c(watched, False), "replay.c": REPLAY})
    subprocess.run(["gcc", "-O3", *STRICT, "-o", "replay", "replay.c", "lab.c", "-lm"], cwd=folder, check=True)
    said = subprocess.run([str(folder / "replay")], input="\n".join(" ".join(map(repr, map(float, row))) for row in steps),
                          capture_output=True, text=True, check=True).stdout.splitlines()
    return np.array([[float.fromhex(v) for v in row.split()] for row in said])[kept]


def resident(pid: int) -> float:
    """Memory of a process in MB."""
    return int(Path(f"/proc/{pid}/status").read_text().partition("VmRSS:")[2].split()[0]) / 1024


@dataclass(frozen=True)
class Endurance:
    """What came of a run: periods, lines that the plant says, rows recorded, lost periods that `live` counts, its memory in MB.

    `differing` counts estimates that are not those of the compiled step on the record, `wrong_rows` rows that are not the plant's lines.
    """

    period: float
    periods: int
    lines: int
    rows: int
    said: str
    differing: int
    wrong_rows: int
    memory: tuple[float, ...]

    @property
    def growth(self) -> float:
        """Memory at the end less that after the beginning, in MB."""
        return self.memory[-1] - self.memory[int(BEGUN * len(self.memory))]


def endure(name: str, seconds: float, folder: Path) -> Endurance:
    """Run a lesson's plant beside `live` for so long."""
    lesson = LESSONS[name]
    outcome = lesson.compute(lesson.start())
    assert outcome.run is not None
    s = outcome.run.scenario
    T = s.dt * max(1, int(SLOWEST_S / s.dt))
    design, count = device_design(lesson, outcome, T), int(seconds / T)
    files = simulator_files(design, discretise(s.plant, T), s.x0)
    spoken = b""
    with simulated(files, count, lost=LOST, jitter=JITTER, paced=False, knocks=KNOCKS) as source:
        while (data := source(5.0)) is not None:
            spoken += data
    lines = [line for line in spoken.splitlines() if not line.startswith(b"#")]
    env = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    memory, looked = list[float](), time.monotonic()
    with (folder / "estimates.jsonl").open("wb") as out:
        process = subprocess.Popen([sys.executable, "-c", LIVE, "live", name, "--stdin", "--ts", repr(T), "--json", "--record", "run.csv"],
                                   cwd=folder, env=env, stdin=subprocess.PIPE, stdout=out, stderr=subprocess.PIPE)
        assert process.stdin is not None
        with simulated(files, count, lost=LOST, jitter=JITTER, knocks=KNOCKS) as source:
            while (data := source(5.0)) is not None:
                process.stdin.write(data)
                process.stdin.flush()
                if time.monotonic() - looked >= 1.0 and (folder / "estimates.jsonl").stat().st_size:  # it has begun
                    memory.append(resident(process.pid))
                    looked = time.monotonic()
        _, said = process.communicate(timeout=120)
    rows = np.loadtxt(folder / "run.csv", delimiter=",", skiprows=1, ndmin=2)
    told = np.array([json.loads(line)["xhat"] for line in (folder / "estimates.jsonl").read_text().splitlines()])
    plant = np.array([[float(v) for v in line.split(b",")] for line in lines])
    wrong = len(plant) if plant.shape != rows.shape else int(np.any(plant != rows, axis=1).sum())
    differing = int(np.any(replayed(folder, design.routine, rows) != told, axis=1).sum()) if len(told) == len(rows) else len(rows)
    return Endurance(T, count, len(lines), len(rows), said.decode().strip(), differing, wrong, tuple(memory))


def main() -> int:
    """Print the figures of one run."""
    parser = argparse.ArgumentParser()
    parser.add_argument("lesson", nargs="?", default="arm")
    parser.add_argument("--seconds", type=float, default=600.0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = endure(options.lesson, options.seconds, Path(folder))
    print(f"{options.lesson}: {found.periods} periods of {found.period:.4g} s; {found.lines} lines of the plant, {found.rows} recorded, "
          f"{found.wrong_rows} of them others than the plant's")
    print(f"live says: {found.said}")
    print(f"estimates with other bits than lab_step on the record: {found.differing}; memory {found.memory[0]:.1f} → "
          f"{found.memory[-1]:.1f} MB, {found.growth:+.2f} MB after the first fifth")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
