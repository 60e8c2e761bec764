"""The scripts of daily work in the API pages: each runs as it stands, is short, and finds what is true."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_are

PAGE = Path(__file__).resolve().parents[2] / "app" / "engine" / "examples.md"
SCRIPTS = dict(re.findall(r"^## (.+?)\n.*?```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.M | re.S))
LONGEST = 15  # lines of a script, blank ones left out


def rms(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(error))))


def placed(n: dict[str, Any]) -> bool:
    return np.allclose(np.sort(n["loop"].real), [-5, -4]) and np.allclose(np.sort(n["error"].real), [-15, -12])


def steady(n: dict[str, Any]) -> bool:
    A, C = np.array([[0, 1], [-1, -0.2]]), np.array([[1.0, 0.0]])
    P = solve_continuous_are(A.T, C.T, np.diag([0.0, 0.5]), [[0.01]])
    return np.allclose(n["L"], P @ C.T / 0.01) and np.allclose(n["deviation"], np.sqrt(np.diag(P)))


def regulated(n: dict[str, Any]) -> bool:
    A, B = np.array([[0, 1], [0, -0.5]]), np.array([[0.0], [1.0]])
    K = B.T @ solve_continuous_are(A, B, np.diag([10.0, 1.0]), [[1.0]])
    return np.allclose(n["design"].K, K) and n["loop"].stable and n["margins"].stable


def sampled(n: dict[str, Any]) -> bool:
    A, z = n["plant"].A, np.exp(0.05j * 2.0)
    k, s = n["sampled_controller"], 2 / 0.05 * (z - 1) / (z + 1)
    at_z = k.C @ np.linalg.solve(z * np.eye(2) - k.A, k.B) + np.asarray(k.D)
    c = n["controller"]
    return (np.allclose(n["sampled_plant"].A, expm(0.05 * A)) and np.allclose(n["back"].A, A)
            and np.allclose(at_z, c.C @ np.linalg.solve(s * np.eye(2) - c.A, c.B)))


def gaps(n: dict[str, Any]) -> bool:
    spread = np.sqrt(n["track"].variances)
    return 0.9 < (np.abs(n["error"]) < 2.2 * spread)[20:].mean() <= 1 and rms(n["error"][20:, 0]) < 0.6 * np.sqrt(n["kf"].R[0, 0])


def swinging(n: dict[str, Any]) -> bool:
    return rms((n["track"].means - n["truth"])[100:, 0]) < 0.03 and rms((n["track"].means - n["truth"])[100:, 1]) < 0.1


def integrated(n: dict[str, Any]) -> bool:
    return abs(n["x"][0] - 1.0) < 1e-6 and abs(n["u"][0] + 0.3 - 1.0) < 1e-5  # the spring holds one newton at one metre


def reduced(n: dict[str, Any]) -> bool:
    ratio = np.array(n["errors"][1:12]) / np.array(n["errors"][:11])
    return np.allclose(ratio, 0.8) and n["errors"][-1] < 1e-8


def loaded(n: dict[str, Any]) -> bool:
    return abs(n["xhat"][2] - 0.02) < 1e-6 and abs(n["xhat"][0] - n["x"][0]) < 1e-4


def charged(n: dict[str, Any]) -> bool:
    return abs(n["track"].means[-1, 0] - n["truth"][-1]) < 0.01 and abs(n["track"].means[0, 0] - n["truth"][0]) < 0.3


def tilted(n: dict[str, Any]) -> bool:
    return rms((n["tilt"] - n["angle"])[1500:]) < 0.02 and abs(n["found_bias"][-1] - 0.05) < 0.005


def tracked(n: dict[str, Any]) -> bool:
    filtered, smoothed = (rms(found.means[:, ::2] - n["truth"]) for found in (n["track"], n["smoothed"]))
    return np.flatnonzero(n["track"].rejected).tolist() == [70] and smoothed < filtered < rms(n["accuracy"])


def headed(n: dict[str, Any]) -> bool:
    return rms(n["error"][100:]) < 0.05 and abs(n["track"].means[-1, 1] - 0.05) < 1e-3


def isolated(n: dict[str, Any]) -> bool:
    return (n["faulty"][:180] == -1).mean() > 0.95 and (n["faulty"][200:] == 1).mean() > 0.95


def delayed(n: dict[str, Any]) -> bool:
    return bool(np.abs(n["x"]).max() < 1e-3)


CHECKS: dict[str, Callable[[dict[str, Any]], bool]] = {
    "Place poles": placed, "A steady Kalman–Bucy filter": steady, "LQG": regulated, "Sample a plant and a controller": sampled,
    "A discrete Kalman filter with lost readings": gaps, "An extended filter of a pendulum with drag": swinging,
    "Follow a command with an integrator": integrated, "A reduced-order observer": reduced, "The load of a DC motor": loaded,
    "State of charge of a battery by a table": charged, "Tilt from gyroscope and accelerometer": tilted,
    "Smooth a GPS track with irregular fixes": tracked, "A heading": headed, "Which sensor is faulty": isolated,
    "A delay of two samples": delayed}


def test_the_page_has_these_fifteen_scripts() -> None:
    assert list(SCRIPTS) == list(CHECKS) and len(CHECKS) == 15


@pytest.mark.parametrize("title", CHECKS)
def test_a_script_runs_is_short_and_finds_what_is_true(title: str) -> None:
    source = SCRIPTS[title]
    assert sum(bool(line.strip()) for line in source.splitlines()) <= LONGEST
    names: dict[str, Any] = {}
    exec(compile(source, title, "exec"), names)
    assert CHECKS[title](names)
