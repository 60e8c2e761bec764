"""The rows on the stage of lesson "robust observer", against the equations written out here."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from observer_lab.course.figures.records import LineFigure
from observer_lab.course.lesson import Outcome
from observer_lab.lessons.robust_observer.lesson import LESSON
from observer_lab.lessons.robust_observer.study import Story
from observer_lab.plants.bodies.body import Pose, Rod

FULL = {"1": 3.0, "2": 0.02, "3": 3.0, "4": 0.5}  # the error at the marks of the bars
HALF = 1.08  # stage units of such a bar
HELD = 1 - 1e-9


def outcome(**changes: object) -> Outcome[Story]:
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def rows_drawn(o: Outcome[Story], t: float) -> np.ndarray:
    """What the bars show at a time, the sum last, in shares of the marks: their lengths to the right of zero."""
    stage = o.stage
    assert stage is not None
    poses = stage.body.pose(stage.x[int(np.argmin(np.abs(stage.t - t)))].tolist(), 1.0)
    bars = [part.name for part in stage.body.parts if isinstance(part.shape, Rod) and part.name.startswith("part ")]
    return np.array([_rightwards(poses[name]) / HALF for name in bars])


def _rightwards(pose: Pose) -> float:
    w, x, y, z = pose.wxyz
    return pose.scale[2] * 2 * (x * z + w * y)


@pytest.mark.parametrize(("s", "c"), [(-10.0, 0.05), (-5.0, 0.05), (-5.0, 0.0), (-5 / 3, 0.05)])
def test_each_bar_is_what_one_error_of_the_model_adds_by_the_papers_equations(s: float, c: float) -> None:
    """Example 1 in numbers: T = [1, s], L = −(s² + 4s + 3), N = 30 and M = −(50 + 30s); ζ = z − Tx in one equation for each cause."""
    L, N, M, TB = -(s * s + 4 * s + 3), 30.0, -(50 + 30 * s), 2 + s

    def rate(t: float, w: np.ndarray) -> list[float]:
        x1, x2, z, start, first, second, sensor = w
        y = (1 + c) * x2
        u = -(N * z + M * y) - 4 * np.sin(5 * t + np.pi / 2)
        return [-3 * x2 + 2 * u, 1.1 * x1 - 4.4 * x2 + u, s * z + L * y + TB * u, s * start, s * first - s * 0.1 * x1,
                s * second + s * 0.4 * x2, s * sensor + L * c * x2]

    times = np.array([0.3, 1.2, 3.0, 4.5, 5.805])
    start = [1.0, 1.0, -0.3, -0.3 - (1 + s), 0.0, 0.0, 0.0]
    w = solve_ivp(rate, (0, 6), start, "DOP853", times, rtol=1e-11, atol=1e-12).y
    plant = outcome(pole=(s,), c=c)
    a = plant.design
    assert (a["a1"], a["a2"]) == (0.1, -0.4)
    for k, t in enumerate(times):
        parts = np.array([-N * w[3, k], -N * w[4, k], -N * w[5, k], -N * w[6, k] - M * c * w[1, k]])
        x1, x2, z = w[:3, k]
        missed = -(N * z + M * (1 + c) * x2) + (30 * x1 - 50 * x2)
        assert missed == pytest.approx(parts.sum(), abs=1e-7)
        expected = np.clip(np.append(parts, missed) / 3.0, -1, 1)
        rows = rows_drawn(plant, t)
        np.testing.assert_allclose(rows, np.where(np.abs(expected) < 0.004, np.copysign(0.004, rows), expected), atol=2e-6)


@pytest.mark.parametrize("example", ["1", "4"])
def test_bars_beads_and_lines_lie_on_the_sloping_panel_one_row_below_the_other(example: str) -> None:
    """The panel rises 0.215 for 0.165 away from the viewer: a bar's axis is its radius and a line's thickness off it."""
    stage = outcome(example=example, input=0.1).stage
    assert stage is not None
    poses, parts = stage.body.pose(stage.x[40].tolist(), 1.0), {part.name: part for part in stage.body.parts}
    normal = np.array([0.0, -0.215, 0.165]) / np.hypot(0.215, 0.165)
    face = np.array(poses["panel"].position) + 0.035 * normal

    def off(name: str) -> float:
        return float((np.array(poses[name].position) - face) @ normal)

    shape = [parts[f"part {k}"].shape for k in range(6)]
    assert [off(f"part {k}") for k in range(6)] == pytest.approx([each.radius + 0.012 for each in shape if isinstance(each, Rod)])
    assert [off(f"bead {k}") for k in range(4)] == pytest.approx([0.095] * 4)
    heights = np.array([poses[f"part {k}"].position[2] for k in range(5)])
    np.testing.assert_allclose(np.diff(heights), -0.215, atol=1e-9)
    ends = [poses[f"line {name}"].position[0] - poses["line 0"].position[0] for name in ("-1", "1")]
    assert ends == pytest.approx([-HALF, HALF]) and poses["part 5"].position[0] == pytest.approx(poses["line 0"].position[0])


def test_the_axis_of_the_input_is_three_times_the_late_input_and_the_caption_says_what_is_outside() -> None:
    for pole in (-10.0, -5 / 3):
        o = outcome(pole=(pole,))
        u = np.abs(o.study.true.u[:, 0])
        figure = next(f for f in LESSON.figures(o) if f.id == "input")
        assert isinstance(figure, LineFigure) and figure.most is not None
        wanted = max(3 * u[len(u) // 2:].max(), 10.0)
        assert figure.most[0] == -figure.most[1] and wanted <= figure.most[1] <= 2.5 * wanted
        assert ("outside the axis" in figure.caption("en")) == (u.max() > figure.most[1])


@pytest.mark.parametrize("example", ["1", "2", "3", "4"])
@pytest.mark.parametrize("share", [0.0, 0.1])
def test_the_bars_add_up_to_the_last_one_and_that_is_the_way_from_the_wanted_input_to_its_ghost(example: str, share: float) -> None:
    o = outcome(example=example, input=share)
    assert o.stage is not None and o.stage.xhat is not None
    apart, checked = o.stage.xhat[:, -1] - o.stage.x[:, -1], 0
    for t in o.stage.t[::4]:
        bars = rows_drawn(o, float(t))
        assert len(bars) == (6 if share else 5)
        if np.abs(bars).max() < HELD:
            true = np.where(np.abs(bars) <= 0.0041, 0.0, bars)
            assert true[:-1].sum() == pytest.approx(true[-1], abs=0.025)
            assert FULL[example] * bars[-1] == pytest.approx(apart[int(np.argmin(np.abs(o.stage.t - t)))], abs=0.005 * FULL[example])
            checked += 1
    assert checked > 4


@pytest.mark.parametrize(("example", "knobs"), [("1", ("a1", "a2", "c", "input")), ("4", ("stiff", "damp", "tacho", "input"))])
def test_without_an_error_of_the_model_its_bar_is_gone_and_only_the_first_error_is_left(example: str, knobs: tuple[str, ...]) -> None:
    for k, name in enumerate(knobs[:3]):
        bars = rows_drawn(outcome(example=example, **{name: 0.0}), 4.5)
        assert abs(bars[1 + k]) <= 0.0041 and all(abs(bars[1 + other]) > 0.0041 for other in range(3) if other != k)
    exact = rows_drawn(outcome(example=example, **dict.fromkeys(knobs, 0.0)), 1.2)
    assert np.abs(exact[1:-1]).max() <= 0.0041 and exact[0] == pytest.approx(exact[-1], abs=1e-6)


def test_the_scenes_show_what_they_say() -> None:
    """A fast pole lengthens each bar of the model; the sensor's bar opposes the sum of the others, and without it the sum is longer."""
    fast, slow = (rows_drawn(outcome(pole=(s,)), 6.0) for s in (-10.0, -5 / 3))
    assert (np.abs(fast[1:]) > 1.5 * np.abs(slow[1:])).all()
    with_it, exact = (rows_drawn(outcome(c=c), 5.8) for c in (0.05, 0.0))
    assert with_it[3] * with_it[1:3].sum() < 0 and abs(exact[-1]) > 3 * abs(with_it[-1])
    before, after = (rows_drawn(outcome(example="4", pair=(complex(-0.5, -im), complex(-0.5, im))), 4.0) for im in (0.5, 2.0))
    assert abs(before[3]) > 0.05 and abs(after[3]) <= 0.0041 and abs(after[1]) > 2 * abs(before[1])


@pytest.mark.parametrize("s", [-10.0, -5.0, -5 / 3, -0.5])
def test_the_slabs_are_the_three_sizes_in_the_criterion_by_the_papers_equations(s: float) -> None:
    """Example 1: T A₁ and T A₂ have the one entry s, L C₁ the entry −(s² + 4s + 3), M C₁ the entry −(50 + 30s)."""
    sizes = np.array([2 * abs(s), abs(s * s + 4 * s + 3), abs(50 + 30 * s)])
    o = outcome(pole=(s,))
    stage = o.stage
    assert stage is not None and stage.body.marks is not None
    x = stage.x[0].tolist()
    poses, words = stage.body.pose(x, 1.0), stage.body.marks(x, x, 1.0).words
    drawn = np.array([poses[f"J {name}"].scale[2] for name in "TLM"])
    np.testing.assert_allclose(drawn, np.maximum(1.5 * sizes / max(360.0, sizes.sum()), 0.004), atol=1e-9)
    assert words[0][0] == f"J = {sizes.sum():.3g}"
    seen = [name for name, high in zip("TLM", drawn, strict=True) if high >= 0.09]
    assert [name for name, at, _ in words[1:] if at[2] > 0] == seen
