"""Declare the argument checks of the public calls of `engine.network`."""

from __future__ import annotations

from types import MappingProxyType

from ..systems.argument_checks import SHARE, WHOLE, array, choice, count, covariance, gated, instance, matrix, optional
from ..systems.plant import Plant
from . import intermittent, lossy_steps, network_loop, network_simulation, packets

_PLANT = instance(Plant)
_MODEL = MappingProxyType({"A": matrix(), "C": matrix(), "Q": covariance(), "R": covariance()})
_START = MappingProxyType({**_MODEL, "P0": covariance()})
_RUN = instance(network_simulation.NetworkRun)

newest_packet_age = gated(arrivals=WHOLE)(packets.newest_packet_age)
critical_loss = gated(A=matrix(), C=matrix())(intermittent.critical_loss)
intermittent_covariances = gated(**_START, heard=array())(intermittent.intermittent_covariances)
intermittent_steps = gated(**_START, heard=array())(intermittent.intermittent_steps)
lossy_growth = gated(A=matrix(), C=matrix(), loss=SHARE, steps=count(1, 100_000))(intermittent.lossy_growth)
mare = gated(**_MODEL, loss=SHARE)(intermittent.mare)
mean_bounds = gated(**_START, loss=array(), steps=count(0, 100_000))(intermittent.mean_bounds)
mean_lower_limit = gated(A=matrix("n n"), Q=covariance("n"), loss=SHARE)(intermittent.mean_lower_limit)
measured = gated(P=array("… n n"), C=matrix("p n"), R=matrix("p p"))(lossy_steps.corrected_covariance)
riccati_step = gated(P=array("… n n"), A=matrix("n n"), C=matrix("p n"), Q=matrix("n n"), R=matrix("p p"), heard=array())(
    lossy_steps.riccati_step)
spectral_radius = gated(matrix=matrix("n n"))(intermittent.spectral_radius)
delayed_loop = gated(plant=_PLANT, K=matrix(), M=matrix(), delay=count(0, 1000), told=choice("asked", "applied"), ahead=count(0, 1000))(
    network_loop.delayed_loop)
mean_square_growth = gated(plant=_PLANT, K=matrix("m n"), loss=SHARE, on_loss=choice("hold", "zero"))(network_loop.mean_square_growth)
network_meter = gated(run=_RUN, promised=optional(array("k n")))(network_simulation.network_meter)
promised_error = gated(run=_RUN)(network_simulation.promised_error)
simulate_network = gated(s=instance(network_simulation.NetworkScenario))(network_simulation.simulate_network)
