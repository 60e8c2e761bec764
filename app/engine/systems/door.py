"""Declare the argument checks of the public calls of `engine.systems`."""

from __future__ import annotations

from types import MappingProxyType

from . import arrays, jacobian, lyapunov, noise, pole_sets, recursions, sampling, spectrum, stability, zeros
from .argument_checks import (
    COMPLEX,
    COUNT,
    FINITE,
    FUNCTION,
    GENERATOR,
    MOST_NUMBERS,
    NAME,
    PERIOD,
    POLES,
    POSITIVE,
    SECONDS,
    SERIES,
    array,
    choice,
    count,
    covariance,
    gated,
    instance,
    items,
    matrix,
    number,
    optional,
    vector,
)
from .balance import balance as _balance
from .balance import natural_scale as _natural_scale
from .balance import state_scale as _state_scale
from .plant import Plant

_PLANT = instance(Plant)
_SYSTEM = MappingProxyType({"A": matrix("n n"), "B": matrix("n m"), "C": matrix("p n"), "D": matrix("p m")})
_PARTS = MappingProxyType({name: optional(gate) if name != "A" else gate for name, gate in _SYSTEM.items()})
_THREE = MappingProxyType({name: gate for name, gate in _PARTS.items() if name != "D"})

WINDOWS = ("hann", "hamming", "blackman", "blackmanharris", "bartlett", "boxcar", "flattop")

affine_scan = gated(Phi=matrix("N N"), forcing=optional(array("k N")), z0=vector("N"),
                    steps=count(0, MOST_NUMBERS, beside="N"))(recursions.affine_scan)
held_scan = gated(Phi=matrix("N N"), Gamma=matrix("N q"), inputs=array("k q"), z0=vector("N"))(recursions.held_scan)
step_matrices = gated(M=matrix("N N"), duration=FINITE)(recursions.step_matrices)
all_stable = gated(poles=POLES, dt=PERIOD)(stability.all_stable)
is_stable = gated(A=matrix("n n"), dt=PERIOD)(stability.is_stable)
check_poles = gated(poles=POLES, count=count())(pole_sets.check_poles)
match_poles = gated(a=POLES, b=POLES)(pole_sets.match_poles)
move_pole = gated(poles=POLES, index=count(-1000), to=COMPLEX, axis_snap=number(0), fixed=items(count()))(pole_sets.move_pole)
pole_text = gated(pole=COMPLEX)(pole_sets.pole_text)
sorted_poles = gated(A=array("… n n"))(pole_sets.sorted_poles)
amplitude_response = gated(**_SYSTEM, omega=SERIES, dt=PERIOD)(spectrum.amplitude_response)
frequency_response = gated(**_SYSTEM, omega=SERIES, dt=PERIOD)(spectrum.frequency_response)
modal_coordinates = gated(**_SYSTEM)(spectrum.modal_coordinates)
psd = gated(series=array(), fs=POSITIVE, segment=optional(COUNT), window=choice(*WINDOWS))(spectrum.psd)
as_covariance = gated(size=count(), name=NAME)(arrays.as_covariance)
as_matrix = gated(name=NAME)(arrays.as_matrix)
symmetric = gated(matrix=array("… n n"))(arrays.symmetric)
balance = gated(**_PARTS)(_balance)
natural_scale = gated(**_THREE)(_natural_scale)
state_scale = gated(**_THREE)(_state_scale)
stable_poles = gated(A=matrix("n n"), dt=PERIOD)(stability.stable_poles)
settled_covariance = gated(A=matrix("n n"), G=matrix("n q"), dt=PERIOD)(lyapunov.settled_covariance)
step_covariance = gated(A=matrix("n n"), intensity=covariance("n"), duration=number(0, 1e9))(noise.step_covariance)
process_noise = gated(M=matrix("N N"), G=matrix("N q"), W=covariance("q"), duration=SECONDS,
                      steps=count(0, MOST_NUMBERS // 20, beside="N"), rng=GENERATOR)(noise.process_noise)
root = gated(covariance=matrix("n n"))(noise.root)
continuous_of = gated(plant=_PLANT)(sampling.continuous_of)
discretise = gated(plant=_PLANT, dt=SECONDS)(sampling.discretise)
each_column = gated(one=FUNCTION)(jacobian.each_column)
slopes = gated(f=FUNCTION, x=array("n N"), u=array("m k"), name=NAME, rows=optional(count()))(jacobian.slopes)
invariant_zeros = gated(**{**_SYSTEM, "D": optional(matrix("p m"))})(zeros.invariant_zeros)
transmission_zeros = gated(plant=_PLANT)(zeros.transmission_zeros)
