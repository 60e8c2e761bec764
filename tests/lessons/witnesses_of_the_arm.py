"""Witnesses for the arm: when its load is found, where it stands at the end, and on which side of the gap."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from witnesses import LONGER, Shown, Witness, near, value

from observer_lab.course.figures.records import LineFigure
from observer_lab.engine import simulate
from observer_lab.text import Text


def _load_found(shown: Shown, words: Text) -> None:
    run, after = shown.run, value(words, "found")
    away = np.abs(run.x[:, 3] - run.xhat[:, 3]) - 0.05 * abs(shown["load"])
    assert float(np.max(away[run.t > 1 + after - 1e-9])) <= 1e-12, "not even in the run"
    assert not after > 0 or away[run.index(1 + after) - 1] > 0, "it was found before"


def _on_target(shown: Shown, _: Text) -> None:
    tail = np.degrees(shown.run.x[-max(len(shown.run.t) // 10, 1):, 2])
    assert abs(float(tail.mean()) - shown["target"]) < 0.05, f"it stands at {tail.mean():.4g}°"


def _below_target(shown: Shown, words: Text) -> None:
    tail = np.degrees(shown.run.x[-max(len(shown.run.t) // 10, 1):, 2])
    near(value(words, "droop"), shown["target"] - float(tail.mean()))


def _claimed_in_vain(shown: Shown, words: Text) -> None:
    early = shown.run.t < 1 - 1e-9
    near(value(words, "false"), float(np.max(np.abs(shown.run.xhat[early, 3]))))


def _off_the_motor(shown: Shown, words: Text) -> None:
    assert value(words, "apart") <= shown["gap"] / 2 * (1 + 1e-4) and shown["encoder"] != "joint"


def _on_a_flank(shown: Shown, words: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    near(abs(float(figure.curves[0].y[-1])), shown["gap"] / 2, 1e-4)
    near(value(words, "apart"), shown["gap"] / 2, 1e-4)


def _at_rest(shown: Shown, _: Text) -> None:
    s = shown.run.scenario
    r = s.reference
    longer = simulate(replace(s, horizon=LONGER * s.horizon, reference=None if r is None else np.asarray(r)[0]))
    tail = shown.run.x[-max(len(shown.run.t) // 10, 1):].mean(axis=0)
    assert abs(np.degrees(longer.x[-1, 2] - tail[2])) < 0.05, "it goes on from there"


WITNESSES: Mapping[str, Witness] = {
    "The load is found to 5 % after {found:.3f} s.": _load_found,
    "At the end the arm stands on its target.": _on_target,
    "At the end the arm is {droop:.3g}° below its target.": _below_target,
    "Before the load came it was up to {false:.2g} N m.": _claimed_in_vain,
    "The arm stands up to {apart:.2g}° off the motor, and the encoder on the motor does not measure it.": _off_the_motor,
    "At the end the arm rests on one flank, {apart:.3g}° from the motor.": _on_a_flank,
    "The run ends where the equations of rest say.": _at_rest,
}
