"""Right calls of the room in which a record becomes a filter."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from observer_lab.engine import Plant
from observer_lab.engine.identification import Record, identify, trend_of


def identification(dplant: Plant) -> dict[str, dict[str, Any]]:
    rng = np.random.default_rng(1)
    rows = 240
    u, y = rng.choice([-1.0, 1.0], rows), np.zeros(rows)
    for k in range(1, rows):
        y[k] = 0.8 * y[k - 1] + u[k - 1] + 0.1 * rng.standard_normal()
    t = 0.1 * np.arange(rows)
    record = Record(t, u, y)
    found = identify(record, order=1)
    plant = Plant([[0.8]], [[1.0]], [[1.0]], None, 0.1)
    text = "t [s],u [V],y [m]\n" + "".join(f"{a},{b},{c}\n" for a, b, c in zip(t, u, y, strict=True))
    path = Path(tempfile.mkdtemp()) / "record.csv"
    path.write_text(text, encoding="utf-8")
    said = {"step": None, "missing": ("-9999",), "decimal": ".", "hold": True}
    return {
        "Record": {"t": t, "u": u, "y": y, "input_names": ("u",), "output_names": ("y",), "units": (("u", "V"),), "notes": ()},
        "load_record": {"path": path, "time": "t", "inputs": ("u",), "outputs": ("y",), **said},
        "read_record": {"text": text, "time": "t", "inputs": ("u",), "outputs": ("y",), **said},
        "preview_record": {"name": "log.csv", "data": text.encode(), "time": "t", "inputs": ("u",), "outputs": ("y",), **said},
        "resample": {"record": record, "step": 0.2},
        "trend_of": {"record": record, "degree": 1},
        "detrend": {"record": record, "trend": trend_of(record)},
        "split_record": {"record": record, "share": 0.5},
        "subspace": {"u": record.u, "y": record.y, "order": 1, "horizon": 5},
        "identify": {"record": record, "order": 1, "share": 0.5, "degree": 0, "step": 0.1, "delay": 0, "robust": True,
                     "progress": lambda share: None},
        "filter_plant": {"plant": plant, "record": record, "share": 0.5, "delay": 0, "robust": True},
        "fit_noise": {"plant": plant, "record": record},
        "filter_record": {"fitted": found.fitted, "record": found.record, "first": 120, "factor": 1.0, "level": 0.99, "gate": 0.999},
        "sensor_bias": {"found": found, "kind": "data", "factor": 1.0, "gate": 0.999},
    }
