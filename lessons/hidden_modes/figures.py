"""Draw the figures of lesson 6: signals, margins, conditions, Kalman decomposition."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import accumulate

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, Figure, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lesson import Check, Outcome
from observer_lab.engine.simulation import Run
from observer_lab.engine.structure import Mode
from observer_lab.text import NO_WORDS, Text, format_number, symbol, text

from ..toolkit.diagram import loop
from ..toolkit.figures import ERROR_TAB, TIME_TAB, input_figure
from ..toolkit.latex import pole_words
from .knobs import COMMON, RELATIVE, Case
from .study import carries

MODES_TAB, EVERY_TAB = text("Modes"), text("Every gain")
CLEARLY_ABOVE_ZERO = 1e-3  # a distance above this share of the plant's size is well above zero
RANDOM_GAINS = 50  # random gains on the maps of the tab "Every gain"
GAIN_SIGMAS = np.array([3.0, 3.0, 8.0, 8.0])  # their standard deviations, position entries first
YES, NO = text("● yes"), text("○ no")
MOST_ROWS = 12  # of the table of modes


def figures(lines: Callable[[Case, Run], Sequence[Figure]], clouds: Callable[[Case, int], Sequence[Figure]],
            outcome: Outcome[Case]) -> tuple[Figure, ...]:
    """The `lines` over time that a plant has, input, margins, lights, decomposition, the `clouds` of every gain, the loop."""
    run, case = outcome.run, outcome.study
    assert run is not None
    return (*lines(case, run), input_figure(run, case.model), margins_of(case), lights_of(outcome.checks), blocks_of(case),
            *clouds(case, int(outcome.design["seed"])), loop(case.model.plant, run, outcome.gains["L"], outcome.gains["K"]))


def case_lines(case: Case, run: Run) -> tuple[Figure, ...]:
    """Reading and common motion, and both parts of e and x, of the lesson's plants."""
    return _measured(run), _centre(run, case), _error_parts(run, case), _state_parts(run, case)


def measured_figure(run: Run, title: Text, label: str, caption: Text, window: tuple[float, float] | None = None) -> LineFigure:
    """What the first sensor says, and what the observer expects it to say."""
    return LineFigure("measured", title, run.t, (Curve(text("measured y"), run.y[:, 0]),
                                                 Curve(text("predicted ŷ"), run.yhat[:, 0], "estimate", "dash")),
                      label, window=window, tab=TIME_TAB, caption=caption)


def parts_figure(name: str, what: str, run: Run, first: Curve, second: Curve, caption: Text,
                 window: tuple[float, float] | None = None) -> LineFigure:
    """Two parts of e, or of x."""
    title = text("estimation error e, in two parts") if what == "e" else text("plant state x, in two parts")
    return LineFigure(name, title, run.t, (first, second), f"‖{what}‖", log_y=True, window=window, caption=caption, tab=ERROR_TAB)


def _measured(run: Run) -> LineFigure:
    y, late = run.y[:, 0], run.y[-max(len(run.y) // 8, 1):, 0]
    size = float(np.max(np.abs(late)))
    share = size / max(float(np.max(np.abs(y))), 1e-12)
    said = claim(text("The trace is flat: in the reading all seems at rest."), share, below=0.02, otherwise=text(
        "In the last eighth of the run the sensor still reads up to {size:.2g} m.", size=size))
    return measured_figure(run, text("what the sensor says"), "y [m]", said, (-0.2, 0.2))


def _centre(run: Run, case: Case) -> LineFigure:
    signal = case.model.watched[-1]
    true, guess = signal.of(run.x), signal.of(run.xhat)
    end, gap = float(abs(true[-1])), float(abs(true[-1] - guess[-1]))
    return LineFigure(
        "centre", text("the motion of both blocks together"), run.t,
        (Curve(text("true"), true), Curve(text("estimate"), guess, "estimate", "dash")),
        "[m]", window=(-0.1, 0.1), tab=TIME_TAB,
        caption=text("At the end both blocks are {end:.2g} m off their rest, the estimate is {gap:.2g} m wrong.",
                     end=end, gap=gap))


def _fixed(bolts: tuple[complex, ...], what: str, gain: str) -> Text:
    rate = format_number(max(p.real for p in bolts), ".3g")
    return text("The common part of {what} follows e^({rate} t), whatever {gain} is.",
                what=what, rate=rate, gain=gain)


def _parts(name: str, what: str, run: Run, values: np.ndarray, caption: Text) -> LineFigure:
    common, relative = (np.linalg.norm(values @ part.T, axis=1) for part in (COMMON, RELATIVE))
    return parts_figure(name, what, run, Curve(text("both blocks together"), common, "error"),
                        Curve(text("one against the other"), relative, "second", "dash"), caption, (1e-3, 1.0))


def _error_parts(run: Run, case: Case) -> LineFigure:
    caption = (_fixed(case.unseen, "e", "L") if case.unseen and carries(case, run)
               else text("This run starts without a common part of e.") if case.unseen else text("L moves both parts of e."))
    return _parts("error_parts", "e", run, run.e, caption)


def _state_parts(run: Run, case: Case) -> LineFigure:
    if case.unmoved and not carries(case, run):
        caption = text("This run starts without a common part of x.")
    elif case.unmoved:
        caption = _fixed(case.unmoved, "x", "K")
    elif case.unseen:
        caption = text("K could move both parts, but it acts on x̂: the common part of x goes where that of e "
                       "goes.")
    else:
        caption = text("K moves both parts of x.")
    return _parts("state_parts", "x", run, run.x, caption)


def _bar(mode: Mode) -> str:
    """The PBH distance as a number, its share of the plant's size as a bar over six decades; a hidden mode has none."""
    if not mode.visible:
        return "0"
    return format_number(mode.distance, ".3g") + " " + "▮" * max(1, round(6 + np.log10(max(mode.margin, 1e-6))))


def mode_name(mode: Mode) -> str:
    """The pole of a mode, or the pair that it belongs to."""
    return pole_words([complex(mode.pole.real, abs(mode.pole.imag))])


def margins_of(case: Case) -> TableFigure:
    """Every mode with its PBH distances towards y and u."""
    rows = []
    for seen, reached in zip(case.seen.modes, case.reached.modes, strict=True):
        if seen.pole.imag < -1e-9:
            continue
        fate = text("decays") if seen.stable else text("grows")
        rows.append((mode_name(seen), fate, _bar(seen), _bar(reached)))
    hidden = case.unseen or case.unmoved
    words = pole_words(list(hidden))
    weakest = min((m for report in (case.seen, case.reached) for m in report.modes), key=lambda m: m.margin)
    near = text("No mode is hidden, but the nearest is only {distance:.1g} from it.", distance=weakest.distance)
    caption = (
        claim(text("No mode is hidden: every distance is well above zero."), weakest.margin, above=CLEARLY_ABOVE_ZERO, otherwise=near)
        if not hidden
        else text("Hidden from the sensor: {words}.", words=words)
        if case.unseen
        else text("Out of reach of the force: {words}.", words=words)
    )
    return TableFigure(
        "margins", text("PBH distance of each mode from being hidden"),
        (text("mode"), text("by itself"), text("from y"),
         text("from u")), tuple(rows[:MOST_ROWS]), tab=MODES_TAB, caption=caption)


def lights_of(checks: Sequence[Check]) -> TableFigure:
    """The checks as lights."""
    lit = sum(check.holds for check in checks)
    return TableFigure(
        "lights", text("lights"), (text("statement"), text("holds")),
        tuple((check.text, YES if check.holds else NO) for check in checks), tab=MODES_TAB,
        caption=text("{lit} of {count} hold for the plant and gains shown now.", lit=lit, count=len(checks)))


@lru_cache(maxsize=8)
def blocks_of(case: Case) -> MatrixFigure:
    """The Kalman decomposition as a heat map with its blocks."""
    d = case.decomposition
    n, m, p = d.A.shape[0], d.B.shape[1], d.C.shape[0]
    whole = np.block([[d.A, d.B], [d.C, np.zeros((p, m))]])
    edges = tuple(k for k in accumulate(d.sizes) if 0 < k < n)
    shown = d.sizes[0]
    if d.sizes[1]:
        block = text("The last block is the motion that the sensor does not see. The force reaches it; its column in the row of y is "
                     "empty.")
    elif d.sizes[2]:
        block = text("The last block is the motion that the force does not reach. The sensor sees it; its row in the column of u is "
                     "empty.")
    else:
        block = NO_WORDS
    caption = (text("z₁ … {shown} are reached and seen. {block}",
                    shown=symbol(f'z{shown}'), block=block) if block.id
               else text("One block: every state is reached and seen."))
    return MatrixFigure("decomposed", text("Kalman decomposition"), whole,
                        (*numbered("z", n), *numbered("y", p)), (*numbered("z", n), *numbered("u", m)), (*edges, n),
                        caption=caption, tab=MODES_TAB)


def numbered(letter: str, count: int) -> tuple[str, ...]:
    """y, or y1, y2, …: one name each."""
    return (letter,) if count == 1 and letter != "z" else tuple(f"{letter}{i + 1}" for i in range(count))


def random_poles(case: Case, seed: int, observer: bool) -> np.ndarray:
    """Poles of A − LC (observer) or A − BK for random gains, (RANDOM_GAINS, n)."""
    draws = np.random.default_rng(seed).normal(size=(RANDOM_GAINS, case.model.plant.n)) * GAIN_SIGMAS
    plant = case.model.plant
    turned = draws[:, :, None] * plant.C if observer else plant.B * draws[:, None, :]
    return np.linalg.eigvals(plant.A - turned)


def cloud_figure(poles: np.ndarray, bolts: tuple[complex, ...], gain: str, across: tuple[float, float], up: float,
                 words: Callable[[float], Text], far: float = np.inf) -> PlaneFigure:
    """Poles under random gains L or K, as far as `far`: what no gain moves stays under its bolt; `words` of the best rightmost pole."""
    points = tuple(Point(float(p.real), float(p.imag), "second", "dot") for p in poles.ravel() if abs(p) < far)
    points += tuple(Point(p.real, p.imag, "reference", "bolt") for p in bolts)
    name, title = (("every_observer", text("eig(A − LC) for random L")) if gain == "L" else
                   ("every_controller", text("eig(A − BK) for random K")))
    return PlaneFigure(name, title, (), points, "Re s", "Im s", across, (-up, up), unstable=True, tab=EVERY_TAB,
                       caption=words(float(np.min(np.max(np.real(poles), axis=1)))))


@lru_cache(maxsize=32)
def case_clouds(case: Case, seed: int) -> tuple[Figure, ...]:
    """Poles of the lesson's plants under random gains L, and K."""
    def cloud(gain: str, bolts: tuple[complex, ...]) -> PlaneFigure:
        def words(least: float) -> Text:
            if bolts:
                return text("{draws} gains {gain} drawn at random. The best of them has its rightmost pole at {least:.3g}, at the fixed "
                            "mode or to its right.", draws=RANDOM_GAINS, gain=gain, least=least)
            return text("{draws} gains {gain} drawn at random. The best of them has its rightmost pole at {least:.3g}.", draws=RANDOM_GAINS,
                        gain=gain, least=least)
        return cloud_figure(random_poles(case, seed, gain == "L"), bolts, gain, (-10.0, 4.0), 7.0, words)
    return cloud("L", case.unseen), cloud("K", case.unmoved)
