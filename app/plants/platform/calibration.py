"""Derive the platform's parameters: solved for, chosen, or taken from the report.

The report prints no matrices, only ten Hankel singular values. The structure of `platform` with some free choices
leaves six unknowns, and the list gives six equations for them:

    mean of (σ1, σ2)               cz         = kz/(√2 σ1) up to μ/m: the vertical motion stands alone
    mean and split of (σ3, σ4)     kx, cx     horizontal motion, mixed with pitch
    mean and split of (σ5, σ6)     h, s       pitch, mixed with horizontal motion
    mean of (σ7, σ8)               cp         test masses in phase

The rest of the list is then a prediction that comes true: σ1 = σ2 and σ7 = σ8 to the four decimals printed, and σ9 = σ10 =
0.0001 to the one digit printed.

What the list does not pin down is a choice here; `python -m observer_lab.plants.platform.calibration` says so line by line:
- The size. All lengths by one factor with J by its square change nothing; m, J, μ and every k and c by one factor change
  σ1 … σ8 by less than 1e-4 as long as the coils are weak beside the springs (1 N against kz · 1 m).
- The speed. kz and kp by one factor: the six unknowns follow, and σ9 goes on printing as 0.0001 with the vertical motion
  anywhere from 1.2 Hz to 1.9 Hz; only 1–2 Hz in the report's figures says more.
- The pitch frequency. Another `a`, and the six equations have another solution with other kx, h and s. σ9, which prints as
  0.0001 for `a` from 0.138 m to 0.179 m, leaves pitch 1.04 Hz to 1.35 Hz (all at this speed). With kx and s held and the
  means alone asked for, h follows and pitch may lie anywhere from 1.19 Hz to 2.5 Hz; there the splits tell.
- kp hardly matters, b hardly either; μ and cp enter as μ²/cp.

The splits are printed as 0.0188 and 0.0247, to 0.0001: that is what limits kx, cx, h and s, the column ± says how far.
Further digits of the two splits are therefore a choice within what is printed.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from types import MappingProxyType

import numpy as np
from scipy.optimize import least_squares

from ...engine import EngineError, hankel_singular_values
from .model import Parameters, plant

PUBLISHED_HANKEL = (572.7565, 572.7565, 360.3040, 360.2852, 43.0552, 43.0305, 0.0539, 0.0539, 0.0001, 0.0001)  # equation (39)
HALF_DIGIT = 5e-5  # each value is printed to four decimals
SPLITS = (0.0187544, 0.0247283)  # of (σ3, σ4) and (σ5, σ6), a choice within the printed 0.0188 and 0.0247 ± 0.0001
UNKNOWNS = ("cz", "kx", "cx", "h", "s", "cp")
START_PARAMETERS = MappingProxyType({"cz": 0.7, "kx": 470.0, "cx": 0.9, "h": 0.015, "s": 0.07, "cp": 0.5})
CHOICES = MappingProxyType({
    "m": (12.0, "size: a table-top deck with its payload"),
    "J": (0.48, "m (0.2 m)²"),
    "kz": (533.0, "speed: 1.5 Hz for m on two springs; the report's vertical peak lies at 1–2 Hz"),
    "a": (0.158, "pitch frequency: 1.19 Hz, beside the horizontal 0.995 Hz; the report sees two adjacent peaks"),
    "b": (0.20, "coils outside the springs; the list is blind to it"),
    "mu": (0.050, "a test mass of 50 g"),
    "kp": (1800.0, "a stiff servo: 30 Hz, above the report's band of 0.1–10 Hz"),
    "lower": (0.0, "coil and spring in one line; the list hardly sees it, the rotation's spectrum does"),
    "ground": (1.0, "springs pass on all of the ground's motion"),
})
KEPT_DIGITS = MappingProxyType({"cz": 3, "kx": 5, "cx": 5, "h": 5, "s": 5, "cp": 6})  # that `platform` keeps of each
TOLERANCE = 1e-9  # largest relative residual of a solution


@dataclass(frozen=True)
class Calibration:
    """A solution: all parameters, relative residuals of the six equations, the ten Hankel values that come out.

    spread: by how much each unknown, in the order of UNKNOWNS, may be wrong because the list is printed to four decimals.
    """

    parameters: Parameters
    residuals: np.ndarray
    hankel: np.ndarray
    spread: np.ndarray

    @property
    def rounded(self) -> Parameters:
        """The solution with as many digits of each unknown as `platform` keeps."""
        return replace(self.parameters, **{name: float(f"{getattr(self.parameters, name):.{digits}g}")
                                           for name, digits in KEPT_DIGITS.items()})


def targets(published: tuple[float, ...] = PUBLISHED_HANKEL, splits: tuple[float, float] | None = SPLITS) -> np.ndarray:
    """The six numbers asked for (6,); `splits` None takes those of the list as printed."""
    first, second, third, fourth = (np.array(published[i:i + 2]) for i in (0, 2, 4, 6))
    apart = (second[0] - second[1], third[0] - third[1]) if splits is None else splits
    return np.array([first.mean(), second.mean(), apart[0], third.mean(), apart[1], fourth.mean()])


def measured(parameters: Parameters) -> np.ndarray:
    """The same six numbers of a plant (6,)."""
    return targets(tuple(hankel_singular_values(plant(parameters))), None)


def chosen(**changes: float) -> Parameters:
    """The free choices, some of them changed, with the unknowns at the start of the search."""
    return Parameters(**{**{name: value for name, (value, _) in CHOICES.items()}, **START_PARAMETERS, **changes})


def calibrate(start: Parameters | None = None, wanted: np.ndarray | None = None,
              unknowns: tuple[str, ...] = UNKNOWNS, equations: tuple[int, ...] = tuple(range(6))) -> Calibration:
    """Solve for the unknowns, the other parameters as they are in `start`.

    Least squares on relative residuals over the logarithms of the unknowns, which keeps them positive. `equations`
    are indices into `targets`. Raises EngineError where the search ends elsewhere than at a solution.
    """
    start = chosen() if start is None else start
    wanted = targets() if wanted is None else np.asarray(wanted, dtype=float)
    picked = list(equations)

    def at(logs: np.ndarray) -> Parameters:
        return replace(start, **dict(zip(unknowns, np.exp(logs).tolist(), strict=True)))

    def residual(logs: np.ndarray) -> np.ndarray:
        return (measured(at(logs)) / wanted - 1)[picked]

    found = least_squares(residual, np.log([getattr(start, name) for name in unknowns]), jac="3-point", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    if np.abs(found.fun).max() > TOLERANCE:
        raise EngineError("No solution near this start: the equations are missed by {fun:.1e}; start nearer.",
                          fun=np.abs(found.fun).max())
    solution = at(found.x)
    return Calibration(solution, found.fun, hankel_singular_values(plant(solution)),
                       _spread(solution, found.jac, wanted, unknowns, picked))


def _spread(solution: Parameters, jacobian: np.ndarray, wanted: np.ndarray, unknowns: tuple[str, ...],
            picked: list[int]) -> np.ndarray:
    """Σ |∂unknown/∂target| · what rounding may do to a target: half a digit to a mean, a whole one to a split."""
    rounding = HALF_DIGIT * np.array([1.0, 1.0, 2.0, 1.0, 2.0, 1.0])[picked] / wanted[picked]
    logs = np.abs(np.linalg.pinv(jacobian)) @ rounding
    return logs * np.array([getattr(solution, name) for name in unknowns])


def table(result: Calibration) -> str:
    """parameter | solution | kept | ± | where from, and the ten Hankel values beside the printed ones."""
    kept = result.rounded
    spread = dict(zip(UNKNOWNS, result.spread, strict=True))
    source = {"cz": "solved: mean of σ1, σ2", "kx": "solved: σ3 … σ6", "cx": "solved: σ3 … σ6", "h": "solved: σ3 … σ6",
              "s": "solved: σ3 … σ6", "cp": "solved: mean of σ7, σ8"}
    rows = [("parameter", "solution", "kept", "±", "where from")]
    for field in fields(Parameters):
        name = field.name
        value, used = getattr(result.parameters, name), getattr(kept, name)
        rows.append((name, f"{value:.7g}", f"{used:g}", f"{spread[name]:.1g}" if name in spread else "",
                     source.get(name) or f"choice: {CHOICES[name][1]}"))
    rows += [("", "", "", "", ""), ("Hankel", "kept digits", "printed", "", "where from")]
    origin = (*("published, used",) * 8, *("published, one digit: a check",) * 2)
    for i, (value, printed) in enumerate(zip(hankel_singular_values(plant(kept)), PUBLISHED_HANKEL, strict=True)):
        rows.append((f"σ{i + 1}", f"{value:.7g}", f"{printed:.4f}", "", origin[i]))
    wide = [max(len(row[k]) for row in rows) for k in range(5)]
    lines = [" | ".join(cell.ljust(w) for cell, w in zip(row, wide, strict=True)).rstrip() for row in rows]
    return "\n".join([*lines, "", f"Largest relative residual of the six equations: {np.abs(result.residuals).max():.1e}.",
                      "Not pinned down by the list: size, speed, pitch frequency, kp, b; see this module's first lines."])


if __name__ == "__main__":
    print(table(calibrate()))
