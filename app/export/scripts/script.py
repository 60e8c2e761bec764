"""Write a design as a Python script that asserts the page's numbers.

It goes from A, B, C, D over gains and poles to the trajectory that the page shows, with the same noise, limits, delay and
impulses, and asserts the page's numbers. Its parts stand between `# %%` lines, of which a notebook is made.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType

import numpy as np

from ...course.lesson import Lesson, Outcome
from ...engine.simulation import Run, Scenario
from ...text import SaidError, text
from .code_record_script import code_record_parts
from .comment_translation import script_header, translate_comments
from .gains import gain_lines
from .literals import array_text, complex_text, template_text

__all__ = ["AGREED", "INSTANTS", "ScriptError", "notebook", "notebook_of", "parts_of", "poles_of_the_page", "python_script"]

INSTANTS = 6  # moments of the run that are asserted
AGREED = 1e-6  # of the largest number: how near the script comes
POLE_MATRICES: Mapping[str, str] = MappingProxyType({  # what a set of poles may be the eigenvalues of, under its name in the script
    "A - B K": "Am - Bm @ K", "A - L C": "Am - L @ Cm", "the loop": "loop_matrix", "the compensator": "Am - Bm @ K - L @ (Cm - Dm @ K)",
    "A": "A", "the model's A": "Am"})

NO_SCRIPT = text("No script is written for this lesson yet: its run is of a kind of its own; take its data as JSON or CSV.")


class ScriptError(SaidError):
    """A design of which no script can be made; `text` says why in every language."""


def python_script(lesson: Lesson, outcome: Outcome, token: str, language: str = "en") -> str:
    """The script of a design, its token at the head, commented in a language. Raises ScriptError where the run is of another kind."""
    return "\n\n".join(f"# %% {title}\n{body}" for title, body in parts_of(lesson, outcome, token, language)) + "\n"


def notebook(lesson: Lesson, outcome: Outcome, token: str, language: str = "en") -> str:
    """The script as a Jupyter notebook with the story of the lesson. Raises ScriptError as `python_script` does."""
    words = lesson.words[language]
    story = "\n\n".join([f"# {words.title}", f"**{words.question}**", words.introduction,
                         *(f"## {heading}\n\n{text}" for heading, text in words.steps)])
    parts = parts_of(lesson, outcome, token, language)
    return notebook_of([("markdown", story), *(cell for title, body in parts for cell in (("markdown", f"## {title}"), ("code", body)))])


def parts_of(lesson: Lesson, outcome: Outcome, token: str, language: str = "en") -> Iterator[tuple[str, str]]:
    """Title and code of every part, in order. Raises ScriptError where the lesson's run is of another kind."""
    for title, body in _parts(lesson, outcome, token, language):
        yield translate_comments(f"# {title}", "#", language)[2:], translate_comments(body, "#", language)


def _parts(lesson: Lesson, outcome: Outcome, token: str, language: str) -> Iterator[tuple[str, str]]:
    """The same with English comments but for the head."""
    run = outcome.run
    if lesson.code is not None:
        yield from code_record_parts(lesson, lesson.code(outcome), token, language)
        return
    if run is None:
        raise ScriptError(NO_SCRIPT)
    s = run.scenario
    words = lesson.words[language]
    yield f"{words.title}: {words.question}", script_header(token, "#", language) + "\n" + template_text("head")
    yield "The plant: dx/dt = A x + B u + G w, y = C x + D u + v", "\n".join(_plant(s))
    yield "The gains: u = r - K xhat, dxhat/dt = Am xhat + Bm u + L (y - Cm xhat - Dm u)", "\n".join(_gains(s, outcome))
    yield "The run: its start, its grid, what acts on it", "\n".join(_given(s, run))
    yield "The loop on z = (x, xhat), with the input left open", template_text("loop")
    yield "Noise of the seed", template_text("noise")
    yield "The trajectory", template_text("sampled" if s.discrete else "bent" if s.limited or s.lag else "linear")
    yield "What the page shows", "\n".join(_asserted(s, run, outcome))
    yield "The curves", template_text("plot")


def _plant(s: Scenario) -> Iterator[str]:
    plant, model = s.plant, s.model
    yield f"# states {', '.join(plant.state_names)}; inputs {', '.join(plant.input_names)}; outputs {', '.join(plant.output_names)}"
    for name in "ABCD":
        yield array_text(name, getattr(plant, name))
    if model is plant:
        yield "Am, Bm, Cm, Dm = A, B, C, D  # the designer's model is exact"
        return
    for name in "ABCD":
        yield array_text(f"{name}m", getattr(model, name), "the designer's model" if name == "A" else "")


def _gains(s: Scenario, outcome: Outcome) -> Iterator[str]:
    model = s.model
    yield from gain_lines("K", s.K, model.A, model.B, "A - B K")
    yield from gain_lines("L", s.L, model.A.T, model.C.T, "A - L C")
    others = [name for name, gain in outcome.gains.items() if name not in ("K", "L")]
    if others:
        yield f"# The lesson also shows {', '.join(others)}; the run does not need them, and they are not computed here."


def _given(s: Scenario, run: Run) -> Iterator[str]:
    yield f"h, count = {s.dt!r}, {len(run.t)}  # s from one grid point to the next, and grid points" + (
        f"; the run is cut where it diverges, at {run.diverged_at:g} s" if run.diverged_at is not None else "")
    yield f"whole = {s.n_t}  # grid points of the run as it was planned: noise is drawn for all of them"
    yield array_text("x_start", s.x0)
    yield array_text("xhat_start", s.xhat0)
    held = s.reference
    if held is None:
        yield "r = np.zeros((whole, B.shape[1]))  # no reference"
    elif np.all(held == held[:1]):
        yield f"r = np.tile({held[0].tolist()!r}, (whole, 1))  # a constant reference"
    else:
        yield array_text("r", held, "the reference, held from one grid point to the next")
    yield f"u_min, u_max = np.array({_limits(s.u_min)}), np.array({_limits(s.u_max)})"
    yield f"told_clipped = {s.fed == 'applied'}  # whether the observer's input is the clipped one, or the asked one"
    yield f"state_feedback = {bool(s.state_feedback)}  # whether u = r - K x instead of r - K xhat"
    yield f"lag = {s.lag}  # steps by which the input comes late"
    yield f"plant_is_sampled, hold_and_sample = {bool(s.plant.dt)}, {bool(s.discrete)}"
    yield f"impulses = {[(float(t), np.asarray(jump).tolist()) for t, jump in s.impulses]!r}  # (time in s, jump of x)"
    yield f"seed = {s.seed}"
    yield array_text("G", s.G, "the way of w into x") if s.G is not None else "G = None"
    yield array_text("W", s.W, "intensity of w") if s.W is not None else "W = None  # no process noise"
    yield array_text("V", s.V, "intensity of v") if s.V is not None else "V = None  # no measurement noise"


def _limits(limit: np.ndarray) -> str:
    return "[" + ", ".join(repr(float(v)) if np.isfinite(v) else f"{'-' if v < 0 else ''}np.inf" for v in limit) + "]"


def _asserted(s: Scenario, run: Run, outcome: Outcome) -> Iterator[str]:
    at = np.unique(np.linspace(0, len(run.t) - 1, INSTANTS).astype(int))
    yield f"at = {at.tolist()}  # grid points that are compared"
    for name, values in (("x", run.x), ("xhat", run.xhat), ("u_asked", run.u_asked), ("u_applied", run.u_applied), ("y", run.y)):
        yield array_text(f"{name}_on_the_page", values[at])
        yield f"largest = {float(np.abs(values).max())!r}"
        yield f"assert agree({name}[at], {name}_on_the_page, largest), '{name}'"
        yield f"assert agree(np.abs({name}).max(), largest), 'the largest of {name}'"
    for name, poles, match in poles_of_the_page(s, outcome):
        if match is None:
            yield f"# The poles that the page calls '{name}' do not belong to this run's matrices; they are not computed here."
        else:
            yield f"# '{name}' on the page: the eigenvalues of {match}"
            yield f"assert same_poles(np.linalg.eigvals({POLE_MATRICES[match]}), {complex_text(poles)}), '{name}'"
    yield f"print('Observer Lab: the {len(at)} moments of the run, its largest values, gains and poles agree to {AGREED:g}.')"


def poles_of_the_page(s: Scenario, outcome: Outcome) -> Iterator[tuple[str, np.ndarray, str | None]]:
    """What the page calls poles: name, values, and the matrix of a scenario whose eigenvalues they are, None where it is none."""
    known = dict(_eigenvalues_of(s))
    for name, values in outcome.poles.items():
        poles = np.asarray(values)
        yield name, poles, next((key for key, found in known.items() if 0 < len(found) == len(poles) and _same_poles(found, poles)), None)


def _eigenvalues_of(s: Scenario) -> Iterator[tuple[str, np.ndarray]]:
    """What the page may call poles, by name: the eigenvalues of a scenario's matrices."""
    A, model, K, L = s.plant.A, s.model, s.K, s.L
    loop = np.block([[A, -s.plant.B @ K], [L @ s.plant.C, model.A - L @ model.C - (model.B - L @ model.D + L @ s.plant.D) @ K]])
    yield "A - B K", np.linalg.eigvals(model.A - model.B @ K)
    yield "A - L C", np.linalg.eigvals(model.A - L @ model.C)
    yield "the loop", np.linalg.eigvals(loop)
    yield "the compensator", np.linalg.eigvals(model.A - model.B @ K - L @ (model.C - model.D @ K))
    yield "A", np.linalg.eigvals(A)
    yield "the model's A", np.linalg.eigvals(model.A)


def _same_poles(found: np.ndarray, poles: np.ndarray) -> bool:
    """Whether two sets have one polynomial, as the script's own `same_poles` compares them."""
    scale = max(1.0, float(np.abs(poles).max()))
    return bool(np.abs(np.poly(found / scale) - np.poly(poles / scale)).max() <= 0.1 * AGREED)


def notebook_of(cells: Iterable[tuple[str, str]]) -> str:
    """A notebook of ("markdown" or "code", source), nothing of it run yet."""
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {"cells": [_cell(kind, source, number) for number, (kind, source) in enumerate(cells)],
             "metadata": {"language_info": {"name": "python"}, "kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, ensure_ascii=False, indent=1)


def _cell(kind: str, source: str, number: int) -> dict[str, object]:
    code = {"outputs": [], "execution_count": None} if kind == "code" else {}
    return {"cell_type": kind, "id": f"part-{number}", "metadata": {}, "source": source, **code}
