"""The figures of lesson 4: signals, error and input; the spectrum and the block matrix; isolation over frequency."""

from __future__ import annotations

import numpy as np

from app.engine import Plant, autonomous_error
from app.engine.feedback import ClosedLoop
from app.engine.systems import amplitude_response
from app.lesson.figures import Curve, Figure, FrequencyFigure, MatrixFigure, PlaneFigure, Point
from app.lesson.lesson import Outcome
from app.plants.names import called
from app.text.words import Text

from ..toolkit.figures import error_figure, input_figure, state_figures
from .study import Setting

SPECTRUM_TAB = Text("Poles", "极点")
FREQUENCY_TAB = Text("Frequency", "频率")


def figures(here: Setting, outcome: Outcome[ClosedLoop]) -> tuple[Figure, ...]:
    """Signals, error and input over time; the spectrum and the block-triangular matrix."""
    run, loop, model = outcome.run, outcome.study, here.model
    assert run is not None
    limit = outcome.design["u_max"] if outcome.design["limited"] else None
    return (*state_figures(model, run), error_figure(run, autonomous_error(run)), input_figure(run, model, limit),
            _spectrum(outcome), _blocks(loop, model.plant), _isolation(here, outcome))


def _isolation(here: Setting, outcome: Outcome[ClosedLoop]) -> FrequencyFigure:
    """From a disturbance to an output: untouched, steered by the state, steered by the estimate."""
    truth = here.truth(outcome.design)
    A, B, C = truth.A, truth.B, here.heard
    K, n, loop = outcome.gains["K"], truth.n, outcome.study
    zg, w = here.ground, 2 * np.pi * here.frequencies

    def gain(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
        return np.clip(amplitude_response(a, b, c, [[0.0]], w)[:, 0, 0], 1e-12, 1e9)
    bare, state = gain(A, zg, C), gain(A - B @ K, zg, C)
    whole = gain(loop.A_xxhat, np.vstack([zg, np.zeros((n, 1))]), np.hstack([C, np.zeros((1, n))]))
    peak = 20 * np.log10(float(bare.max()) / float(whole.max()))
    return FrequencyFigure(
        "isolation", here.heading[0], here.frequencies,
        (Curve(Text("no control", "无控制"), bare, "muted"),
         Curve(Text("by the state", "状态反馈"), state, "plant", "dash"),
         Curve(Text("by the estimate", "估计反馈"), whole, "estimate")), here.heading[1], tab=FREQUENCY_TAB,
        caption=Text(f"Steering by the estimate lowers the peak by {peak:.1f} dB; the gap to the dashed line is the "
                     "observer's share.",
                     f"按估计控制使峰值降低 {peak:.1f} dB；与虚线之间的差距来自观测器。") if peak > 0 else
        Text(f"Steering by the estimate raises the peak by {-peak:.1f} dB.", f"按估计控制使峰值升高 {-peak:.1f} dB。"))


def _spectrum(outcome: Outcome[ClosedLoop]) -> PlaneFigure:
    groups = (("controller", "plant", "cross"), ("observer", "estimate", "cross"), ("loop", "reference", "circle"),
              ("compensator", "force", "dot"))
    points = tuple(Point(float(p.real), float(p.imag), role, mark)  # type: ignore[arg-type]
                   for key, role, mark in groups for p in outcome.poles[key])
    low = min(-1.0, *(p.x for p in points))
    high = max(2.0, *(abs(p.y) for p in points))
    return PlaneFigure(
        "spectrum", Text("spectrum of the whole loop", "整个闭环的谱"), (), points, "Re s", "Im s",
        (1.1 * max(low, -60.0), max(3.0, 1.1 * min(60.0, max(p.x for p in points)))),
        (-1.1 * min(high, 60.0), 1.1 * min(high, 60.0)), unstable=True, tab=SPECTRUM_TAB,
        caption=Text(f"Crosses: chosen on the boards. Circles: poles of the {len(outcome.poles['loop'])}-state loop. Green dots: "
                     "the compensator's own.",
                     f"叉号：板上选定的极点。圆圈：{len(outcome.poles['loop'])} 阶闭环的极点。绿点：补偿器自身的极点。"))


def _blocks(loop: ClosedLoop, plant: Plant) -> MatrixFigure:
    n = loop.A_xe.shape[0] // 2
    names = [*(called(plant, name) for name in plant.state_names), *(f"e{i + 1}" for i in range(n))]
    corner = float(np.max(np.abs(loop.A_xe[n:, :n])))
    zero = corner < 1e-9 * float(np.max(np.abs(loop.A_xe)))
    return MatrixFigure(
        "blocks", Text("the loop in (x, e) coordinates", "(x, e) 坐标下的闭环矩阵"), loop.A_xe, tuple(names), tuple(names),
        (n,), tab=SPECTRUM_TAB,
        caption=Text("The lower left block is zero: the error drives the state, never the other way round.",
                     "左下块为零：误差驱动状态，状态从不驱动误差。") if zero else
        Text(f"The lower left block is no longer zero (largest entry {corner:.2g}): the state drives the error.",
             f"左下块不再为零（最大元素 {corner:.2g}）：状态反过来驱动误差。"))
