"""Define the knobs of lesson 15 for an own plant."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Knob, Number, Poles
from observer_lab.text import same, text

from .knobs import ERRORS_GROUP, NORMS, SEARCH, weight_knobs
from .own_plant import Here

WANTED_GROUP = text("What is wanted")


def own_knobs(here: Here) -> tuple[Knob, ...]:
    """What is wanted, the order and its poles, how wrong the model is, and what J and RLO are told."""
    model, orders = here.model, [order for order, _ in here.starts]
    c, o = model.controller_window, model.observer_window
    speed = -o.re_low
    return (
        Choice("wanted", "", text("the observer is to give"), default=here.wanted[0][0], options=here.wanted, group=WANTED_GROUP,
               hint=text("A row of K is fed back through the observer, all other inputs from the true state; a "
                         "state is only watched.")),
        Poles("controller_poles", "p", text("Controller poles, which give K"), "rad/s",
              default=model.controller_poles, re_low=c.re_low, re_high=c.re_high, im_high=c.im_high, role="plant", group=WANTED_GROUP,
              hidden=not model.controller_poles, hint=text("eig(A − BK): dragging them changes K.")),
        Choice("order", "q", text("order of the observer"), default=str(orders[0]), group=WANTED_GROUP, hidden=len(orders) == 1,
               options=tuple((str(q), same(str(q))) for q in orders),
               hint=text("From the lowest order that these poles allow up to n less the rank of C.")),
        *(Poles(f"poles_{q}", "s", text("Observer poles"), "rad/s", default=poles, re_low=o.re_low, re_high=o.re_high,
                im_high=o.im_high, role="estimate", when=("order", (str(q),)), group=WANTED_GROUP,
                hint=text("Drag them and watch J and the error.")) for q, poles in here.starts),
        Number("delta_a", r"\delta_a", text("error of every entry of A"), "%", low=0.0, high=50.0, default=5.0, step=0.5,
               group=ERRORS_GROUP, hint=text("Every entry of the true A is this much larger or smaller.")),
        Number("delta_c", r"\delta_c", text("error of every entry of C"), "%", low=0.0, high=20.0, default=2.0, step=0.5,
               group=ERRORS_GROUP, hint=text("Every entry of the true C is this much larger or smaller.")),
        Number("signs", "", text("signs of the errors"), low=0, high=20, default=1, scale="integer", group=ERRORS_GROUP,
               hint=text("0: every entry is larger; 1 to 20: signs drawn at random.")),
        Number("push", "v", text("amplitude of v"), model.input_unit, low=0.0, high=5 * model.u_max, default=model.u_max,
               group=ERRORS_GROUP, hint=text("v = a sin ωt with three periods in the run.")),
        Choice("norm", "", text("norm in J"), default="2", group=SEARCH,
               when=("order", tuple(str(q) for q in orders if q > 1)),
               options=tuple((name, same("∞" if name == "inf" else name)) for name in NORMS),
               hint=text("Column sum, spectral or row sum norm; for order 1 all three agree.")),
        *weight_knobs(),
        Number("region_low", "a", text("region for RLO, left end"), "rad/s", low=-1.5 * speed, high=-0.5 * speed,
               default=-speed, group=SEARCH, hint=text("RLO keeps every pole right of this.")),
        Number("region_high", "b", text("region for RLO, right end"), "rad/s", low=-0.45 * speed, high=-0.002 * speed,
               default=-0.02 * speed, group=SEARCH, hint=text("RLO keeps every pole left of this.")),
        Number("region_tall", "c", text("region for RLO, largest |Im s|"), "rad/s", low=0.0, high=o.im_high,
               default=0.0, group=SEARCH,
               hint=text("0: real poles only. Pairs take RLO longer.")),
    )
