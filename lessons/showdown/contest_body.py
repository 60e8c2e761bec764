"""Draw the two decks of the contest with their controllers, their bars and what acts on them."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import isfinite
from types import MappingProxyType

from observer_lab.colours import COLOURS
from observer_lab.plants.bodies.body import UNCONTROLLED, Body, called, with_longer_arrows
from observer_lab.plants.bodies.two_decks import two_decks
from observer_lab.plants.platform import model
from observer_lab.text import format_number, text

from .controllers import CONTROLLER_NAMES, CONTROLLER_ROLES, LQE, ORDER, SISO
from .knobs import IN_BAND, LATE, MOST_DELAY_MS, OF_RUN, REDUCED, WHOLE

MOTION_GAIN = 1000.0  # times that the stage exaggerates motion: 20 µm are drawn as 0.15
FORCE_ARROWS = 20.0  # times that coil forces are drawn larger: tens of millinewtons here
NAMES = tuple(replace(name, part="spring left", at=(0.0, 0.0, 0.6), away=(-0.75, -0.3, 0.3)) if name.part == "seat left" else
              replace(name, away=(0.9, -0.3, 0.2)) if name.ghost else name
              for name in called(model.body(), UNCONTROLLED))  # the seat stands behind a rail
DECK = replace(with_longer_arrows(model.body(), FORCE_ARROWS, 3), gain=MOTION_GAIN, names=NAMES,
               ghost="dimmed",
               caption=text("Above: the controller chosen. Below: another one to compare. Grey ghosts: the same decks without control. "
                            "Green: coil forces. Coloured bars: with control. Grey bars: without control"))
FULL_BAR_UM_S, FULL_BAR_SHAPED_UM_S, FULL_BAR_DB = 200.0, 20.0, 60.0  # of a full bar: velocity on white and on shaped ground; reduction
WANTED_DB = 20.0  # that has a mark on the rails
DELAY_AT, DAMPING_AT, FRICTION_AT = (2.1, -0.7, 1.95), (-0.72, -0.7, 1.0), (0.5, -0.9, 0.72)  # at coil, dashpot and guide
OF_THIS_RUN = text("RMS velocity after 1 s; grey: without control"), "µm/s"
BARS = MappingProxyType({
    OF_RUN: OF_THIS_RUN, LATE: OF_THIS_RUN, IN_BAND: (text("RMS velocity, 0.5–3 Hz; grey: without control"), "µm/s"),
    WHOLE: (text("RMS velocity, all frequencies; grey: without control"), "µm/s"),
    REDUCED: (text("rotation, reduction in 0.5–3 Hz; mark: 20 dB"), "dB")})

BETTER = MappingProxyType({  # by whether a long bar is good, and whether there are rings
    (False, False): text("shorter is better"), (False, True): text("shorter is better; ring: at the start"),
    (True, False): text("longer is better"), (True, True): text("longer is better; ring: at the start")})


def rival_of(chosen: str) -> str:
    """The controller of the lower deck: the full LQG, or the SISO loops where the full LQG is chosen."""
    return SISO if chosen == LQE else LQE


@lru_cache(maxsize=4 * len(ORDER))
def body_of(chosen: str, delay: float = 0.0, damping: float = 0.0, friction: float = 0.0, bars: str = OF_RUN,
            rings: tuple[float, ...] = (), lost: tuple[bool, bool] = (False, False)) -> Body:
    """Two decks with the names of their controllers; delay (ms), change of damping (%) and friction (mN) are named where they act.

    `rings` are the shares of both bars at the start; of a deck that is `lost` the name says that its loop is unstable.
    """
    who = [ORDER.index(each) for each in (chosen, rival_of(chosen))]
    upper, lower = (text("{name}: unstable", name=CONTROLLER_NAMES[i]) if gone else CONTROLLER_NAMES[i]
                    for i, gone in zip(who, lost, strict=True))
    above, below = (COLOURS[CONTROLLER_ROLES[i]] for i in who)
    tags = ((delay, text("delay {size} ms", size=format_number(delay, ".3g")), DELAY_AT),
            (damping, text("damping {size} %", size=format_number(damping, "+.3g")), DAMPING_AT),
            (friction, text("friction {size} mN", size=format_number(friction, ".3g")), FRICTION_AT))
    title, unit = BARS[bars]
    lane = text("computing delay: {size} ms (lane: {full} ms)", size=format_number(delay, ".3g"), full=format_number(MOST_DELAY_MS, ".3g"))
    return two_decks(DECK, 10, 3, (upper, lower), (title, BETTER[bars == REDUCED, bool(rings)]),
                     lambda value: f"{format_number(value, '.3g')} {unit}" if isfinite(value) else "—",
                     tuple((words, at) for size, words, at in tags if size),
                     (WANTED_DB / FULL_BAR_DB,) if bars == REDUCED else (), bars != REDUCED, (above, below), rings,
                     (delay / MOST_DELAY_MS, lane) if bars == LATE else None)
