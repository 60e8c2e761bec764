"""Compare figures 13–25 of the report with ours: levels, differences in dB, and its two values of V."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from observer_lab.course.figures.records import TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.plants.platform.lqg_weights import FIGURE_V, LITERAL_V, LOOSE_V
from observer_lab.text import Text, format_number, joined, same, text, text_in

from .controllers import DECOUPLED, LQE, OPEN_LOOP, ORDER, RECURSIVE, SHORT_NAMES, SISO, players
from .score_tables import HEADS
from .simulation import BAND_HZ, analyse, band_rms
from .study import Study
from .suppression import TIED

REPORT_TAB = text("Report")
VERTICAL, ROTATION, HORIZONTAL, LEFT, RIGHT = range(5)  # columns of the densities; the sensor HL is the horizontal channel
SIGNALS = (text_in("channel", "vertical"), text_in("channel", "rotation"), text_in("channel", "horizontal"), same("VL"), same("VR"))
FIGURE_24_DB = 30.0  # from 1e-12 with SISO to 1e-15 with the full LQG
SAME_SIZE_DB = 3.0


@dataclass(frozen=True)
class Level:
    """A peak in the report's text: figure, controller, columns, and its range in (m/s)²/Hz."""

    figure: int
    player: str
    columns: tuple[int, ...]
    low: float
    high: float


@dataclass(frozen=True)
class Lead:
    """A difference in the report's text: how many dB `player` is below `beside` in a column, as a range."""

    figure: int
    player: str
    beside: str
    column: int
    low: float
    high: float


LEVELS = (
    Level(14, OPEN_LOOP, (LEFT,), 1e-10, 1e-10),
    Level(14, LQE, (LEFT,), 1e-13, 1e-12),
    Level(19, RECURSIVE, (LEFT, HORIZONTAL, RIGHT), 1e-17, 1e-15),
    Level(20, DECOUPLED, (HORIZONTAL,), 1e-16, 1e-15),
    Level(21, DECOUPLED, (ROTATION,), 1e-15, 1e-15),
    Level(23, LQE, (HORIZONTAL,), 1e-15, 1e-15),
    Level(24, SISO, (ROTATION,), 1e-12, 1e-12),
    Level(24, LQE, (ROTATION,), 1e-15, 1e-15),
)
LEADS = (
    Lead(13, LQE, OPEN_LOOP, HORIZONTAL, 10.0, 20.0),
    Lead(14, LQE, OPEN_LOOP, LEFT, 20.0, 30.0),
    Lead(20, DECOUPLED, OPEN_LOOP, HORIZONTAL, 10.0, 20.0),
    Lead(21, LQE, DECOUPLED, ROTATION, 5.0, 10.0),
    Lead(23, LQE, SISO, HORIZONTAL, 0.0, 0.0),
    Lead(24, LQE, SISO, ROTATION, FIGURE_24_DB, FIGURE_24_DB),
)
SPOKEN_OF = ((LOOSE_V, text("figures 13–15")), (FIGURE_V, text("figures 13–15")), (LITERAL_V, text("σ_v = 10⁻⁹ of (77), squared")))


def report_tables(outcome: Outcome[Study]) -> tuple[TableFigure, ...]:
    """Levels, differences and the two values of V."""
    return _levels(outcome.study), _leads(outcome.study), _noises(outcome)


def peak(m: Study, player: str, columns: tuple[int, ...]) -> float | None:
    """The highest density over 0.5–3 Hz of a player in (m/s)²/Hz; None where its loop is unstable."""
    s = m.spectra[ORDER.index(player)]
    inside = (m.f >= BAND_HZ[0]) & (m.f <= BAND_HZ[1])
    return 1e-12 * float(s.density[inside][:, columns].max()) if s.stable else None


def above(ours: float, low: float, high: float) -> float:
    """Level above a range of levels in dB; 0 within the range."""
    return 10 * float(np.log10(ours / min(max(ours, low), high)))


def _levels(m: Study) -> TableFigure:
    rows = tuple(_level(m, level) for level in LEVELS)
    return TableFigure("report_levels", text("highest point over 0.5–3 Hz in (m/s)²/Hz"),
                       (text("figure"), text("signal"), text("controller"), text("report"), text("ours"), text("ours above [dB]")), rows,
                       tab=REPORT_TAB, caption=text("The report calls the loops of figures 14 and 19 equal, yet its levels differ by 20 dB "
                                                    "or more. Its chapter 5 prints (m/s²)²/Hz, but its outputs are velocities."))


def _level(m: Study, level: Level) -> tuple[Text | str, ...]:
    ours = peak(m, level.player, level.columns)
    signal = SIGNALS[level.columns[0]] if len(level.columns) == 1 else text("highest sensor")
    printed = _range(level.low, level.high, ".0e")
    db = 0 if ours is None else round(above(ours, level.low, level.high)) + 0
    found = ("–", "–") if ours is None else (format_number(ours, ".1e"), format_number(db, "+.0f"))
    return (str(level.figure), signal, SHORT_NAMES[ORDER.index(level.player)], printed, *found)


def _range(low: float, high: float, form: str) -> str:
    return format_number(low, form) if low == high else f"{format_number(low, form)} … {format_number(high, form)}"


def lead(m: Study, one: Lead) -> float | None:
    """Reduction in dB of the area over 0.5–3 Hz, one controller against another; None if one is unstable."""
    i, j = ORDER.index(one.player), ORDER.index(one.beside)
    if not (m.spectra[i].stable and m.spectra[j].stable):
        return None
    lower, upper = band_rms(m.f, np.stack([m.spectra[k].density[:, one.column] for k in (i, j)], axis=1), *BAND_HZ)
    return 20 * float(np.log10(upper / lower))


def _leads(m: Study) -> TableFigure:
    rows = tuple((str(one.figure), SIGNALS[one.column],
                  text("{lower} below {upper}", lower=SHORT_NAMES[ORDER.index(one.player)], upper=SHORT_NAMES[ORDER.index(one.beside)]),
                  _range(one.low, one.high, ".0f"), "–" if (ours := lead(m, one)) is None else format_number(ours, ".1f")) for one in LEADS)
    return TableFigure("report_leads", text("one controller below another in dB; ours: area over 0.5–3 Hz"),
                       (text("figure"), text("signal"), text("controllers"), text("report"), text("ours")), rows,
                       tab=REPORT_TAB, caption=said_of_figure_24(m))


def said_of_figure_24(m: Study) -> Text:
    """Whether its order and its size come out here."""
    order = [ORDER.index(name) for name in (LQE, DECOUPLED, SISO)]
    if not all(m.spectra[i].stable for i in order):
        return text("Not all loops of figure 24 are stable with these settings.")
    full, part, siso = (float(m.band_db[i, ROTATION]) for i in order)
    if not (full > part + TIED and part > siso + TIED):
        return text("The order of figure 24 in rotation does not come out with these settings.")
    if abs(full - siso - FIGURE_24_DB) < SAME_SIZE_DB:
        return text("Order and size of figure 24 come out with these settings.")
    return text("In rotation the order of figure 24 comes out, but not its size. The full LQG leads the SISO loops by {ours:.1f} dB, "
                "in the report by {printed:.0f} dB.", ours=full - siso, printed=FIGURE_24_DB)


def lowered(m: Study, v: float) -> np.ndarray | None:
    """How far the full LQG made for V brings the peaks of the channels down in this world, in dB; None where it is unstable."""
    made = analyse(m.world, players(v, "own")[ORDER.index(LQE)], m.more)
    if not made.stable:
        return None
    inside = (m.f >= BAND_HZ[0]) & (m.f <= BAND_HZ[1])
    return 10 * np.log10(m.spectra[0].density[inside, :3].max(axis=0) / made.density[inside, :3].max(axis=0))


def _noises(outcome: Outcome[Study]) -> TableFigure:
    m, used = outcome.study, outcome.design["v"]
    rows = [(format_number(v, ".0e"), where, *_lowered(m, v)) for v, where in SPOKEN_OF]
    rows.append((format_number(used, ".1e"), text("in use here"), *_lowered(m, used)))
    strict, loose = lowered(m, FIGURE_V), lowered(m, LOOSE_V)
    said = text("The report prints σ_v = 10⁻⁹, so V = 10⁻¹⁸, but labels its figures V = 10⁻⁹ and 10⁻⁶.")
    if strict is not None and loose is not None:
        up, turn, side = (strict - loose).tolist()
        said = joined(said, text("Beside 10⁻⁶, 10⁻⁹ changes the suppression of the peaks by {up:+.1f}, {turn:+.1f} and {side:+.1f} dB.",
                                 up=up, turn=turn, side=side))
    return TableFigure("report_noise", text("peaks lowered by the full LQG in dB, by the V in its design"),
                       (same("V"), text("where"), *HEADS), tuple(rows), tab=REPORT_TAB, caption=said)


def _lowered(m: Study, v: float) -> tuple[Text | str, ...]:
    db = lowered(m, v)
    return (text("unstable"),) * 3 if db is None else tuple(format_number(x, ".1f") for x in db)
