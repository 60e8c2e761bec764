"""A design as one MATLAB function that runs in Octave too, without any toolbox, and proves itself.

It goes the way of the Python script. Random numbers of one language cannot be drawn in another, so the noise of the run
stands in the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np

from ..engine.simulation import Run, Scenario, disturbances_of
from ..lesson.lesson import Lesson, Outcome
from .gains import directions_of, placed_gain
from .literals import part_text
from .script import AGREED, INSTANTS, ScriptError, poles_of_the_page

__all__ = ["function_name", "matlab_script"]

POLES: Mapping[str, str] = MappingProxyType({
    "A - B K": "Am - Bm * K", "A - L C": "Am - L * Cm", "the loop": "loop_matrix", "the compensator": "Am - Bm * K - L * (Cm - Dm * K)",
    "A": "A", "the believed A": "Am"})
FEW = 12  # rows that jump, up to which each has a line of its own


def function_name(lesson: Lesson) -> str:
    """The name of the function and of its file."""
    return lesson.id.replace("-", "_")


def matlab_script(lesson: Lesson, outcome: Outcome, token: str) -> str:
    """The file of a design. Raises ScriptError where the lesson's run is of another kind than a loop with an observer."""
    run = outcome.run
    if run is None:
        raise ScriptError(f"The run of lesson {lesson.id} is of a kind that no MATLAB file is written for yet; give --to python.")
    s, words = run.scenario, lesson.words["en"]
    lines = [f"function {function_name(lesson)}(draw)", f"% {words.title}: {words.question}",
             f"% Made by Observer Lab from the state {token}",
             "% Every number stands in SI units. Signs: u = -K xhat, e = x - xhat, de/dt = (A - L C) e.",
             f"% {function_name(lesson)}(false) checks and draws nothing.", "if nargin < 1", "    draw = true;", "end", "",
             "%% The plant: dx/dt = A x + B u + G w, y = C x + D u + v", *_plant(s), "",
             "%% The gains: u = r - K xhat, dxhat/dt = Am xhat + Bm u + L (y - Cm xhat - Dm u)", *_gains(s), "",
             "%% The run: its start, its grid, what acts on it", *_given(s, run), "", _part("loop"), "",
             _part("sampled" if s.discrete else "bent" if s.limited or s.lag else "linear"), "",
             "%% What the page shows", *_asserted(s, run, outcome), "", _part("plot"), "end", "", _part("functions")]
    return "\n".join(lines) + "\n"


def _part(name: str) -> str:
    return part_text(f"matlab_{name}")


def _array(name: str, value: object, note: str = "") -> str:
    array = np.asarray(value, dtype=float)
    tail = f"  % {note}" if note else ""
    if not array.size:
        return f"{name} = zeros({array.shape[0]}, {array.shape[-1] if array.ndim > 1 else 1});{tail}"
    if array.ndim < 2:
        return f"{name} = [{' '.join(map(_number, array.ravel().tolist()))}];{tail}"
    rows = ("; ...\n" + " " * (len(name) + 4)).join(" ".join(map(_number, row)) for row in array.tolist())
    return (f"% {note}\n" if note else "") + f"{name} = [{rows}];"


def _number(value: float) -> str:
    return repr(value) if np.isfinite(value) else "NaN" if np.isnan(value) else "Inf" if value > 0 else "-Inf"


def _complex(poles: np.ndarray) -> str:
    return "[" + ", ".join(f"complex({float(p.real)!r}, {float(p.imag)!r})" for p in np.asarray(poles, dtype=complex)) + "]"


def _plant(s: Scenario) -> Iterator[str]:
    plant, model = s.plant, s.model
    yield f"% states {', '.join(plant.state_names)}; inputs {', '.join(plant.input_names)}; outputs {', '.join(plant.output_names)}"
    for name in "ABCD":
        yield _array(name, getattr(plant, name))
    for name in "ABCD":
        yield f"{name}m = {name};" if model is plant else _array(f"{name}m", getattr(model, name), "what the designer believes")


def _gains(s: Scenario) -> Iterator[str]:
    model = s.model
    for name, gain, A, B in (("K", s.K, model.A, model.B), ("L", s.L.T, model.A.T, model.C.T)):
        back = "" if name == "K" else "'"
        poles = np.linalg.eigvals(A - B @ gain)
        placed = placed_gain(A, B, poles) if B.shape[1] == 1 and np.any(gain) else None
        if placed is not None and np.allclose(placed, gain, rtol=1e-8, atol=1e-9 * np.abs(gain).max()):
            yield f"% The poles make {name} unique (Ackermann)."
            yield f"{name} = ackermann({'Am, Bm' if name == 'K' else chr(39).join(('Am', ', Cm', ''))}, {_complex(poles)}){back};"
            yield _array("page", gain if name == "K" else gain.T)
            yield f"agree('{name}', {name}, page, max(abs(page(:))));"
            yield f"{name} = page;  % the page's digits from here on: a run that grows would magnify the last of them"
        elif (directions := directions_of(A, B, gain) if np.any(gain) else None) is not None:
            yield f"% Several {'inputs' if name == 'K' else 'outputs'}: beside each pole a direction g is free, here the page's."
            yield f"{name} = from_directions({'Am, Bm' if name == 'K' else chr(39).join(('Am', ', Cm', ''))}, ..."
            yield f"    {_complex(directions[0])}, ..."
            yield "    [" + "; ...\n     ".join(_complex(row)[1:-1] for row in directions[1]) + f"]){back};"
            yield _array("page", gain if name == "K" else gain.T)
            yield f"agree('{name}', {name}, page, max(abs(page(:))));"
            yield f"{name} = page;  % the page's digits from here on: a run that grows would magnify the last of them"
        else:
            note = "as the page found it: poles and directions do not say it exactly enough" if np.any(gain) else "nothing is fed back"
            yield _array(name, gain if name == "K" else gain.T, note)


def _given(s: Scenario, run: Run) -> Iterator[str]:
    d = disturbances_of(s)
    count, N = len(run.t), s.plant.n + s.model.n
    yield f"h = {s.dt!r};  % s from one grid point to the next"
    yield f"count = {count};  % grid points"
    yield _array("z", d.z0[:, None], "the start of (x, xhat), with what kicks it there")
    held = np.zeros((1, s.plant.m)) if s.reference is None else s.reference[:count]
    constant = bool(np.all(held == held[:1]))
    yield (_array("r", held[:1]) + "\nr = repmat(r, count, 1);  % a constant reference" if constant else _array("r", held, "the reference"))
    yield _array("u_min", s.u_min[:, None])
    yield _array("u_max", s.u_max[:, None])
    yield f"told_clipped = {str(s.fed == 'applied').lower()};  % whether the observer is told the clipped input, or the asked one"
    yield f"state_feedback = {str(bool(s.state_feedback)).lower()};  % whether u = r - K x instead of r - K xhat"
    yield f"lag = {s.lag};  % steps by which the input comes late"
    yield f"hold_and_sample = {str(bool(s.discrete and not s.plant.dt)).lower()};  % the plant is held between samples"
    yield "% Noise as the page drew it (the generator of this language gives other numbers), and jumps of kicks at the ends of steps."
    yield from _sparse("v", d.v[:count], count, s.plant.p)
    yield from _sparse("jumps", np.zeros((0, N)) if d.jumps is None else d.jumps[:count - 1], max(count - 1, 0), N)
    rows = [[k + 1, moment, *dz] for k, several in d.kicks.items() for moment, dz in several if k < count - 1]
    yield _array("kicks", np.array(rows) if rows else np.zeros((0, N + 2)), "kicks between grid points: step, s into it, jump of (x, xhat)")


def _sparse(name: str, values: np.ndarray, rows: int, columns: int) -> Iterator[str]:
    busy = np.flatnonzero(np.any(values != 0, axis=1)) if values.size else np.zeros(0, dtype=int)
    if len(busy) > FEW:
        yield _array(name, values)
        return
    yield f"{name} = zeros({rows}, {columns});"
    for k in busy:
        yield f"{name}({k + 1}, :) = [{' '.join(map(_number, values[k].tolist()))}];"


def _asserted(s: Scenario, run: Run, outcome: Outcome) -> Iterator[str]:
    at = np.unique(np.linspace(0, len(run.t) - 1, INSTANTS).astype(int))
    yield f"at = [{' '.join(str(k + 1) for k in at)}];  % grid points that are compared"
    for name, values in (("x", run.x), ("xhat", run.xhat), ("u_asked", run.u_asked), ("u_applied", run.u_applied), ("y", run.y)):
        yield _array("page", values[at])
        largest = float(np.abs(values).max())
        yield f"agree('{name}', {name}(at, :), page, {largest!r});"
        yield f"agree('the largest of {name}', max(abs({name}(:))), {largest!r}, {largest!r});"
    for name, poles, match in poles_of_the_page(s, outcome):
        if match is None:
            yield f"% The poles that the page calls '{name}' do not belong to this run's matrices; they are not computed here."
        else:
            yield f"same_poles('{name}', eig({POLES[match]}), {_complex(poles)});"
    yield f"disp('Observer Lab: the run, its largest values, gains and poles agree to {AGREED:g}.');"
