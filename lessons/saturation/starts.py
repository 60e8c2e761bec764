"""The map of starts: which pairs of angle and estimation error come home, found pass by pass, never shown as another's."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import degrees, radians
from typing import Any

import numpy as np

from app.engine import EngineError, Plant, Scenario
from app.engine.simulation import recovery_map
from app.lesson.figures import MapFigure
from app.text.words import Text

HORIZON = 8.0  # s
NEAR = 0.05  # ‖x‖ at the horizon below which a start has come home (m, rad, m/s, rad/s)
FAR = 20.0  # ‖x‖ beyond which it has not, whatever comes
STEP = 0.01  # s, grid of the map's runs
STRIDE = 2  # the map is found in STRIDE² interlaced passes
GRID = np.linspace(-20.0, 20.0, 41)  # degrees: angle across, error of its estimate upwards
UNKNOWN, HOME, LOST, HOPELESS = -1, 0, 1, 2
ANGLE = 1  # index of the angle in the state
SLICE = 0.004  # s of work between two yields

CATEGORIES = (
    (Text("comes home", "能恢复"), "plant"),
    (Text("does not", "不能恢复"), "disturbance"),
    (Text("no controller could", "任何控制器都不能"), "muted"),
)


@dataclass(frozen=True, eq=False)
class Starts:
    """Categories (n_error, n_angle) of the starts on GRID × GRID, for the design values in `key` alone."""

    key: tuple[Any, ...]
    values: np.ndarray

    @property
    def done(self) -> float:
        """Share of the map that is known."""
        return float(np.mean(self.values != UNKNOWN))

    @property
    def home(self) -> float:
        """Share of the whole map that comes home."""
        return float(np.mean(self.values == HOME))

    def at(self, angle: float, error: float) -> int:
        """The category of the start nearest to an angle and an error in degrees."""
        return int(self.values[nearest(error), nearest(angle)])


def nearest(value: float) -> int:
    """Index of the grid line nearest to a value in degrees."""
    return int(np.argmin(np.abs(GRID - value)))


def ceiling(plant: Plant, u_max: float) -> float:
    """The angle in degrees from which no |u| ≤ u_max can bring the resting plant back: |q·B| u_max / (λ |q_θ|).

    q is the left eigenvector of the one unstable eigenvalue λ: d(q·x)/dt = λ q·x + q·B u cannot change sign beyond.
    """
    values, vectors = np.linalg.eig(plant.A.T)
    unstable = np.flatnonzero(np.real(values) > 1e-9)
    if len(unstable) != 1:
        raise EngineError("The ceiling needs one unstable eigenvalue; this plant has {count}.", count=len(unstable))
    q, rate = np.real(vectors[:, unstable[0]]), float(np.real(values[unstable[0]]))
    return degrees(abs(float(q @ plant.B[:, 0])) * u_max / (rate * abs(q[ANGLE])))


def survey(scenario: Scenario, key: tuple[Any, ...], known: Starts | None) -> Iterator[tuple[float, Starts]]:
    """Yield (fraction done, starts so far) every few milliseconds; each pass adds final verdicts, never guesses.

    The loop is odd: (−x, −x̂) runs as the mirror image of (x, x̂). So only errors ≥ 0 are run and the rest is
    mirrored, and starts beyond the ceiling need no run. A map begun before goes on from where it was.
    """
    values = np.full((len(GRID), len(GRID)), UNKNOWN) if known is None or known.key != key else known.values.copy()
    limit = ceiling(scenario.plant, float(scenario.u_max[0]))
    values[:, np.abs(GRID) >= limit] = HOPELESS
    angles, errors = np.flatnonzero(np.abs(GRID) < limit), np.flatnonzero(GRID >= 0)
    passes = [(angles[i::STRIDE], errors[j::STRIDE]) for j in range(STRIDE) for i in range(STRIDE)]
    starts = Starts(key, values)
    for k, (across, up) in enumerate(passes):
        if not len(across) or np.all(values[np.ix_(up, across)] != UNKNOWN):
            continue
        recovered = np.zeros((len(across), len(up)), dtype=bool)
        for fraction, found in recovery_map(scenario, ANGLE, np.radians(GRID[across]), ANGLE, np.radians(GRID[up]),
                                            threshold=NEAR, bound=FAR, slice_seconds=SLICE):
            recovered = found.recovered
            yield (k + fraction) / len(passes), starts
        values = values.copy()
        values[np.ix_(up, across)] = np.where(recovered.T, HOME, LOST)
        values[np.ix_(len(GRID) - 1 - up, len(GRID) - 1 - across)] = values[np.ix_(up, across)]
        starts = replace(starts, values=values)
    yield 1.0, starts


def map_scenario(scenario: Scenario) -> Scenario:
    """The scenario of the map: the same loop from rest and a true estimate, without a kick, on the map's own grid."""
    rest = np.zeros(scenario.plant.n)
    return replace(scenario, x0=rest, xhat0=rest, impulses=(), horizon=HORIZON, dt=STEP)


def start_state(angle: float, error: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """x(0) and x̂(0) of a resting cart whose pole leans by `angle` degrees and is believed at angle − error."""
    return (0.0, radians(angle), 0.0, 0.0), (0.0, radians(angle - error), 0.0, 0.0)


def starts_figure(starts: Starts | None, limit: float, angle: float, error: float, kicked: bool) -> MapFigure:
    """The map with the present start marked; what is not known for this design stays blank."""
    values = np.full((len(GRID), len(GRID)), UNKNOWN) if starts is None else starts.values
    return MapFigure("starts", Text("starts that come home", "能恢复的初态"), GRID, GRID, values, CATEGORIES,
                     "θ(0) [°]", "θ(0) − θ̂(0) [°]", (angle, error), _caption(starts, limit, kicked),
                     Text("Map", "地图"))


def _caption(starts: Starts | None, limit: float, kicked: bool) -> Text:
    if starts is None:
        return Text("Not computed for this design yet: press the button under the knobs.",
                    "当前设计尚未计算：请按旋钮下方的按钮。")
    share, part = 100 * starts.home, 100 * starts.done
    text = (Text(f"{share:.1f} % of these starts come home.", f"图中 {share:.1f} % 的初态能恢复。") if starts.done == 1 else
            Text(f"{part:.0f} % of the map is known; blank starts have not been run.",
                 f"已算出 {part:.0f} %；空白处的初态尚未运行。"))
    edge = (Text(f" Beyond {limit:.1f}° no controller could.", f" 超过 {limit:.1f}° 任何控制器都无能为力。")
            if limit < GRID[-1] else Text("", ""))
    kick = Text(" The map is drawn without the kick.", " 地图不含冲击。") if kicked else Text("", "")
    click = Text(" The circle runs now; click another start.", " 圆圈是正在运行的初态；点击别处即可运行。")
    return Text(text.en + edge.en + click.en + kick.en, text.zh + edge.zh + click.zh + kick.zh)
