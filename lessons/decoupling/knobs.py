"""Define the knobs of lesson 11: three loops, the mixing and its band, ground and sensors."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Poles, Switch
from observer_lab.plants.platform import siso_loops as siso
from observer_lab.text import text, text_in

from ..toolkit.knobs import run_knobs
from .loops import (
    A_EDGE,
    B_EDGE,
    BEST_MIX,
    BY_GAIN,
    BY_POLES,
    FALLING,
    HORIZON,
    NO_MIX,
    OPEN_LOOP,
    OWN_MIX,
    PUBLISHED_LOOP,
    SHAPED_LOOP,
    WHITE,
)
from .sensors import GEOPHONE, IDEAL
from .study import CONTROL_HIGH, CONTROL_IM, CONTROL_LOW, OBSERVER_HIGH, OBSERVER_IM, OBSERVER_LOW

MIXING = text("Mixing and its band")
WORLD = text("Ground and sensors")
KNOBS = (
    Choice("vertical", "", text("vertical loop"), default=PUBLISHED_LOOP,
           options=((PUBLISHED_LOOP, text("C_v as printed")), (SHAPED_LOOP, text("shaped by hand")),
                    (OPEN_LOOP, text("open"))),
           hint=text("The controller from vertical velocity to vertical force.")),
    Number("gain_v", "k_v", text("vertical gain"), "N s/m", low=10.0, high=1e5, default=2000.0, scale="log",
           when=("vertical", (SHAPED_LOOP,)), hint=text("Newtons for each metre per second.")),
    Number("lag", r"\omega_i", text("more gain below"), "rad/s", low=0.0, high=5.0, default=0.0, step=0.1,
           when=("vertical", (SHAPED_LOOP,)), hint=text("A lag: up to 20 times the gain below this corner; 0: none.")),
    Number("lead", "f_l", text("phase lead at"), "Hz", low=0.0, high=100.0, default=0.0, step=1.0,
           when=("vertical", (SHAPED_LOOP,)), hint=text("A lead of a decade about this frequency; 0: none.")),
    Number("roll_off", "f_r", text("roll-off above"), "Hz", low=1.0, high=2000.0, default=1000.0, scale="log",
           when=("vertical", (SHAPED_LOOP,)), hint=text("The gain falls above this frequency; too low, and the phase "
                                                   "is spent.")),
    Choice("horizontal", "", text("horizontal loop"), default=PUBLISHED_LOOP,
           options=((PUBLISHED_LOOP, text("C_h as printed")), (BY_POLES, text("poles by A E + B F = Φ")),
                    (BY_GAIN, text("a pure gain")), (OPEN_LOOP, text("open"))),
           hint=text("The controller from horizontal velocity to horizontal force; dragging a pole selects the second.")),
    Number("gain_h", "k_h", text("horizontal gain"), "N s/m", low=10.0, high=1e5, default=2000.0, scale="log",
           when=("horizontal", (BY_GAIN,)), hint=text("Newtons for each metre per second.")),
    Poles("control_poles", "p", text("Roots of Φ, first four"), "rad/s", default=siso.AT_WILL[0],
          re_low=CONTROL_LOW, re_high=CONTROL_HIGH, im_high=CONTROL_IM, role="plant", when=("horizontal", (BY_POLES,)),
          hint=text("Four of the eight poles of the horizontal loop.")),
    Poles("observer_poles", "q", text("Roots of Φ, last four"), "rad/s", default=siso.AT_WILL[1],
          re_low=OBSERVER_LOW, re_high=OBSERVER_HIGH, im_high=OBSERVER_IM, role="estimate", when=("horizontal", (BY_POLES,)),
          hint=text("The other four; E and F do not tell which is which.")),
    Switch("pitch", "", text("close the pitch loop"),
           hint=text("A gain from the difference of the vertical sensors to the difference of the vertical coils.")),
    Number("bandwidth", r"\Delta\omega", text("pitch bandwidth"), "rad/s", low=0.1, high=50.0, default=0.5,
           scale="log", when=("pitch", (True,)),
           hint=text("Width of the band about the pitch mode in which the loop acts.")),
    Choice("mix", "", text("mixing S"), default=NO_MIX, group=MIXING,
           options=((NO_MIX, text_in("decoupling", "none")), (OWN_MIX, text("by hand")), (BEST_MIX, text("least J"))),
           hint=text("S = [1 b; a 1] between the last two virtual inputs and the coils.")),
    Number("a", "a", text("differential force into horizontal, a"), low=-A_EDGE, high=A_EDGE, default=0.0,
           step=0.01, group=MIXING, when=("mix", (OWN_MIX,)), hint=text("Newtons of u3 for each newton of "
                                                                    "differential force.")),
    Number("b", "b", text("horizontal into differential force, b"), low=-B_EDGE, high=B_EDGE, default=0.0,
           step=0.01, group=MIXING, when=("mix", (OWN_MIX,)), hint=text("Newtons of differential force for each "
                                                                    "newton of v3.")),
    Number("f_low", "f_1", text("J from"), "Hz", low=0.1, high=4.0, default=0.1, scale="log", group=MIXING,
           hint=text("Lower end of the band over which J is summed.")),
    Number("f_high", "f_2", text("J up to"), "Hz", low=0.5, high=30.0, default=10.0, scale="log", group=MIXING,
           hint=text("Upper end of the band over which J is summed.")),
    Number("lower", r"\Delta h", text("coil below the spring's line"), "mm", low=-20.0, high=20.0, default=0.0, step=0.5, group=WORLD,
           hint=text("How far the horizontal coil pushes below the line in which the horizontal spring pulls.")),
    Choice("ground", "", text("ground motion"), default=WHITE, group=WORLD,
           options=((WHITE, text("white, 1 µm/√Hz")), (FALLING, text("falling as "
                                                                                                   "1/f²"))),
           hint=text("White as in the report's design, or falling, which meets two of its three peaks without control.")),
    Number("noise", r"\sigma_v", text("sensor noise"), "m/s/√Hz", low=1e-12, high=1e-6, default=1e-9, scale="log",
           group=WORLD, hint=text("One-sided amplitude density of each of the four sensors.")),
    Choice("sensors", "", text("sensors"), default=IDEAL, group=WORLD,
           options=((IDEAL, text("read any velocity")), (GEOPHONE, text("geophones"))),
           hint=text("A geophone reads velocity above its corner frequency only.")),
    Number("corner", "f_c", text("corner of the geophones"), "Hz", low=0.01, high=2.0, default=0.1, scale="log", group=WORLD,
           when=("sensors", (GEOPHONE,)), hint=text("Natural frequency of the mass inside. Below it the reading falls as f².")),
    Number("knee", "f_n", text("noise rises below"), "Hz", low=0.0, high=10.0, default=0.0, step=0.1, group=WORLD,
           when=("sensors", (GEOPHONE,)), hint=text("Density of the sensor noise times 1 + f_n/f; 0: white.")),
    Switch("tilt", "", text("horizontal geophones react to tilt"), group=WORLD, when=("sensors", (GEOPHONE,)),
           hint=text("A tilt θ looks like the acceleration g θ.")),
    *run_knobs(HORIZON),
)
