"""Declare the argument checks of the public calls of `engine.simulation`."""

from __future__ import annotations

from types import MappingProxyType

from ..systems.argument_checks import FUNCTION, SECONDS, SERIES, array, count, gated, instance, matrix, number, optional
from ..systems.plant import Plant
from . import batch, geared, loop, recovery
from .geared import Gear
from .scenario import Run, Scenario
from .simulate import autonomous_error as _autonomous_error
from .simulate import disturbances_of as _disturbances_of
from .simulate import separation_meter as _separation_meter
from .simulate import simulate as _simulate
from .simulate import simulate_until as _simulate_until

_SCENARIO, _RUN = instance(Scenario), instance(Run)
_SIZE = number(above=0, high=1e100)
_GRID = MappingProxyType({"x_index": count(-1000), "x_values": SERIES, "e_index": count(-1000), "e_values": SERIES})

simulate = gated(scenario=_SCENARIO)(_simulate)
disturbances_of = gated(scenario=_SCENARIO)(_disturbances_of)
simulate_until = gated(scenario=_SCENARIO, looks=SERIES, enough=FUNCTION)(_simulate_until)
simulate_geared = gated(scenario=_SCENARIO, gear=instance(Gear))(geared.simulate_geared)
autonomous_error = gated(run=_RUN)(_autonomous_error)
separation_meter = gated(run=_RUN)(_separation_meter)
emulated_gain = gated(plant=instance(Plant), L=matrix("n p"), dt=SECONDS)(loop.emulated_gain)
simulate_recovery = gated(scenario=_SCENARIO, **_GRID, threshold=optional(_SIZE), bound=optional(_SIZE), slice_seconds=number(0))(
    recovery.simulate_recovery)
simulate_starts = gated(scenario=_SCENARIO, starts=array("k N"))(batch.simulate_starts)
starts_of = gated(s=_SCENARIO, **_GRID)(recovery.starts_of)
