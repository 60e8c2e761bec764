"""Write a design as one MATLAB or Octave function that asserts the page's numbers.

It goes the way of the Python script. Random numbers of one language cannot be drawn in another, so the noise of the run
stands in the file.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np

from ...course.lesson import Lesson, Outcome
from ...course.script_record import Code, GivenValue, ShownValue
from ...engine.simulation import Run, Scenario, disturbances_of
from ...text import text_in
from .code_record_script import check_of
from .comment_translation import script_header, translate_comments
from .gains import directions_of, placed_gain
from .literals import template_text
from .script import AGREED, INSTANTS, NO_SCRIPT, ScriptError, poles_of_the_page

__all__ = ["array", "body_of", "code_record_lines", "complex_row", "formula", "function_name", "functions_for", "matlab_script", "number"]

POLE_MATRICES: Mapping[str, str] = MappingProxyType({
    "A - B K": "Am - Bm * K", "A - L C": "Am - L * Cm", "the loop": "loop_matrix", "the compensator": "Am - Bm * K - L * (Cm - Dm * K)",
    "A": "A", "the model's A": "Am"})
QUIET_COMMENT = text_in("script", "{function}(false) checks and draws nothing.")
MAX_JUMP_ROWS = 12  # rows that jump, up to which each has a line of its own
CURVES_MARKER = "%% The curves\n"
IN_MATLAB = ((r"\['(\w+)'\]", r".\1"), (r"\beigvals\(", "eig("), (r"\bnp\.roots\(", "roots("), (r"\blen\(", "numel("), (r"@", "*"))
LOCAL = "%% Functions\n"


def function_name(lesson: Lesson) -> str:
    """The name of the function and of its file."""
    return lesson.id.replace("-", "_")


def matlab_script(lesson: Lesson, outcome: Outcome, token: str, language: str = "en") -> str:
    """The file of a design. Raises ScriptError where the lesson's run is of another kind than a loop with an observer."""
    words, run = lesson.words[language], outcome.run
    head = [f"function {function_name(lesson)}(draw)", f"% {words.title}: {words.question}",
             script_header(token, "%", language),
             f"% {QUIET_COMMENT.format(function=function_name(lesson))(language)}", "if nargin < 1", "    draw = true;", "end", ""]
    if lesson.code is not None:
        return translate_comments("\n".join([*head, *code_record_lines(lesson.code(outcome))]) + "\n", "%", language)
    if run is None:
        raise ScriptError(NO_SCRIPT)
    s = run.scenario
    body = ["%% The plant: dx/dt = A x + B u + G w, y = C x + D u + v", *_plant(s), "",
            "%% The gains: u = r - K xhat, dxhat/dt = Am xhat + Bm u + L (y - Cm xhat - Dm u)", *_gains(s), "",
            "%% The run: its start, its grid, what acts on it", *_given(s, run), "", body_of("loop")[0], "",
            body_of("sampled" if s.discrete else "bent" if s.limited or s.lag else "linear")[0], "",
            "%% What the page shows", *_asserted(s, run, outcome), "", body_of("plot")[0], "end", ""]
    return translate_comments("\n".join([*head, *body, functions_for("\n".join(body))]) + "\n", "%", language)


def _plant(s: Scenario) -> Iterator[str]:
    plant, model = s.plant, s.model
    yield f"% states {', '.join(plant.state_names)}; inputs {', '.join(plant.input_names)}; outputs {', '.join(plant.output_names)}"
    for name in "ABCD":
        yield array(name, getattr(plant, name))
    for name in "ABCD":
        yield f"{name}m = {name};" if model is plant else array(f"{name}m", getattr(model, name), "the designer's model")


def _gains(s: Scenario) -> Iterator[str]:
    model = s.model
    for name, gain, A, B in (("K", s.K, model.A, model.B), ("L", s.L.T, model.A.T, model.C.T)):
        back = "" if name == "K" else "'"
        poles = np.linalg.eigvals(A - B @ gain)
        placed = placed_gain(A, B, poles) if B.shape[1] == 1 and np.any(gain) else None
        if placed is not None and np.allclose(placed, gain, rtol=1e-8, atol=1e-9 * np.abs(gain).max()):
            yield f"% The poles make {name} unique (Ackermann)."
            yield f"{name} = ackermann({'Am, Bm' if name == 'K' else chr(39).join(('Am', ', Cm', ''))}, {complex_row(poles)}){back};"
            yield array("page", gain if name == "K" else gain.T)
            yield f"agree('{name}', {name}, page, max(abs(page(:))));"
            yield f"{name} = page;  % the page's digits from here on: a run that grows would magnify the last of them"
        elif (directions := directions_of(A, B, gain) if np.any(gain) else None) is not None:
            yield f"% Several {'inputs' if name == 'K' else 'outputs'}: beside each pole a direction g is free, here the page's."
            yield f"{name} = from_directions({'Am, Bm' if name == 'K' else chr(39).join(('Am', ', Cm', ''))}, ..."
            yield f"    {complex_row(directions[0])}, ..."
            yield "    [" + "; ...\n     ".join(complex_row(row)[1:-1] for row in directions[1]) + f"]){back};"
            yield array("page", gain if name == "K" else gain.T)
            yield f"agree('{name}', {name}, page, max(abs(page(:))));"
            yield f"{name} = page;  % the page's digits from here on: a run that grows would magnify the last of them"
        else:
            note = "as the page found it: poles and directions do not say it exactly enough" if np.any(gain) else "nothing is fed back"
            yield array(name, gain if name == "K" else gain.T, note)


def _given(s: Scenario, run: Run) -> Iterator[str]:
    d = disturbances_of(s)
    count, N = len(run.t), s.plant.n + s.model.n
    yield f"h = {s.dt!r};  % s from one grid point to the next"
    yield f"count = {count};  % grid points"
    yield array("z", d.z0[:, None], "the start of (x, xhat), with what kicks it there")
    held = np.zeros((1, s.plant.m)) if s.reference is None else s.reference[:count]
    constant = bool(np.all(held == held[:1]))
    yield (array("r", held[:1]) + "\nr = repmat(r, count, 1);  % a constant reference" if constant else array("r", held, "the reference"))
    yield array("u_min", s.u_min[:, None])
    yield array("u_max", s.u_max[:, None])
    yield f"told_clipped = {str(s.fed == 'applied').lower()};  % whether the observer's input is the clipped one, or the asked one"
    yield f"state_feedback = {str(bool(s.state_feedback)).lower()};  % whether u = r - K x instead of r - K xhat"
    yield f"lag = {s.lag};  % steps by which the input comes late"
    yield f"hold_and_sample = {str(bool(s.discrete and not s.plant.dt)).lower()};  % the plant is held between samples"
    yield "% Noise as the page drew it (the generator of this language gives other numbers), and jumps of kicks at the ends of steps."
    yield from _sparse("v", d.v[:count], count, s.plant.p)
    yield from _sparse("jumps", np.zeros((0, N)) if d.jumps is None else d.jumps[:count - 1], max(count - 1, 0), N)
    rows = [[k + 1, moment, *dz] for k, several in d.kicks.items() for moment, dz in several if k < count - 1]
    yield array("kicks", np.array(rows) if rows else np.zeros((0, N + 2)), "kicks between grid points: step, s into it, jump of (x, xhat)")


def _sparse(name: str, values: np.ndarray, rows: int, columns: int) -> Iterator[str]:
    busy = np.flatnonzero(np.any(values != 0, axis=1)) if values.size else np.zeros(0, dtype=int)
    if len(busy) > MAX_JUMP_ROWS:
        yield array(name, values)
        return
    yield f"{name} = zeros({rows}, {columns});"
    for k in busy:
        yield f"{name}({k + 1}, :) = [{' '.join(map(number, values[k].tolist()))}];"


def _asserted(s: Scenario, run: Run, outcome: Outcome) -> Iterator[str]:
    at = np.unique(np.linspace(0, len(run.t) - 1, INSTANTS).astype(int))
    yield f"at = [{' '.join(str(k + 1) for k in at)}];  % grid points that are compared"
    for name, values in (("x", run.x), ("xhat", run.xhat), ("u_asked", run.u_asked), ("u_applied", run.u_applied), ("y", run.y)):
        yield array("page", values[at])
        largest = float(np.abs(values).max())
        yield f"agree('{name}', {name}(at, :), page, {largest!r});"
        yield f"agree('the largest of {name}', max(abs({name}(:))), {largest!r}, {largest!r});"
    for name, poles, match in poles_of_the_page(s, outcome):
        if match is None:
            yield f"% The poles that the page calls '{name}' do not belong to this run's matrices; they are not computed here."
        else:
            yield f"same_poles('{name}', eig({POLE_MATRICES[match]}), {complex_row(poles)});"
    yield f"disp('Observer Lab: the run, its largest values, gains and poles agree to {AGREED:g}.');"


def code_record_lines(code: Code) -> Iterator[str]:
    """The body of the function behind its head, its `end`, and the functions that it calls."""
    bodies = [body_of(name) for name in code.parts]
    equations, _, curves = "\n\n".join(body for body, _ in bodies).partition(CURVES_MARKER)
    yield "%% What is given"
    yield from map(_given_record, code.given)
    if code.drawn:
        yield "\n"
        yield "%% Noise as Python drew it; the generator of this language gives other numbers from the same seed"
        yield from map(_given_record, code.drawn)
    shown = list(_asserted_record(code))
    yield "\n" + equations.rstrip() + "\n"
    yield "%% What the page shows"
    yield from shown
    yield "\n" + CURVES_MARKER + curves + "\nend\n"
    local = "\n\n".join(text for _, text in bodies if text)
    yield "\n\n".join(text for text in (local, functions_for("\n".join([equations, local, *shown]))) if text)


def _given_record(given: GivenValue) -> str:
    value, note = given.value, f"  % {given.note}" if given.note else ""
    if isinstance(value, bool):
        return f"{given.name} = {str(value).lower()};{note}"
    if isinstance(value, (int, str)):
        return f"{given.name} = {value!r};{note}"
    if isinstance(value, float):
        return f"{given.name} = {number(value)};{note}"
    return array(given.name, value, given.note)


def _asserted_record(code: Code) -> Iterator[str]:
    if code.unsaid:
        yield f"% {code.unsaid}: the page shows them too, and they are not computed here."
    for shown in code.shown:
        yield _assertion(shown)
    yield f"disp('Observer Lab: {len(code.shown)} results of the page, its run among them, agree to 1e-06.');"


def _assertion(shown: ShownValue) -> str:
    name = formula(shown.name)
    if shown.poles:
        return f"same_poles('{name}', {name}, {complex_row(np.asarray(shown.value).ravel())});"
    check = check_of(shown)
    size = number(check.size)
    if check.values.ndim == 0:
        return f"agree('{name}', {name}, {number(float(check.values))}, {size});"
    if check.at is None:
        return f"{array('page', check.values)}\nagree('{name}', {name}, page, {size});"
    places = " ".join(str(k + 1) for k in check.at)
    return f"{array('page', check.values)}\nagree_at('{name}', {name}, {check.length}, [{places}], page, {number(check.largest)}, {size});"


def number(value: float) -> str:
    """A number that reads back exactly."""
    return repr(float(value)) if np.isfinite(value) else "NaN" if np.isnan(value) else "Inf" if value > 0 else "-Inf"


def array(name: str, value: object, note: str = "") -> str:
    """An assignment that reads back exactly: a list as a row, a row of a matrix a line."""
    rows = np.asarray(value, dtype=float)
    tail = f"  % {note}" if note else ""
    if not rows.size:
        return f"{name} = zeros({rows.shape[0]}, {rows.shape[-1] if rows.ndim > 1 else 1});{tail}"
    if rows.ndim < 2:
        return f"{name} = [{' '.join(map(number, rows.ravel().tolist()))}];{tail}"
    lines = ("; ...\n" + " " * (len(name) + 4)).join(" ".join(map(number, row)) for row in rows.tolist())
    return (f"% {note}\n" if note else "") + f"{name} = [{lines}];"


def complex_row(poles: np.ndarray) -> str:
    """A set of poles."""
    return "[" + ", ".join(f"complex({float(p.real)!r}, {float(p.imag)!r})" for p in np.asarray(poles, dtype=complex)) + "]"


def formula(python: str) -> str:
    """The name of a result, or a short formula of names, from Python: eigvals(A - B @ K) is eig(A - B * K)."""
    for pattern, instead in IN_MATLAB:
        python = re.sub(pattern, instead, python)
    return python


def body_of(name: str) -> tuple[str, str]:
    """The equations of a part, and the functions of its own that stand behind them."""
    body, _, local = template_text(f"matlab_{name}").partition(LOCAL)
    return body.rstrip(), local.rstrip()


def functions_for(text: str) -> str:
    """The functions of our library that a text calls, and those that they call, in the library's order."""
    library = {block.split("(", 1)[0].split()[-1]: block.rstrip()
               for part in ("proof", "library") for block in re.split(r"\n(?=function )", template_text(f"matlab_{part}"))}
    needed: set[str] = set()
    waiting = [text]
    while waiting:
        called = {name for name in library if re.search(rf"\b{name}\(", waiting[-1])} - needed
        waiting.pop()
        needed |= called
        waiting += [library[name].split("\n", 1)[1] for name in called]
    return "\n\n".join(block for name, block in library.items() if name in needed)
