"""Define the knobs of lesson 2, on a spring-damper."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Poles, Track
from observer_lab.plants import MODELS
from observer_lab.text import same, text

from ..toolkit.knobs import pull_knobs, run_knobs
from .notes_page import NONE, REPORT_LINES

MODEL = MODELS["spring-damper"]
OBSERVER_WINDOW = MODEL.observer_window
HORIZON, DT = 15.0, 0.03
MOST_FORCE = 2.0
BY_POLES, BY_NUMBERS = "poles", "numbers"
AS_PRINTED, NO_FORCE = "printed", "none"
POSITION, ACCELEROMETER, FORGOTTEN = "position", "accelerometer", "forgotten"
KNOBS = (
    Choice("input", "u", text("force"), default="sine", options=(
        (NO_FORCE, text("none")), ("step", text("step")), ("sine", text("sine")),
        ("square", text("square wave")), ("random", text("random")), ("hand", text("your own hand"))),
        hint=text("The plant and the observer get the same force.")),
    Number("amplitude", r"u_0", text("amplitude"), "N", low=0.0, high=MOST_FORCE, default=1.0, step=0.05,
           when=("input", ("step", "sine", "square", "random")),
           hint=text("1 N held for long stretches the spring by 1 m.")),
    Number("frequency", "f", text("frequency"), "Hz", low=0.02, high=1.0, default=0.15, step=0.01,
           when=("input", ("sine", "square")),
           hint=text("The block swings most near 0.15 Hz.")),
    Number("seed", r"s_0", text("random seed"), low=0, high=9999, default=1, scale="integer",
           when=("input", ("random",)), hint=text("The same seed gives the same force.")),
    Track("hand", "u", text("force by hand"), "N", low=-MOST_FORCE, high=MOST_FORCE, when=("input", ("hand",)),
          hint=text("Press play and move this: your hand is recorded.")),
    Choice("method", "L", text("gain by"), default=BY_POLES, options=(
        (BY_POLES, text("dragging poles")), (BY_NUMBERS, text("typing numbers")),
        (AS_PRINTED, text("the notes, as printed"))),
        hint=text("The last choice runs matrix and gain exactly as the notes print them.")),
    Poles("observer_poles", "q", text("Observer poles"), "rad/s", default=MODEL.observer_poles,
          re_low=OBSERVER_WINDOW.re_low, re_high=OBSERVER_WINDOW.re_high, im_high=OBSERVER_WINDOW.im_high, role="estimate",
          when=("method", (BY_POLES,)), hint=text("The eigenvalues of A − LC; the engine finds L.")),
    Number("l1", r"l_1", same("l₁"), "1/s", low=-5.0, high=10.0, default=1.0, step=0.05, when=("method", (BY_NUMBERS,)),
           hint=text("How strongly y − ŷ corrects the position.")),
    Number("l2", r"l_2", same("l₂"), "1/s²", low=-10.0, high=20.0, default=0.0, step=0.05, when=("method", (BY_NUMBERS,)),
           hint=text("How strongly y − ŷ corrects the velocity.")),
    Choice("sensor", "y", text("what is measured"), default=POSITION, when=("method", (BY_POLES, BY_NUMBERS)), options=(
        (POSITION, text("position, y = C x")), (ACCELEROMETER, text("accelerometer, y = C x + D u")),
        (FORGOTTEN, text("the same, ŷ without D u"))),
        hint=text("The force acts on the reading of an accelerometer at once.")),
    Number("guess_q", r"\hat q(0)", text("guessed position"), "m", low=-2.0, high=2.0, default=0.0, step=0.05,
           hint=text("The block really starts at 1 m.")),
    Number("guess_v", r"\hat v(0)", text("guessed velocity"), "m/s", low=-2.0, high=2.0, default=0.0, step=0.05,
           hint=text("The block really starts at rest.")),
    Choice("line", "", text("line of the notes in doubt"), default=NONE, options=REPORT_LINES,
           hint=text("The tab Notes shows where this line leads.")),
    run_knobs(HORIZON)[1],
    *pull_knobs(MODEL),
)
