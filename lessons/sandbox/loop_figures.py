"""Draw the figures of the loop, its noise and its robustness, or the reason why not."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtr, chdtrc

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure, over_frequency
from observer_lab.engine import Plant, chi2_band
from observer_lab.engine.feedback import ClosedLoop
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import NO_WORDS, Text, format_number, joined, same, text, text_in

from ..toolkit.figures import block_colours
from ..toolkit.latex import apart, tiny
from .analyses import Margins, Noise, Refusal, Trial
from .study import largest

VERDICT_TAB, STRUCTURE_TAB, LOOP_TAB = text("Verdicts"), text("Structure"), text("Loop")
NOISE_TAB, ROBUST_TAB = text("Noise"), text("Robustness")
LOWEST = -17.0  # decades: what is smaller is drawn here
NIS_TOLERANCE = 0.05  # a filter whose NIS is this near to its due on average is right, whatever one record says
ALONE = 1e-8  # separation meter below which the error lives by itself
CIRCLE_ANGLES_RAD = np.linspace(0.0, 2 * np.pi, 121)


def decades(values: np.ndarray) -> np.ndarray:
    """log₁₀|values|, not below the lowest that is drawn."""
    return np.log10(np.maximum(np.abs(values), 10.0**LOWEST))


def why(refusal: Refusal) -> Text:
    """The sentence of an analysis that does not apply, as a caption."""
    return text("Not with this design: {text}", text=refusal.text)


def empty_plane(name: str, title: Text, tab: Text, said: Text) -> PlaneFigure:
    """A plane with nothing in it but its sentence."""
    return PlaneFigure(name, title, tab=tab, caption=said)


def empty_time(name: str, title: Text, tab: Text, said: Text) -> LineFigure:
    """Axes with nothing on them but their sentence."""
    return LineFigure(name, title, np.array([0.0, 1.0]), (Curve(same("—"), np.zeros(2), "muted"),), tab=tab, caption=said)


def spectrum(loop: ClosedLoop, dt: float) -> PlaneFigure:
    """The 2n poles among the chosen ones and the compensator's own."""
    groups = ((loop.controller_poles, "plant", "cross"), (loop.observer_poles, "estimate", "cross"), (loop.poles, "reference", "circle"),
              (loop.compensator_poles, "force", "dot"))
    points = tuple(Point(float(p.real), float(p.imag), role, mark) for poles, role, mark in groups for p in poles)  # type: ignore[arg-type]
    near = np.abs(np.concatenate([loop.controller_poles, loop.observer_poles]))
    size = round_up_nicely(1.1 * float(max(np.quantile(near, 0.8), 1e-12))) if not dt else max(1.2, min(float(near.max()), 2.5))
    circle = (Curve(text("unit circle"), np.sin(CIRCLE_ANGLES_RAD), "reference", "solid", 1.2, np.cos(CIRCLE_ANGLES_RAD)),) if dt else ()
    low, high = (-size, size) if dt else (-1.2 * size, 0.4 * size)
    own = loop.compensator_stable
    said = (text("The compensator is stable by itself.") if own else
            text_in("sandbox", "The compensator by itself is unstable."))
    return PlaneFigure(
        "spectrum", text("spectrum of the whole loop"), circle, points, "Re z" if dt else "Re s", "Im z" if dt else "Im s",
        (low, high), (-size, size), equal=bool(dt), unstable=not dt, tab=LOOP_TAB, caption=text(
            "Crosses: eig(A − BK), eig(A − LC). Circles: the {count} poles of the loop. Green dots: the compensator's own. Points "
            "farther out are drawn at the edge. {said}",
            count=len(loop.poles), said=said))


def blocks(loop: ClosedLoop, plant: Plant, meter: float) -> MatrixFigure:
    """The loop in (x, e); the run may leave it, where an input is clipped and the observer does not know."""
    n = plant.n
    names = (*(signal_name(plant, name) for name in plant.state_names), *(f"e{i + 1}" for i in range(n)))
    said = claim(text("White is zero: the error drives the state, never the other way round."), meter, below=ALONE,
                 otherwise=text("White is zero in this matrix, which has no limit in it; in the run, the clipped part of the input drives "
                                "the error."))
    return MatrixFigure("blocks", text("the loop in (x, e) coordinates"), loop.A_xe, names, names, (n,), said, LOOP_TAB,
                        *block_colours(n, True))


def certificate_table(rows: tuple[tuple[Text, float], ...] | Refusal) -> TableFigure:
    """What theory says is zero, beside what rounding leaves."""
    title, heads = text("zeros of theory, in double precision"), (text(
        "quantity"), text(
        "size"))
    if isinstance(rows, Refusal):
        return TableFigure("certificates", title, heads, ((same("—"), same("—")),), why(rows), LOOP_TAB)
    worst = max(value for _, value in rows)
    return TableFigure("certificates", title, heads, tuple((name, tiny(value)) for name, value in rows), tab=LOOP_TAB, caption=text(
        "The largest is about {worst} of its scale. Far above 10⁻⁹ the numbers of this loop are not to be trusted.",
        worst=tiny(worst)))


# --- noise -------------------------------------------------------------------------------------------------------------
def valley(found: Noise | Refusal, belief: float) -> PlaneFigure:
    """Error of the Kalman filters of all beliefs, and of the design's own observer."""
    title = text("estimation error over belief")
    if isinstance(found, Refusal):
        return empty_plane("valley", title, NOISE_TAB, why(found))
    x = np.log10(found.ladder.ratio)

    def size(P: np.ndarray) -> float:
        return 0.5 * float(np.log10(max(float(np.mean(np.diag(P) / found.unit**2)), 1e-300)))
    total, process, sensor = (np.array([size(getattr(p, k)) for p in found.ladder.parts]) for k in ("total", "process", "sensor"))
    at = float(np.interp(np.log10(belief), x, total))
    far = abs(np.log10(belief)) > 0.5
    points = [Point(0.0, float(np.interp(0.0, x, total)), "reference", "circle", text("Kalman")),
              Point(float(np.log10(belief)), at, "error", "dot", text("this belief") if far else same(""))]
    if isinstance(found.ours, Refusal):
        said = text("The observer of the board: {text}", text=found.ours.text)
    else:
        ours = size(found.ours.total)
        points.append(Point(2.2, ours, "estimate", "cross", text("board")))
        said = text("The observer of the board errs {ours:.3g} times as much as the best.",
                    ours=10 ** (ours - float(total.min())))
    low = float(np.floor(2 * total.min()) / 2 - 0.5)
    return PlaneFigure("valley", title, (Curve(text("both noises"), total, "error", x=x),
                                         Curve(text("process noise"), process, "disturbance", "dash", 1.8, x),
                                         Curve(text("sensor noise"), sensor, "second", "dot", 1.8, x)), tuple(points),
                       "b", "σ", (float(x[0]), float(x[-1])),
                       (low, max(low + 2.0, float(total.max()) + 0.2)), tab=NOISE_TAB, caption=said, powers="xy")


def as_far_out(found: Trial) -> float:
    """The share of the records with this mean on average whose own mean lies as far out, on either side: their sum is near χ²."""
    dof = found.test.dof * found.test.independent
    total = found.test.mean * dof / found.expected
    return float(2 * min(chdtr(dof, total), chdtrc(dof, total)))


def nis_figure(found: Trial | Refusal, outputs: int) -> LineFigure:
    """NIS of a filter with this belief."""
    title = text("NIS of a filter with this belief")
    if isinstance(found, Refusal):
        return empty_time("nis", title, NOISE_TAB, why(found))
    low, high = chi2_band(outputs, count=1)
    n, test = len(found.t), found.test
    said = {"consistent": text("as it should be"),
            "overconfident": text("above it, as with an over-confident filter"),
            "cautious": text("below it, as with an under-confident filter")}[test.verdict]
    if test.verdict != "consistent" and abs(found.expected / outputs - 1) < NIS_TOLERANCE:
        said = text("outside it by chance: with these beliefs {share:.2g} % of the records lie as far out", share=100 * as_far_out(found))
    return LineFigure("nis", title, found.t, (Curve(same("NIS"), np.maximum(found.values, 1e-4), "error", width=1.4),
                                              Curve(text("expected, {outputs}", outputs=outputs), np.full(n, float(outputs)),
                                                    "reference", "dash", 1.4),
                                              Curve(text("95 % band"), np.full(n, high), "muted", "dot", 1.4),
                                              Curve(text("lower edge"), np.full(n, low), "muted", "dot", 1.4)), "NIS", log_y=True,
                      window=(0.01, 100.0), tab=NOISE_TAB,
                      caption=text("This record: mean {mean:.3g}, band {low:.3g} … {high:.3g}: {said}. On average: {expected:.3g}.",
                                   mean=test.mean, low=test.mean_band[0], high=test.mean_band[1], said=said,
                                   expected=found.expected))


def gain_figure(found: Trial | Refusal) -> LineFigure:
    """How the recursive gain settles on the Riccati solution."""
    title = text("distance of the gain from the Riccati gain")
    if isinstance(found, Refusal):
        return empty_time("gain", title, NOISE_TAB, why(found))
    late = np.flatnonzero(found.distance > 0.01)
    after, left = format_number(found.t[min(late[-1] + 1, len(found.t) - 1)], ".3g") if len(late) else "0", 100 * float(found.distance[-1])
    return LineFigure("gain", title, found.t, (Curve(text("relative distance"), np.maximum(found.distance, 1e-12), "error"),),
                      "‖M − M∞‖ / ‖M∞‖", log_y=True, window=(1e-8, 1.0), tab=NOISE_TAB,
                      caption=text("Within 1 % after {after} s; no reading has any part in this.", after=after) if left <= 1 else
                      text("At the end it still differs by {left}. No reading has any part in this.", left=apart(left / 100)))


# --- robustness --------------------------------------------------------------------------------------------------------
def sensitivity_figure(found: Margins | Refusal, recovered: np.ndarray | None, grid: np.ndarray) -> LineFigure:
    """Largest singular value of S at the inputs: as it is, had the state been known, and recovered."""
    title = text("sensitivity at the inputs, σ_max(S)")
    if isinstance(found, Refusal):
        return over_frequency("sensitivity", title, grid, (Curve(same("—"), np.ones(len(grid)), "muted"),), caption=why(found),
                               tab=ROBUST_TAB)
    curves = [Curve(text("x known"), largest(found.target, grid), "reference", "dash"),
              Curve(text("by the estimate"), largest(found.loop, grid), "estimate")]
    if recovered is not None:
        curves.append(Curve(text("recovered"), recovered, "force", "dot"))
    peak = float(curves[1].y.max())
    return over_frequency("sensitivity", title, grid, tuple(curves), "σ_max(S)", tab=ROBUST_TAB, window=(0.1, 3.0),
                           caption=text("Peak {peak:.3g}: at worst the loop comes within {peak2:.2g} of "
                                        "instability.",
                                        peak=peak, peak2=1 / peak))


def margin_table(found: Margins | Refusal, plant: Plant) -> TableFigure:
    """Gain, phase and disk margins, one input at a time."""
    title = text("margins, one input at a time")
    heads = (text("input"), text("gain between"), text("phase"), text("disk α"))
    if isinstance(found, Refusal):
        return TableFigure("margins", title, heads, ((same("—"),) * 4,), why(found), ROBUST_TAB)
    rows = tuple((signal_name(plant, c.name), f"{c.gain[0]:.2g} … " + ("∞" if np.isinf(c.gain[1]) else format_number(c.gain[1], ".3g")),
                  f"{np.degrees(c.phase):.0f}°", format_number(c.disk.alpha, ".3g")) for c in found.channels)
    return TableFigure("margins", title, heads, rows, tab=ROBUST_TAB, caption=text(
        "All inputs at once: disk margin α = {together:.3g}, so gains may change by a factor of {together2:.2g} "
        "up or down together.",
        together=found.together, together2=(2 + min(found.together, 1.99)) / (2 - min(found.together, 1.99))))


def recovery_plane(steps: tuple[tuple[float, float, float], ...], total: int, refused: Text | None) -> PlaneFigure:
    """Disk margin and gap of the recovered loop over the knob q."""
    title = text("loop transfer recovery")
    if not steps:
        said = refused or text("Not computed yet: press the button under the knobs.")
        return empty_plane("recovery", title, ROBUST_TAB, said)
    q, alpha, target = (np.array(v) for v in zip(*steps, strict=True))
    x = np.log10(q)
    top = round_up_nicely(1.1 * float(max(alpha.max(), target.max(), 0.1)))
    done = NO_WORDS if len(steps) == total else text(
        "{count} of {total} steps so far.",
        count=len(steps), total=total)
    return PlaneFigure("recovery", title, (Curve(text("disk margin by the estimate"), alpha, "force", x=x),
                                           Curve(text("x known"), target, "reference", "dash", 1.4, x)), (), "q", "α",
                       (-3.0, 3.0), (0.0, top), tab=ROBUST_TAB, powers="x",
                       caption=joined(text("With q = {q:.3g} the disk margin is {alpha:.3g}; with the state known it is {target:.3g}.",
                                           q=q[-1], alpha=alpha[-1], target=target[-1]), done))
