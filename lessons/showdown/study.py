"""Compute a design of lesson 13: spectra, responses and one noisy run of five controllers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine.sampled import MonteCarlo, ResponseMeasures
from observer_lab.plants.bodies.body import Body
from observer_lab.text import Text, listed, text

from ..toolkit.latex import number
from .contest_body import FULL_BAR_DB, FULL_BAR_SHAPED_UM_S, FULL_BAR_UM_S, body_of, rival_of
from .controllers import LQE, OPEN_LOOP, ORDER, RECURSIVE, SHORT_NAMES, Player, players
from .deck_bars import first_design, run_rms
from .equal_effort import Equal
from .friction import friction_of, rubbed
from .knobs import IN_BAND, LATE, OF_RUN, REDUCED
from .race import Raced
from .simulation import (
    BAND_HZ,
    Analysis,
    Response,
    World,
    analyse,
    band_rms,
    extra,
    loop_of,
    measures,
    points,
    respond,
    shake,
    without_control,
    world_of,
)

TOLERANCE = (5.0, 20.0, 5.0)  # %, %, mm where no error knob is turned
LEAST_CHANGE, LOST_SHARE = 0.01, 2.0  # of a full bar: less is no change; a run that leaves every bound


@dataclass(frozen=True, eq=False)
class Trials:
    """What was measured. noise: a Monte-Carlo of each player, None where its loop is unstable; learning: how far the
    recursive filter's run leaves the steady one's, relative (s, n): RMS of each whole second; decks (count, 5, 3): gain in
    dB over the band of each player on decks within the tolerance, NaN where unstable; costs (switches, 5, 3): change of
    the gain in dB by one switch alone, NaN where it makes the loop unstable; sizes: how far each was turned. rubbing (5, 3, 3): RMS of
    each player's channels over the band in µm/s without friction and with it, and how often each guide sticks; NaN where unstable.
    equal: all at one effort, None where the full LQG is unstable. raced: the ranking by runs, None where no limit and no friction acts.
    """

    noise: tuple[MonteCarlo | None, ...]
    learning: np.ndarray | None = None
    decks: np.ndarray | None = None
    tolerance: tuple[float, float, float] = TOLERANCE
    costs: np.ndarray | None = None
    sizes: tuple[float, ...] = ()
    rubbing: np.ndarray | None = None
    equal: Equal | None = None
    raced: Raced | None = None


WORK = (0.1, 10.0)  # Hz: the report's working band


@dataclass(frozen=True, eq=False)
class Study:
    """Everything about one design: five players in one world, the test (a `step` of the ground, or a touch) when it is looked at.
    `trials` is what the longer computation measured.

    run: t, states, forces on the stage; ghost: states without control; rival: states and forces of the deck below, another's.
    """

    world: World
    five: tuple[Player, ...]
    step: bool
    run: tuple[np.ndarray, np.ndarray, np.ndarray]
    ghost: np.ndarray
    rival: tuple[np.ndarray, np.ndarray]
    trials: Trials | None = field(default=None)

    @cached_property
    def more(self) -> tuple[float, ...]:
        """What the players' own resonances add to the frequencies."""
        return extra(self.world, self.five)

    @property
    def f(self) -> np.ndarray:
        """The frequencies (n_f,) of the spectra in Hz."""
        return points(self.world.parameters, self.more)

    @cached_property
    def spectra(self) -> tuple[Analysis, ...]:
        """Of each player, by transfer function."""
        return tuple(analyse(self.world, player, self.more) for player in self.five)

    @cached_property
    def stable(self) -> tuple[bool, ...]:
        """Whether each player's loop is."""
        return tuple(loop_of(self.world, player).stable for player in self.five)

    @cached_property
    def filters_apart(self) -> float | None:
        """How far the loops of steady and recursive filter differ in the working band at most, in dB; None where one is not stable."""
        lqe, recursive = self.spectra[ORDER.index(LQE)], self.spectra[ORDER.index(RECURSIVE)]
        if not (lqe.stable and recursive.stable):
            return None
        work = (self.f >= WORK[0]) & (self.f <= WORK[1])
        return float(np.abs(10 * np.log10(recursive.density[work, :3] / lqe.density[work, :3])).max())

    @cached_property
    def peak_db(self) -> np.ndarray:
        """How far each player brings the peak of each channel down (5, 3); 0 for a loop that is not stable."""
        inside = (self.f >= BAND_HZ[0]) & (self.f <= BAND_HZ[1])
        base = self.spectra[0].density[inside, :3].max(axis=0)
        return self._each(lambda S: 10 * np.log10(base / S[inside, :3].max(axis=0)))

    @cached_property
    def band_db(self) -> np.ndarray:
        """The same of the power in the band (5, 3)."""
        rms = self.band_rms(*BAND_HZ)
        return np.where(self._held[:, None], 20 * np.log10(rms[0] / np.where(self._held[:, None], rms, 1.0)), 0.0)

    def band_rms(self, low: float, high: float) -> np.ndarray:
        """The predicted rms of the channels between two frequencies in µm/s (5, 3); 0 for a loop that is not stable."""
        return self._rms([s.density[:, :3] for s in self.spectra], low, high)

    @cached_property
    def whole(self) -> np.ndarray:
        """The rms of every recorded signal, and of the forces in N (5, 8)."""
        return self._rms([s.density for s in self.spectra], 0.0, np.inf)

    @property
    def rms(self) -> np.ndarray:
        """Of the channels in µm/s (5, 3)."""
        return self.whole[:, :3]

    @property
    def forces(self) -> np.ndarray:
        """Of the forces (5, 3)."""
        return self.whole[:, 5:]

    @property
    def _held(self) -> np.ndarray:
        return np.array([s.stable for s in self.spectra])

    def _rms(self, densities: list[np.ndarray], low: float, high: float) -> np.ndarray:
        """Of every player and column at once; 0 for a loop that is not stable, whose density is."""
        return band_rms(self.f, np.hstack(densities), low, high).reshape(len(densities), -1)

    def _each(self, value: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        some = value(self.spectra[0].density)
        return np.array([value(s.density) if s.stable else 0 * some for s in self.spectra])

    @cached_property
    def responses(self) -> tuple[Response | None, ...]:
        """The test without noise, None for a loop that is not stable."""
        return tuple(respond(self.world, player, self.step) for player in self.five)

    @cached_property
    def measures(self) -> tuple[tuple[ResponseMeasures, ...] | None, ...]:
        """What is read off it, beside the deck without control."""
        reference = self.responses[0]
        assert reference is not None  # the deck alone is stable
        return tuple(None if r is None else measures(r, reference) for r in self.responses)


def _study(design: Design) -> Study:
    """All five players in the design's world, with three runs: of the chosen one, of none, and of the rival."""
    world, step = world_of(design), design["test"] == "step"
    five = players(design["v"], design["pair"])
    seed, kick = int(design["seed"]), design["kick"]
    chosen = five[ORDER.index(design["play"])]
    bare = (world, chosen) if chosen.id == OPEN_LOOP else (without_control(world), five[0])
    most, other = friction_of(design), rival_of(chosen.id)
    run, ghost, rival = ((rubbed(*who, seed, step, kick, most) if most else shake(*who, seed, step, kick))
                         for who in ((world, chosen), bare, (world, five[ORDER.index(other)])))
    return Study(world, five, step, run, ghost[1], rival[1:])


@lru_cache(maxsize=8)
def _first_bars(design: Design) -> tuple[float, float]:
    """The shares of both bars with noise and hardware as at the start."""
    upper, lower = barred(_study(design), design["bars"], (design["play"], rival_of(design["play"])))[0][:2].tolist()
    return upper, lower


def compute(design: Design) -> Outcome[Study]:
    """All five players in the design's world: spectra by transfer function, the test without noise, one noisy run."""
    match, who = _study(design), (design["play"], rival_of(design["play"]))
    metrics, bars, first = LazyMap(lambda: _metrics(match)), barred(match, design["bars"], who), first_design(design)
    rings = () if first == design or match.world.shaped else _first_bars(first)
    moved = any(abs(share - before) > LEAST_CHANGE for share, before in zip(bars[0], rings, strict=False))
    upper, lower = (not match.stable[ORDER.index(each)] for each in who)
    body = body_of(design["play"], design["delay"], design["damping"], 1e3 * friction_of(design), design["bars"], rings if moved else (),
                   (upper, lower))
    return Outcome(design, {}, {}, metrics, LazySequence(lambda: _checks(match, metrics)), None, (), _stage(match, body, bars),
                   LazySequence(lambda: _formulas(design, match)),
                   LazyValue(lambda: as_predicted(design, _ranking(match))), match)


def barred(m: Study, bars: str, who: tuple[str, str]) -> tuple[np.ndarray, np.ndarray]:
    """Shares and numbers (4,) of the bars of the upper and the lower deck, and the same without control; NaN where a loop is unstable."""
    places = [ORDER.index(each) for each in who]
    stable = np.array([m.stable[i] for i in places])
    full, least = FULL_BAR_SHAPED_UM_S if m.world.shaped else FULL_BAR_UM_S, 0.0
    if bars == REDUCED:
        values, bare, full = m.band_db[places, 1], 0.0, FULL_BAR_DB
    elif bars in (OF_RUN, LATE):
        t = m.run[0]
        values, bare, least = np.array([run_rms(t, m.run[1]), run_rms(t, m.rival[0])]), run_rms(t, m.ghost), LOST_SHARE
    else:
        found = m.band_rms(*BAND_HZ) if bars == IN_BAND else m.rms
        values, bare = found[places, 0], float(found[0, 0])
    return (np.concatenate([np.where(stable, np.maximum(values, 0.0) / full, least), np.where(stable, values, np.nan)]),
            np.array([bare / full, bare / full, bare, bare]))


def _stage(m: Study, body: Body, bars: tuple[np.ndarray, np.ndarray]) -> Stage:
    t, upper, above = m.run
    lower, below = m.rival
    with_control, without = (np.tile(each, (len(t), 1)) for each in bars)
    return Stage(body, t, np.hstack([upper, lower, with_control]), np.hstack([m.ghost, m.ghost, without]),
                 np.hstack([above, below]))


def _metrics(m: Study) -> dict[str, float]:
    found: dict[str, float] = {}
    for i, player in enumerate(m.five):
        found[f"{player.id}_stable"] = float(m.spectra[i].stable)
        for j, channel in enumerate(("vertical", "rotation", "horizontal")):
            found[f"{player.id}_{channel}_band_db"] = float(m.band_db[i, j])
            found[f"{player.id}_{channel}_peak_db"] = float(m.peak_db[i, j])
            found[f"{player.id}_{channel}_rms"] = float(m.rms[i, j])
        found[f"{player.id}_worst_db"] = float(m.band_db[i].min())
        found[f"{player.id}_force_rms"] = float(m.forces[i].max())
        measured = m.measures[i]
        if measured is not None:
            found[f"{player.id}_peak_force"] = measured[0].peak
            found[f"{player.id}_energy"] = measured[0].energy
    return found if m.filters_apart is None else {**found, "filters_apart_db": m.filters_apart}


def _checks(m: Study, metrics: Mapping[str, float]) -> tuple[Check, ...]:
    apart, worst = metrics.get("filters_apart_db", 99.0), metrics[f"{LQE}_worst_db"]
    unstable = [player.name for player, s in zip(m.five, m.stable, strict=True) if not s]
    return (
        Check("coincide", text("steady and recursive LQG within 0.5 dB, 0.1–10 Hz"),
              apart < 0.5, apart),
        Check("twenty", text("the full LQG gains 20 dB or more in every channel, 0.5–3 Hz"),
              worst >= 20, worst, informative=True),
        Check("stable", text("every loop is stable"), not unstable, float(len(unstable))),
    )


def _formulas(design: Design, m: Study) -> tuple[Formula, ...]:
    i = ORDER.index(design["play"])
    values = r",\ ".join(number(float(v)) for v in m.band_db[i])
    return (
        Formula("loop", r"u = K(z)\,(y + v),\quad S_y = |(I - PK)^{-1}G|^2 S_w + |(I-PK)^{-1}PK|^2 S_v"),
        Formula("gain", rf"10\lg\frac{{\int S_{{\mathrm{{open}}}}}}{{\int S}} = ({values})\ \mathrm{{dB}}",
                text("Vertical, rotation, horizontal, 0.5–3 Hz: the controller on the stage.")),
    )


def acts(design: Design) -> bool:
    """Whether a coil limit or friction acts, which no prediction has."""
    return bool(design["limited"]) or friction_of(design) > 0


def as_predicted(design: Design, said: Text) -> Text:
    """What the linear theory says of a loop; it has neither the limit of the coils nor friction, and says so where one of them acts."""
    return text("Predicted without coil limit and friction: {said}", said=said) if acts(design) and said.id else said


def _ranking(m: Study) -> Text:
    unstable = [name for name, s in zip(SHORT_NAMES, m.stable, strict=True) if not s]
    if unstable:
        return text("Unstable with these settings: {names}.", names=listed(unstable))
    return text("Least RMS velocity: {short} vertically, {short2} in rotation, {short3} horizontally.", short=_best(m.rms[:, 0]),
                short2=_best(m.rms[:, 1]), short3=_best(m.rms[:, 2]))


def _best(rms: np.ndarray) -> Text:
    """The players with the least value, "none" among them; those within 1 % tie."""
    return listed(SHORT_NAMES[int(i)] for i in np.flatnonzero(rms <= 1.01 * rms.min()))
