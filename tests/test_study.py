"""Studies: one law over all lessons, the same bits whoever computes them, nothing lost by a kill, one sentence for bad files."""

from __future__ import annotations

import csv
import json
import multiprocessing
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from commands import refused
from laws import each, holds_for_all

from observer_lab.cli.commands.study import FORMAT
from observer_lab.cli.entry import main
from observer_lab.course.knobs import Number
from observer_lab.course.lesson import Lesson
from observer_lab.engine import from_json
from observer_lab.lessons import LESSONS
from observer_lab.plants.examples import example
from observer_lab.study import executors
from observer_lab.study.figures import figure_as
from observer_lab.study.ledger import Ledger
from observer_lab.study.plan import MAX_STUDY_RUNS, Row, Study, StudyError, digest, programs
from observer_lab.study.points import numbers, seed_at
from observer_lab.study.results import columns, summaries, wilson
from observer_lab.study.study_parser import read_study

SMALL = ('{"lesson": "error-dynamics", "set": {"input": "random"}, "vary": {"guess_q": [-1, 0.5], "guess_v": [0], "frequency": [0.5]}, '
         '"seeds": 4, "collect": ["final_error"]}')  # three things that vary are drawn in no figure


def study_of(words: str) -> Study:
    return read_study(words, example)


def rows_of(study: Study, missing: Sequence[int] | None = None) -> dict[int, Row]:
    """The rows that this process computes."""
    every = range(study.size) if missing is None else missing
    return {row.index: row for chunk in executors.in_process(study, every) for row in chunk}


@pytest.mark.slow
def test_every_lesson_gives_a_study_of_two_points_whose_first_is_its_own_run() -> None:
    def law(lesson: Lesson) -> None:
        knob = next(k for k in lesson.knobs if isinstance(k, Number) and not k.hidden)
        start = lesson.start()
        other = knob.high if start[knob.name] != knob.high else knob.low
        study = study_of(json.dumps({"lesson": lesson.id, "vary": {knob.name: [start[knob.name], other]}}))
        rows = rows_of(study)
        own = numbers(lesson.compute(start))
        assert not rows[0].problem and not rows[1].problem and set(own) <= set(study.collect)
        first = np.array(rows[0].values, dtype=float)
        assert np.array_equal(first, [own.get(name, np.nan) for name in study.collect], equal_nan=True)
        assert len(columns(study)) == 3 + len(study.collect)
    holds_for_all(LESSONS.values(), law, lambda lesson: lesson.id)


# --- the same whoever computes it ----------------------------------------------------------------------------------------
@pytest.mark.slow
def test_a_process_beside_this_one_gives_the_same_bits() -> None:
    """Two of them, a real cluster, kills and Ctrl-C: `tests/benchmarks/studies.py`."""
    study = study_of(SMALL)
    assert {row.index: row for chunk in executors.on_processes(study, range(study.size), 1) for row in chunk} == rows_of(study)
    assert not multiprocessing.active_children()


def test_a_resumed_run_agrees_with_a_whole_one_to_the_last_bit(capsys, tmp_path: Path) -> None:
    file = tmp_path / "small.json"
    file.write_text(SMALL)
    folders = [tmp_path / name for name in ("one", "torn")]
    first = b"", b""
    for folder in folders:
        if folder.name == "torn":  # a kill in the middle of a line
            folder.mkdir()
            lines = (folders[0] / "runs.txt").read_bytes().splitlines(keepends=True)
            (folder / "runs.txt").write_bytes(b"".join(lines[:4]) + lines[4][:-5])
        assert main(["study", str(file), "--workers", "1", "-o", str(folder)]) == 0
        told = capsys.readouterr().err
        assert ("3 of 8 runs are done already" in told) == (folder.name == "torn")
        written = (folder / "runs.csv").read_bytes(), (folder / "study.json").read_bytes()
        assert folder.name == "one" or written == first
        first = written
    rows = list(csv.reader(first[0].decode().splitlines()))
    assert rows[0][0].startswith("# Observer Lab")
    assert rows[1] == ["point", "guess_q [m]", "guess_v [m/s]", "frequency [Hz]", "seed", "final_error", "problem"]
    assert [row[:2] for row in rows[2:]] == [[str(p), v] for p, v in ((0, "-1.0"), (1, "0.5")) for _ in range(4)]


def test_chunks_and_their_order_change_nothing() -> None:
    study = study_of(SMALL)
    assert rows_of(study) == rows_of(study, [7, 2, 5]) | rows_of(study, [0, 1, 3, 4, 6])


def test_seeds_differ_within_a_point_and_more_of_them_begin_alike() -> None:
    few, many = (study_of(SMALL.replace('"seeds": 4', f'"seeds": {count}')) for count in (5, 200))
    for point in range(2):
        drawn = [seed_at(many, point * 200 + run) for run in range(200)]
        assert len(set(drawn)) == 200 and drawn[:5] == [seed_at(few, point * 5 + run) for run in range(5)]
        assert all(seed is not None and 0 <= seed <= 9999 and seed == round(seed) for seed in drawn)
    assert [seed_at(many, run) for run in range(9)] != [seed_at(many, 200 + run) for run in range(9)]
    fixed = study_of(SMALL.replace('"seeds": 4', '"seeds": {"from": 3, "to": 9, "count": 4}'))
    assert [seed_at(fixed, index) for index in range(8)] == 2 * [3.0, 5.0, 7.0, 9.0]


# --- nothing is lost ---------------------------------------------------------------------------------------------------------
def test_wherever_a_line_is_torn_or_spoiled_the_others_are_kept(tmp_path: Path) -> None:
    study, path = study_of(SMALL), tmp_path / "runs.txt"
    rows = [Row(index, (index / 3,)) for index in range(6)]
    with Ledger(path, study, "mark") as ledger:
        for k in (0, 2, 4):
            ledger.add(rows[k:k + 2])
    whole = path.read_bytes()
    lines = whole.splitlines(keepends=True)
    before = len(whole) - len(lines[-1])
    for end in (*range(before, len(whole), 9), len(whole) - 1, len(whole)):
        path.write_bytes(whole[:end])
        with Ledger(path, study, "mark") as ledger:
            assert sorted(ledger.rows) == list(range(6 if end == len(whole) else 4))
            ledger.add([Row(7, (float("inf"),), "so")])
        with Ledger(path, study, "mark") as ledger:
            assert ledger.rows[7] == Row(7, (float("inf"),), "so") and ledger.rows[3] == rows[3]
    path.write_bytes(lines[0] + lines[1].replace(b"0.333", b"0.334") + lines[2])
    with Ledger(path, study, "mark") as ledger:
        assert sorted(ledger.rows) == [2, 3]
    with pytest.raises(StudyError, match="holds another study"):
        Ledger(path, study, "other")
    with Ledger(path, study, "mark"), pytest.raises(StudyError, match="is at work"):
        Ledger(path, study, "mark")
    path.write_bytes(b"something\nelse\n")
    with pytest.raises(StudyError, match="no record"):
        Ledger(path, study, "mark")
    assert path.read_bytes() == b"something\nelse\n"


def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(capsys, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "small.json"
    file.write_text(SMALL)
    whole = executors.in_process

    def breaks_off(study: Study, missing: Sequence[int]):
        yield next(whole(study, missing))
        raise KeyboardInterrupt
    monkeypatch.setattr(executors, "in_process", breaks_off)
    words = ["study", str(file), "--workers", "1", "-o", str(tmp_path / "out")]
    assert main(words) == 130
    assert "stopped with 1 of 8 runs done; the same command goes on" in capsys.readouterr().err
    monkeypatch.setattr(executors, "in_process", whole)
    assert main([*words, "--json"]) == 0
    out, err = capsys.readouterr()
    record = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert "1 of 8 runs are done already" in err and len(record["rows"]) == 8
    assert record["digest"] == digest(study_of(SMALL), programs()) and record["study"]["collect"] == ["final_error"]


def test_without_dask_one_sentence_says_how_to_get_it(capsys, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "small.json"
    file.write_text(SMALL)
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "observer-lab[study]" in refused(capsys, "study", str(file), "--scheduler", "tcp://127.0.0.1:1", "-o", str(tmp_path / "out"))
    assert "not both" in refused(capsys, "study", str(file), "--scheduler", "tcp://127.0.0.1:1", "--workers", "2")


def test_the_example_of_the_help_is_a_study() -> None:
    words = FORMAT[FORMAT.index("{"):FORMAT.index("set and vary take")]
    study = study_of(words)
    assert study.shape == (41, 2, 5, 7) and study.runs == 20 and study.collect == ("largest_asked", "check.home")


# --- plants ------------------------------------------------------------------------------------------------------------------
def test_entries_and_factors_of_an_own_plant_vary_as_if_written_by_hand() -> None:
    study = study_of(json.dumps({"lesson": "virtual-sensor", "plant": "motor", "set": {"noise": 0}, "vary": {
        "A(4,4)": [-3.0, -5.0], "inertia": {"values": [2.0], "over": ["A(2,2)", "A(2,1)"], "times": ["B(1,1)"]}}}))
    rows = rows_of(study)
    for index, value in enumerate((-3.0, -5.0)):
        plant = json.loads(example("motor"))
        plant["A"][3][3], plant["A"][1][1], plant["A"][1][0] = value, plant["A"][1][1] / 2, plant["A"][1][0] / 2
        plant["B"][0][0] *= 2
        assert from_json(json.dumps(plant)).n == 4
        lesson = LESSONS["virtual-sensor"].fit(json.dumps(plant))
        own = numbers(lesson.compute(lesson.start()))
        assert rows[index].values == tuple(own[name] for name in study.collect) and not rows[index].problem
    assert rows[0] != rows[1]
    bilinear = rows_of(study_of(json.dumps({"lesson": "bilinear-observer", "plant": "exchanger", "collect": ["first_error"], "vary": {
        "F(1,1)": [-1.5, -2.5], "mean": {"values": [2.0], "times": ["K(1,4)"]}}})))
    plant = json.loads(example("exchanger"))
    plant["F"][0][0], plant["K"][0][3] = -2.5, 2 * plant["K"][0][3]
    lesson = LESSONS["bilinear-observer"].fit(json.dumps(plant))
    assert bilinear[1].values == (lesson.compute(lesson.start()).metrics["first_error"],) and bilinear[0] != bilinear[1]


def test_a_point_that_its_lesson_refuses_says_why_and_the_others_go_on() -> None:
    study = study_of(json.dumps({"lesson": "observability", "plant": "motor", "vary": {"A(2,1)": [250.0, -1e290, 100.0]}}))
    rows = rows_of(study)
    assert rows[1].problem and set(rows[1].values) == {None} and not rows[0].problem and not rows[2].problem


# --- numbers -----------------------------------------------------------------------------------------------------------------
def test_a_summary_has_the_median_and_the_band_of_the_runs_that_gave_a_number() -> None:
    study = Study("separation", seeds=(1.0, 2.0, 3.0, 4.0), collect=("m", "check.c", "none"))
    rows = {i: Row(i, (value, float(i < 3), None)) for i, value in enumerate((1.0, None, 3.0, float("inf")))}
    metric, check, none = summaries(study, rows)
    assert (metric.count, metric.middle, metric.low, metric.high) == (3, 3.0, pytest.approx(1.2), np.inf)
    assert check.middle == 0.75 and (check.low, check.high) == wilson(3, 4) and none.count == 0 and np.isnan(none.middle)


@each("holds, count, low, high", [(0, 10, 0.0, 0.27753), (5, 10, 0.23659, 0.76341), (81, 263, 0.2553, 0.3662)])
def test_wilsons_interval_is_the_published_one(holds: int, count: int, low: float, high: float) -> None:
    """The last row is Newcombe's of 1998; the others solve |p − share| = z √(p(1−p)/n) by hand."""
    assert wilson(holds, count) == (pytest.approx(low, abs=6e-5), pytest.approx(high, abs=6e-5))


@pytest.mark.slow
def test_figures_of_nothing_and_of_two_things_speak_either_language() -> None:
    vary = {"guess_q": [-1, 0, 1], "input": ["none", "sine"]}
    for language, names in (("zh", ()), ("en", ("input", "guess_q"))):
        study = study_of(json.dumps({"lesson": "error-dynamics", "vary": {name: vary[name] for name in names},
                                     "collect": ["final_error", "check.observer"]}))
        rows = rows_of(study)
        picture = figure_as(study, rows, summaries(study, rows), "svg", language, "1.token")
        assert picture.count(b'id="axes_') == (4 if len(names) == 2 else 2) and b"1.token" in picture


# --- the gate ----------------------------------------------------------------------------------------------------------------
@each("given, told", [
    ("", "no JSON"), ("[1]", "no JSON object"), ("[" * 100_000, "no JSON"), ('{"lesson": "nope"}', "no lesson nope"),
    ("{}", "no lesson None"),
    ('{"lesson": "noise", "lesson": "noise"}', "twice"), ('{"lesson": "noise", "vari": 1}', "no vari"),
    ('{"lesson": "noise", "set": {"foo": 1}}', "no knob foo"), ('{"lesson": "noise", "set": {"w": 1e9}}', "within"),
    ('{"lesson": "noise", "set": {"w": NaN}}', "NaN"), ('{"lesson": "noise", "set": [1]}', "object of names"),
    ('{"lesson": "noise", "vary": {"foo": [1]}}', "no knob foo"), ('{"lesson": "noise", "vary": {"w": []}}', "not empty"),
    ('{"lesson": "noise", "vary": {"w": 3}}', "list of values"), ('{"lesson": "noise", "vary": {"w": {"from": 1}}}', "lacks to, count"),
    ('{"lesson": "noise", "vary": {"w": {"from": 1, "to": 2, "count": 2.5}}}', "whole number"),
    ('{"lesson": "noise", "vary": {"w": {"from": -1, "to": 2, "count": 3}}}', "above 0"),
    ('{"lesson": "noise", "vary": {"w": {"from": "a", "to": 2, "count": 3}}}', "no number"),
    ('{"lesson": "noise", "vary": {"w": [1, 1]}}', "the same"), ('{"lesson": "noise", "vary": {"w": [[1]]}}', "must be a number"),
    ('{"lesson": "noise", "vary": {"w": [1]}, "set": {"w": 1}}', "set and varied"),
    ('{"lesson": "noise", "vary": {"A(1,1)": [1]}}', "plant of your own"),
    ('{"lesson": "noise", "plant": "motor", "vary": {"A(9,1)": [1]}}', "4×4"),
    ('{"lesson": "noise", "plant": "motor", "vary": {"mass": [1]}}', "neither a knob"),
    ('{"lesson": "noise", "plant": "motor", "vary": {"mass": {"values": [0], "over": ["A(1,1)"]}}}', "divides"),
    ('{"lesson": "noise", "plant": {"A": [[1]]}}', "B"), ('{"lesson": "arm", "plant": "motor"}', "own plant"),
    ('{"lesson": "noise", "plant": 3}', "plant is"), ('{"lesson": "noise", "seeds": 0}', "1 to 10000"),
    ('{"lesson": "noise", "seeds": [1, 10000]}', "within"), ('{"lesson": "noise", "seeds": 3, "set": {"seed": 4}}', "seed is a knob"),
    ('{"lesson": "arm", "seeds": 3}', "draws nothing"), ('{"lesson": "noise", "seed": -1}', "whole number"),
    ('{"lesson": "arm", "final": 1}', "true or false"), ('{"lesson": "separation", "final": true}', "no long computation"),
    ('{"lesson": "noise", "collect": ["foo"]}', "no foo"), ('{"lesson": "noise", "collect": []}', "list of names"),
    ('{"lesson": "noise", "seeds": 10000, "vary": {"w": {"from": 0.1, "to": 1, "count": 21}}}', f"at most {MAX_STUDY_RUNS}"),
])
def test_the_gate_refuses_in_one_sentence(given: str, told: str) -> None:
    with pytest.raises(StudyError) as refusal:
        study_of(given)
    words = str(refusal.value)
    assert told in words and len(words) < 700 and "\n" not in words and words.endswith("."), words


def test_a_file_that_cannot_be_read_or_a_folder_that_cannot_be_used_is_one_sentence(capsys, tmp_path: Path) -> None:
    file = tmp_path / "s.json"
    assert "cannot be read" in refused(capsys, "study", str(file))
    file.write_text('{"lesson": "noise", "plant": "none.json"}')
    assert "none.json cannot be read" in refused(capsys, "study", str(file))
    file.write_text(SMALL)
    assert "cannot be used" in refused(capsys, "study", str(file), "-o", str(file))
    assert "1 to 256" in refused(capsys, "study", str(file), "--workers", "0")
