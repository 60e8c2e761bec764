"""Compute a design of lesson 11: mixing, controllers, spectra, one run and its stage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome, Stage
from observer_lab.engine.design import polynomial_roots
from observer_lab.engine.feedback import NoisyLoop
from observer_lab.engine.structure import mixing_matrix
from observer_lab.plants.bodies.body import UNCONTROLLED, Arrow, Body, ErrorMarks, called, force_arrow, with_longer_arrows
from observer_lab.plants.bodies.deck_body import DECK_HALF_WIDTH, FULL_FORCE_N, PLANE, RIGHTWARD, STAGE_SCALE, THICK
from observer_lab.plants.bodies.score_board import with_score_board
from observer_lab.plants.platform import model
from observer_lab.plants.platform import siso_loops as siso
from observer_lab.plants.platform.channels import HORIZONTAL, T_y
from observer_lab.text import Text, format_number, joined, text, text_in

from ..toolkit.latex import number
from .loops import (
    BY_POLES,
    MODEL,
    Controllers,
    Mixed,
    Shaken,
    Spectra,
    close,
    controllers,
    lower_of,
    mixed,
    rightmost,
    shaken,
    spectra,
    suppression,
)
from .sensors import knee_of, sensors_of

COIL, SIDE_FORCE, LOWER = 2, 5, 10  # places: of the coil's arrow, of the spring's force in the inputs, of the offset in the state
OFFSET_DRAWN = 5.0  # times that the coil's offset is drawn larger: millimetres on a deck of half a metre
BELOW = 0.0, 0.0, -9.0  # out of sight
WORDS_AT = DECK_HALF_WIDTH + 0.1, -0.72, PLANE + 0.36


def side_spring(x: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """Force (n_t,) in N of the horizontal spring and its damper on the deck; x (n_t, 10), ground (n_t, 2) vertical and horizontal in m.

    The ground is held from one sample to the next, so at a sample the deck and its coils have felt the ground of the sample before.
    """
    k = model.Parameters()
    felt = np.concatenate([[0.0], ground[:-1, 1]])
    return k.kx * (felt - x[:, 0] - k.h * x[:, 2]) - k.cx * (x[:, 5] + k.h * x[:, 7])


def with_force_lines(body: Body, times: float) -> Body:
    """The deck with its spring's force, drawn `times` larger, and the coil's arrow as far below that line as the coil is."""
    def drop(x: Sequence[float]) -> float:
        return OFFSET_DRAWN * STAGE_SCALE * float(x[LOWER])

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        drawn = list(body.arrows(x, u[:SIDE_FORCE], gain))
        coil, lower = drawn[COIL], drop(x)
        drawn[COIL] = replace(coil, tail=(*coil.tail[:2], coil.tail[2] - lower), head=(*coil.head[:2], coil.head[2] - lower))
        across, near, up = body.anchors(x, gain)[0]
        return (*drawn, force_arrow((across, near - 0.05, up - THICK / 2), RIGHTWARD, times * float(u[SIDE_FORCE]), FULL_FORCE_N,
                                    "disturbance"))

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        at = WORDS_AT if x[LOWER] else BELOW
        return ErrorMarks((), ((f"Δh = {format_number(1e3 * float(x[LOWER]), '.3g')} mm", at, "top-center"),))
    return replace(body, arrows=arrows, marks=marks)


CONTROL_LOW, CONTROL_HIGH, CONTROL_IM = -40.0, 5.0, 25.0
OBSERVER_LOW, OBSERVER_HIGH, OBSERVER_IM = -80.0, 5.0, 60.0
# of a design: what changes nothing in a loop whose S is given
BESIDE = ("mix", "a", "b", "f_low", "f_high", "ground", "knee", "seed", "kick")
AMPLIFICATIONS = ("amplification_vertical", "amplification_horizontal")  # largest transmissibility; none for an unstable loop
FORCE_ARROWS = 400.0  # times that coil forces are drawn larger: millinewtons here
UNSTABLE, NOTHING_DB = 1e3, 0.05  # dB: what stands for the peak of an unstable loop, which has none; a change that is none


def peak_words(db: float) -> str:
    """How far a peak lies above that without control, in words; a dash for an unstable loop."""
    return "—" if db >= UNSTABLE else "0 dB" if abs(db) < NOTHING_DB else f"{format_number(db, '+.3g')} dB"


MOTION_GAIN = 6000.0  # times that motion is drawn larger: micrometres and microradians here
ARROW_NAMES = ((text("force of the side spring"), (-2.0, -0.3, 2.02)), (text("coil forces"), (2.15, -0.3, 2.02)),
               (text("ground motion"), (0.0, -1.05, 0.0)))
DECK = replace(with_force_lines(with_longer_arrows(MODEL.body, FORCE_ARROWS, 3), FORCE_ARROWS), gain=MOTION_GAIN,
               names=called(MODEL.body, UNCONTROLLED), ghost="dimmed", labels=ARROW_NAMES,
               caption=text("Solid: with control. Grey ghost: the same platform without control. Green: coil forces. "
                              "Amber: the ground's motion and the force of the side spring"))
MOTIONS = text_in("channel", "vertical"), text_in("channel", "horizontal"), text_in("channel", "rotation")  # in the order of the rows
BODY = with_score_board(DECK, LOWER + 1, MOTIONS, text("peak of each motion; grey: without control"),
                        peak_words, 2.36, 0.14)


@dataclass(frozen=True, eq=False)
class Study:
    """Mixing, controllers, loop and the run of a design; spectra when they are looked at."""

    design: Design
    mixed: Mixed
    controllers: Controllers
    loop: NoisyLoop
    shaken: Shaken

    @cached_property
    def spectra(self) -> Spectra:
        """With control and without."""
        return spectra(self.loop, self.design["ground"], knee_of(self.design))

    @cached_property
    def transmissibility(self) -> np.ndarray:
        """|deck/ground| over the frequencies of `spectra`, vertical and horizontal (n_f, 2); none for an unstable loop."""
        return transmissibility(self.loop, self.spectra.f)

    @cached_property
    def down(self) -> np.ndarray:
        """Decibels by which the peaks of vertical, rotation and horizontal have come down."""
        return suppression(self.spectra)


def compute(design: Design) -> Outcome[Study]:
    """The mixing, the controllers y → u, the closed loop with its spectra, and one run on a shaking ground."""
    mix = mixed(design)
    lower = lower_of(design)
    built, loop, right, drift = _closed(replace(design, values=tuple(v for v in design.values if v[0] not in BESIDE)), mix.a, mix.b)
    run = shaken(loop, design)
    study, known = Study(design, mix, built, loop, run), {"rightmost": right, "drift": max(drift, -1.0)}
    metrics = LazyMap(lambda: _metrics(known, design, study), known)
    zeros = zeros_of(mix.a, mix.b, lower)
    own = built.whole.poles if built.whole.n else np.zeros(0, dtype=complex)
    return Outcome(design, {"S": mix.S}, {"loop": loop.poles, "controller": own, "zeros of P_h": zeros}, metrics,
                   LazySequence(lambda: _checks(metrics, drift, bool(design["pitch"]))), None,
                   _boards(design, zeros), _stage(study, lower, right),
                   LazySequence(lambda: _formulas(mix, built)), LazyValue(lambda: _live(metrics)), study)


def peak_decibels(study: Study, right: float) -> np.ndarray:
    """How many decibels the peaks of vertical, horizontal and rotation lie above those without control; UNSTABLE where `right` ≥ 0."""
    return np.full(3, UNSTABLE) if right >= 0 else -study.down[[0, 2, 1]]


def _stage(study: Study, lower: float, right: float) -> Stage:
    """Deck and bare deck, after their states the coil's offset and the peaks; forces of the coils, the ground's motion, the side
    spring's force."""
    run, above = study.shaken, peak_decibels(study, right)
    record = [lower, *np.where(above < UNSTABLE, 10 ** (above / 20), 0.0), *above]
    x, bare = (np.column_stack([states, np.tile(record, (len(states), 1))]) for states in (run.x, run.bare))
    return Stage(BODY, run.t, x, bare, np.column_stack([run.u, run.ground, side_spring(run.x, run.ground)]))


def transmissibility(loop: NoisyLoop, f: np.ndarray) -> np.ndarray:
    """|z/z_g| and |x/x_g| in the sensors' line, from true velocities: (n_f, 2), `f` in Hz."""
    H = np.abs(loop.response(f, loop.outputs(T_y[[0, 2]])))
    return H[:, [0, 1], [0, 1]] / (2 * np.pi * f[:, None])


@lru_cache(maxsize=16)
def _closed(design: Design, a: float, b: float) -> tuple[Controllers, NoisyLoop, float, float]:
    """The controllers of a design under a mixing, their loop, its rightmost pole and its drift."""
    built = controllers(design, mixing_matrix(a, b, size=3, channels=(1, 2)))
    loop = close(built.whole, design["noise"], lower_of(design), sensors_of(design))
    return built, loop, *rightmost(loop, built.whole)


@lru_cache(maxsize=32)
def zeros_of(a: float, b: float, lower: float) -> np.ndarray:
    """The zeros of the horizontal channel under a mixing."""
    S = mixing_matrix(a, b, size=3, channels=(1, 2))
    return polynomial_roots(siso.rigid_polynomials(HORIZONTAL, S, model.Parameters(lower=lower))[0])


def _metrics(known: Mapping[str, float], design: Design, study: Study) -> dict[str, float]:
    without, mix, built = known["rightmost"], study.mixed, study.controllers
    most = dict(zip(AMPLIFICATIONS, study.transmissibility.max(axis=0).tolist(), strict=True)) if known["rightmost"] < 0 else {}
    down = {name: float(v) for name, v in zip(("vertical", "rotation", "horizontal"), study.down, strict=True)}
    if design["pitch"]:
        apart = siso.from_channels(built.vertical, None, built.horizontal, mixing=mix.S)
        without = rightmost(close(apart, lower=lower_of(design), sensors=sensors_of(design)), apart)[0]
    return {
        **down, **known, **most, "rightmost_pitch_open": without, "J": min(mix.J, 1e9), "J_plain": mix.best.plain_J,
        "J_best": mix.best.J, "a": mix.a, "b": mix.b, "a_best": mix.best.a, "b_best": mix.best.b,
        "placement_residual": built.placed.residual if built.placed else 0.0,
    }


def _checks(m: Mapping[str, float], drift: float, closed: bool) -> tuple[Check, ...]:
    worst = max(m["rightmost"], drift)
    return (Check("stable", text("every pole of the loop lies on the left"), worst < 0, worst, informative=True),
            Check("claim", text("closing pitch leaves the loop stable") if closed else text("pitch is open, so closing it is not tried"),
                  m["rightmost"] < 0 or m["rightmost_pitch_open"] >= 0,
                  m["rightmost"]))


def _boards(design: Design, zeros: np.ndarray) -> tuple[Board, Board]:
    drawn = tuple(complex(z) for z in zeros if abs(z) > 1e-9)
    also = (("horizontal", BY_POLES),)
    return (
        Board("control", text("horizontal: first roots of Φ"), design["control_poles"],
              "control_poles", zeros=drawn, role="plant", side="left", re_low=CONTROL_LOW, re_high=CONTROL_HIGH,
              im_high=CONTROL_IM, also=also),
        Board("observer", text("horizontal: last roots of Φ"), design["observer_poles"],
              "observer_poles", zeros=drawn, role="estimate", side="right", re_low=OBSERVER_LOW, re_high=OBSERVER_HIGH,
              im_high=OBSERVER_IM, also=also),
    )


def _formulas(mix: Mixed, built: Controllers) -> tuple[Formula, ...]:
    out = [
        Formula("law", r"u = T_u\, S \,\mathrm{diag}(C_v, C_\theta, C_h)\, T_y\, y"),
        Formula("mixing", rf"S_{{23}} = \begin{{bmatrix}} 1 & {number(mix.b)} \\ {number(mix.a)} & 1 \end{{bmatrix}}, \quad "
                          rf"\det = {number(1 - mix.a * mix.b)}"),
        Formula("index", rf"J = \sum_\omega \frac{{|G'_{{23}}|^2}}{{|G'_{{22}}|^2}} + \frac{{|G'_{{32}}|^2}}{{|G'_{{33}}|^2}} = "
                         rf"{number(mix.J)}"),
    ]
    p = built.placed
    solved = rf", \quad E: {_column(p.E)}, \; F: {_column(p.F)}" if p else ""
    out.append(Formula("E", rf"A E + B F = \Phi{solved}", text("Coefficients from the highest power of s down, in "
                                                               "rad/s; the controller is −F/E.")))
    return tuple(out)


def _column(p: np.ndarray) -> str:
    """Coefficients as a column, two digits where they are large."""
    def entry(c: float) -> str:
        mantissa, exponent = f"{c:.1e}".split("e")
        return f"{c:.3g}" if 1e-3 <= abs(c) < 999.5 or c == 0 else rf"{mantissa} \cdot 10^{{{int(exponent)}}}"
    rows = r" \\ ".join(entry(float(c)) for c in p)
    return rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}"


def _live(m: Mapping[str, float]) -> Text:
    right, drift = (format_number(v, "+.3g") for v in (m["rightmost"], m["drift"]))
    if m["rightmost"] >= 0:
        return claim(text("Closing pitch has made the loop unstable: rightmost pole {right} rad/s.", right=right),
                     m["rightmost_pitch_open"], below=0.0, otherwise=text(
                         "The loop is unstable: rightmost pole {right} rad/s.", right=right))
    words = [f"{0.0 - round(v):+.0f} dB".replace("-", "−") for v in (m["vertical"], m["horizontal"], m["rotation"])]
    tail = claim(text("C_v keeps a pole at {drift} rad/s.", drift=drift), m["drift"], above=0.0)
    return joined(text("Peaks against no control: vertical {vertical}, horizontal {horizontal}, rotation {rotation}.",
                       vertical=words[0], horizontal=words[1], rotation=words[2]), tail)
