"""A record from a CSV text: what is read, and what is refused in one sentence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from record_files import all_files, table, wrong
from scipy.io import savemat

from observer_lab.engine import EngineError, Plant, to_json
from observer_lab.engine.identification import Record, load_record, read_record
from observer_lab.engine.plant_files import read_plant

ROWS = 12


def rows(*columns: object, mark: str = ",") -> str:
    return "".join(mark.join(str(column(k) if callable(column) else column) for column in columns) + "\n" for k in range(ROWS))


def test_names_and_units_of_the_head_are_kept() -> None:
    record = read_record("t [ms], u1 [V],y1 (mm), other\n" + rows(lambda k: 10 * k, 1, lambda k: k * k, 7))
    assert (record.input_names, record.output_names) == (("u1",), ("y1",))
    assert (record.unit("u1"), record.unit("y1"), record.rows) == ("V", "mm", ROWS)
    assert record.dt == pytest.approx(0.01)
    np.testing.assert_array_equal(record.y[:, 0], np.arange(ROWS) ** 2)


@pytest.mark.parametrize("text", [
    "Time;gas;CO2\n" + rows(lambda k: f"{k},0", "1,5", lambda k: f"{k},25", mark=";"),
    "Time\tgas\tCO2\n" + rows(lambda k: k, 1.5, lambda k: k + 0.25, mark="\t"),
    "\ufeffTime gas CO2\n# a remark\n".lstrip("\ufeff") + rows(lambda k: k, 1.5, lambda k: k + 0.25, mark=" "),
    "Time,gas,CO2\n" + rows(lambda k: f"2026-11-25T13:00:{k:02d}Z", 1.5, lambda k: k + 0.25),
])
def test_other_separators_decimal_commas_and_dates_are_read(text: str) -> None:
    record = read_record(text, inputs=("gas",), outputs=("CO2",))
    np.testing.assert_allclose(record.t, np.arange(ROWS))
    np.testing.assert_allclose(record.u[:, 0], 1.5)
    np.testing.assert_allclose(record.y[:, 0], np.arange(ROWS) + 0.25)


def test_an_empty_output_cell_is_a_missing_measurement() -> None:
    record = read_record("t,u,y\n" + rows(lambda k: k, 1, lambda k: "" if k == 4 else k))
    assert np.flatnonzero(np.isnan(record.y[:, 0])).tolist() == [4]


REFUSED = {
    "holds no rows": "t,u,y\n",
    "two columns are called u": "t,u,u\n" + rows(1, 2, 3),
    "no column is called t": "a,u,y\n" + rows(1, 2, 3),
    "no column is an output": "t,u,z\n" + rows(lambda k: k, 2, 3),
    "unit furlong": "t [furlong],u,y\n" + rows(lambda k: k, 1, 2),
    "2 instead of 3": "t,u,y\n" + rows(lambda k: k, 1, lambda k: k).replace("3,1,3\n", "3,1\n"),
    "row 5, column y: broken": "t,u,y\n" + rows(lambda k: k, 1, lambda k: k).replace("3,1,3\n", "3,1,broken\n"),
    "input u is missing in row 5": "t,u,y\n" + rows(lambda k: k, lambda k: "" if k == 3 else 1, lambda k: k),
    "row 5 has no time": "t,u,y\n" + rows(lambda k: "" if k == 3 else k, 1, lambda k: k),
    "row 5 is not later": "t,u,y\n" + rows(lambda k: 2 if k == 3 else k, 1, lambda k: k),
    "not a date": "t,u,y\n" + rows(lambda k: "2026-11-25 13:00:00" if not k else "later", 1, lambda k: k),
    "8 to 1000000 rows": "t,u,y\n1,2,3\n2,3,4\n",
    "no measurement at all": "t,u,y\n" + rows(lambda k: k, 1, ""),
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_cannot_be_read_is_refused_in_one_sentence_that_says_where(words: str) -> None:
    with pytest.raises(EngineError) as found:
        read_record(REFUSED[words])
    said = str(found.value)
    assert words.lower() in said.lower() and said.endswith(".") and "\n" not in said


@pytest.mark.parametrize("given, words", [({"time": "clock"}, "no column clock"), ({"inputs": ("y",), "outputs": ("y",)}, "only one of")])
def test_columns_that_are_chosen_wrongly_are_refused(given: dict[str, object], words: str) -> None:
    with pytest.raises(EngineError, match=words):
        read_record("t,u,y\n" + rows(lambda k: k, 1, lambda k: k), **given)  # type: ignore[arg-type]


def test_a_file_is_read_as_its_text_and_a_missing_or_binary_one_is_refused(tmp_path) -> None:
    text = "t,u,y\n" + rows(lambda k: k, 1, lambda k: k)
    (tmp_path / "a.csv").write_text("\ufeff" + text, encoding="utf-8")
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00")
    np.testing.assert_array_equal(load_record(tmp_path / "a.csv").y, read_record(text).y)
    for name, words in (("none.csv", "cannot be read"), ("b.csv", "not UTF-8"), ("", "cannot be read")):
        with pytest.raises(EngineError, match=words):
            load_record(tmp_path / name)


def test_no_file_of_the_table_is_read_wrongly() -> None:
    """At least 60 files, each with its right value or its sentence; those of libraries that are not installed are left out."""
    files = all_files()
    assert len(files) > 60
    assert [(file.name, *wrong(file)) for file in files if wrong(file)[0]] == []


def test_the_table_sees_a_wrong_answer() -> None:
    file = next(file for file in all_files() if file.name == "time_ms")
    for data in (file.data.replace(b"time_ms", b"time_us"), file.data.replace(b"20.5", b"20.6"), file.data.replace(b"temp", b"other")):
        assert wrong(replace(file, data=data))[0]
    assert wrong(replace(file, refused="nothing"))[0]


def test_a_plant_given_as_a_record_and_a_record_given_as_a_plant_point_to_each_other(tmp_path) -> None:
    savemat(tmp_path / "r.mat", {"t": np.arange(9.0), "u": np.ones(9), "y": np.ones(9)})
    for name, data in (("r.csv", b"t,u,y\n"), ("r.mat", (tmp_path / "r.mat").read_bytes())):
        with pytest.raises(EngineError, match="lesson record with --data"):
            read_plant(name, data)
    (tmp_path / "p.json").write_text(to_json(Plant([[-1]], [[1]], [[1]])), encoding="utf-8")
    with pytest.raises(EngineError, match="plant with --plant"):
        load_record(tmp_path / "p.json")


def test_a_large_plain_file_is_read_as_a_small_one() -> None:
    text = table(lambda k: f"{0.5 * k:.1f}")
    odd = text.replace("\n2.0,", "\n 2.0 ,", 1).replace("20.5", "2.05E1")
    np.testing.assert_array_equal(read_record(text).u, read_record(odd).u)


def test_the_step_is_that_of_all_rows_or_none() -> None:
    t = np.arange(20.0)
    assert Record(t, np.zeros((20, 0)), np.ones(20)).dt == 1
    t[7] += 0.2
    assert Record(t, np.zeros((20, 0)), np.ones(20)).dt == 0


def test_times_with_too_few_decimals_are_read_at_their_regular_step_and_it_is_said() -> None:
    """A log at 30 Hz with times to 0.01 s is regular; one with a missing row, or with other times, is not made so."""
    times = [f"{k / 30:.2f}" for k in range(300)]
    head, rows = "t [s],u,y\n", [f"{t},{k % 5},{k % 3}\n" for k, t in enumerate(times)]
    record = read_record(head + "".join(rows))
    assert record.dt == pytest.approx(1 / 30, rel=1e-9) and any("rounded to 0.01 s" in str(note) for note in record.notes)
    for other in (rows[:150] + rows[151:], [*rows[:200], "6.69,0,0\n", *rows[201:]]):
        record = read_record(head + "".join(other))
        assert not record.dt and not any("rounded" in str(note) for note in record.notes)


@pytest.mark.parametrize("mark, often, asked", [(-200, 30, True), (-40, 30, True), (850, 30, True), (-200, 2, False), (0, 30, False),
                                                (19, 30, False)])
def test_a_number_that_comes_again_and_again_far_from_all_others_is_asked_about(mark: float, often: int, asked: bool) -> None:
    """A temperature between 20 and 60 °C in steps of 0.1, whose logger writes a mark of its own."""
    rng = np.random.default_rng(0)
    y = np.round(40 + 20 * np.sin(np.arange(400) / 9) + rng.standard_normal(400), 1)
    y[rng.permutation(400)[:often]] = mark
    text = "t,u,y\n" + "".join(f"{k},{k % 3},{value:g}\n" for k, value in enumerate(y))
    if asked:
        with pytest.raises(EngineError, match=f"Column y holds {mark} in {often} rows"):
            read_record(text)
        assert np.isnan(read_record(text, missing=(str(mark),)).y).sum() == often
    else:
        assert np.isfinite(read_record(text).y).all()


@pytest.mark.parametrize("levels", [(0.0, 5.0), (-1.0, 1.0), (0.0, 1.0, 200.0)])
def test_a_signal_of_a_few_levels_is_a_signal(levels: tuple[float, ...]) -> None:
    text = "t,u,y\n" + "".join(f"{k},{k % 3},{levels[k % len(levels) * (k % 7 == 0)]:g}\n" for k in range(300))
    assert np.isfinite(read_record(text).y).all()
