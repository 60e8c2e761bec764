"""Plants without dynamics, inputs or sensors, and knobs at ends that cross: a lesson computes or refuses in one sentence."""

from __future__ import annotations

import json
import warnings

import numpy as np
import pytest
from all_plants import wrong_on

from observer_lab.cli.entry import main
from observer_lab.course.knobs import KnobError, Number
from observer_lab.course.lesson import Design, Lesson
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS
from observer_lab.plants.own_plant import clean_plant_json

OWN = [lesson for lesson in LESSONS.values() if lesson.adapt is not None]
DEGENERATE = {
    "zero A": {"A": [[0, 0], [0, 0]], "B": [[1], [2]], "C": [[1, 0]]},
    "one integrator": {"A": [[0]], "B": [[1]], "C": [[1]]},
    "chain of integrators": {"A": [[0, 1, 0], [0, 0, 1], [0, 0, 0]], "B": [[0], [0], [1]], "C": [[1, 0, 0]]},
    "no input acts": {"A": [[-1, 1], [0, -2]], "B": [[0], [0]], "C": [[1, 0]]},
    "no sensor sees": {"A": [[-1, 1], [0, -2]], "B": [[0], [1]], "C": [[0, 0]]},
    "twins": {"A": [[-1, 0, 0], [0, -1, 0], [0, 0, -1]], "B": [[1], [1], [1]], "C": [[1, 1, 1]]},
    "unstable and hidden": {"A": [[1, 0], [0, -1]], "B": [[0], [1]], "C": [[0, 1]]},
    "dead beat": {"A": [[0, 1], [0, 0]], "B": [[0], [1]], "C": [[1, 0]], "dt": 0.1},
    "sampled and constant": {"A": [[1, 0], [0, 1]], "B": [[1, 0], [0, 1]], "C": [[1, 0], [0, 1]], "dt": 1},
    "a thousand times a second and an hour": {"A": [[-1e3, 0], [0, -1e-4]], "B": [[1e3], [1e-4]], "C": [[1, 1]]},
    "direct path": {"A": [[-1]], "B": [[1]], "C": [[1]], "D": [[5]]},
    "oscillator without damping": {"A": [[0, 1], [-1, 0]], "B": [[0], [0]], "C": [[1, 0]]},
}


def random_degenerate(seed: int) -> dict[str, object]:
    """Entries 0, 1 and −1, most of them 0, of one to four states and up to three inputs and outputs; half of them sampled."""
    rng = np.random.default_rng((35, seed))
    n, m, p = int(rng.integers(1, 5)), int(rng.integers(1, 4)), int(rng.integers(1, 4))
    sparse = [rng.choice([0, 0, 0, 1, -1], size).tolist() for size in ((n, n), (n, m), (p, n))]
    return dict(zip("ABC", sparse, strict=True)) | ({"dt": 0.5} if seed % 2 else {})


def _text(plant: dict[str, object], lesson: Lesson) -> str:
    if lesson.bilinear and "dt" not in plant:
        n = len(plant["A"])  # type: ignore[arg-type]
        plant = plant | {"F": np.zeros((n, n)).tolist(), "K": np.ones((1, n)).tolist()}
    return clean_plant_json(json.dumps(plant))


@pytest.mark.parametrize("k", range(len(OWN)), ids=[lesson.id for lesson in OWN])
def test_a_degenerate_plant_is_computed_or_refused(k: int) -> None:
    """Four of the named plants and four random ones for each lesson, others for the next; zero A for all."""
    names = list(DEGENERATE)
    plants = {"zero A": DEGENERATE["zero A"]} | {name: DEGENERATE[name] for name in (names[(3 * k + j) % len(names)] for j in range(3))}
    plants |= {f"random {seed}": random_degenerate(seed) for seed in range(4 * k, 4 * k + 4)}
    for name, plant in plants.items():
        try:
            text = _text(plant, OWN[k])
        except EngineError as refused:
            assert "\n" not in str(refused)
            continue
        said = wrong_on(OWN[k], text)
        assert said in ("", "refused"), f"{name}: {said}"


def at_ends(lesson: Lesson, seed: int) -> dict[str, object]:
    """Every number of a lesson at one of its ends, drawn by the seed; of seed 0 a low end lies above its high end."""
    rng, ends = np.random.default_rng((36, seed)), {}
    for knob in lesson.knobs:
        if isinstance(knob, Number):
            low = "low" in knob.name or "min" in knob.name or "start" in knob.name
            high = "high" in knob.name or "max" in knob.name or "end" in knob.name
            ends[knob.name] = (knob.high if low else knob.low) if seed == 0 and (low or high) else float(rng.choice([knob.low, knob.high]))
    return ends


@pytest.mark.parametrize("lesson", LESSONS.values(), ids=lambda lesson: lesson.id)
def test_knobs_at_their_ends_are_computed_or_refused(lesson: Lesson) -> None:
    for seed in range(3):
        changes = at_ends(lesson, seed)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                design: Design = lesson.apply(lesson.start(), changes)
                outcome = lesson.compute(design)
                outcome.metrics, outcome.checks, tuple(lesson.figures(outcome))
            except (EngineError, KnobError) as refused:
                assert "\n" not in str(refused), changes


@pytest.mark.parametrize("words", [
    ["decoupling", "--set", "f_low=4", "--set", "f_high=0.5"], ["hidden-modes", "--plant"], ["separation", "--plant"]])
def test_the_commands_of_the_report_show_no_traceback(words: list[str], tmp_path, capsys) -> None:
    path = tmp_path / "plant.json"
    path.write_text(json.dumps(DEGENERATE["zero A"]), encoding="utf-8")
    status = main(["run", *words, *([str(path)] if words[-1] == "--plant" else [])])
    said = capsys.readouterr()
    assert (status in (0, 1) and said.out) or (status == 2 and said.err.count("\n") == 1 and said.err.startswith("observer-lab: "))
