"""Lesson 21: what must come out of its records, and a person's own record in it."""

from __future__ import annotations

import pytest

from observer_lab.cli.entry import main
from observer_lab.cli.records import columns_of
from observer_lab.engine.identification import read_record
from observer_lab.lessons import LESSONS
from observer_lab.lessons.record.data import TRUTHS, record_of
from observer_lab.lessons.record.own import with_record

LESSON = LESSONS["record"]
TEXT = "t [s],gas [ft3/min],y [%]\n"


def metrics(**changes: object) -> dict[str, float]:
    return dict(LESSON.compute(LESSON.apply(LESSON.start(), changes)).metrics)


def csv() -> str:
    record = record_of("spring", 5).record
    rows = zip(record.t, record.u[:, 0], record.y[:, 0], strict=True)
    return TEXT + "".join(f"{t:.3f},{u},{y:.6f}\n" for t, u, y in rows)


@pytest.mark.parametrize("data, order", [("spring", 2), ("tanks", 2), ("masses", 4)])
def test_a_simulated_record_gives_its_order_poles_noise_and_a_consistent_filter(data: str, order: int) -> None:
    found = metrics(data=data, order=order)
    assert found["suggested"] == order and found["away"] < 3
    assert found["nis_low"] < found["mean_nis"] < found["nis_high"] and found["white_p"] > 0.01
    assert found["sensor"] == pytest.approx(TRUTHS[data].r, rel=0.2)


def test_the_smoother_is_nearer_to_the_truth_than_the_filter() -> None:
    for data, order in (("spring", 2), ("masses", 4)):
        found = metrics(data=data, order=order)
        assert found["smoother_error"] < 0.9 * found["filter_error"]


def test_the_measured_record_changes_and_the_lesson_says_so() -> None:
    record = record_of("furnace", 0).record
    assert record.rows == 296 and record.dt == pytest.approx(9.0)
    assert (record.u[0, 0], record.y[0, 0], record.y[-1, 0]) == (-0.109, 53.8, 57.0)  # as printed
    found = metrics(data="furnace")
    assert found["mean_nis"] > found["nis_high"] and found["fit"] > 80


def test_a_record_of_ones_own_opens_in_the_lesson() -> None:
    own = with_record(LESSON, read_record(csv(), inputs=("gas",), outputs=("y",)))
    outcome = own.compute(own.start())
    assert own.start()["data"] == "own" and outcome.metrics["nis_low"] < outcome.metrics["mean_nis"] < outcome.metrics["nis_high"]
    assert {f.id for f in own.figures(outcome)} == {f.id for f in LESSON.figures(LESSON.compute(LESSON.start()))}
    other = own.compute(own.apply(own.start(), {"data": "spring"}))
    assert dict(other.metrics) == metrics()


def test_signs_of_a_page_are_taken_out_of_names() -> None:
    record = read_record(csv().replace("gas", "<b>g$"), inputs=("<b>g$",), outputs=("y",))
    found = with_record(LESSON, record)
    study = found.compute(found.start()).study
    assert not set("<>$") & set("".join(study.found.record.input_names))


def test_run_takes_a_file_and_refuses_in_one_sentence(tmp_path, capsys) -> None:
    path = tmp_path / "mine.csv"
    path.write_text(csv(), encoding="utf-8")
    assert main(["run", "record", "--data", str(path), "--columns", "u=gas,y=y"]) == 0
    assert "mean_nis" in capsys.readouterr().out
    for words in (["kalman", "--data", str(path)], ["record", "--data", str(tmp_path / "none.csv")],
                  ["record", "--data", str(path), "--columns", "x=gas"], ["record", "--data", str(path), "--plant", "motor"]):
        assert main(["run", *words]) == 2
        said = capsys.readouterr().err
        assert said.startswith("observer-lab: ") and said.count("\n") == 1 and "Traceback" not in said


def test_columns_are_named_one_by_one() -> None:
    assert columns_of("t=time, u=a,u=b,y=c d") == ("time", ("a", "b"), ("c d",))
    assert columns_of("") == ("", (), ())
