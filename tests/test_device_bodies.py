"""One exported design in every body: the same bits; `tests/benchmarks/laws_of_devices.py` does it for random designs of every lesson."""

import shutil
import subprocess

import numpy as np
import pytest
from device_bodies import SANITIZERS, STRICT, fmu_differences, run_c, run_python, run_wasm, st_differences, write_files

from observer_lab.export.devices.folders import BODIES, device_design, device_files
from observer_lab.export.devices.words import header_line
from observer_lab.lessons import LESSONS

SAME = "every bit as in the lab's Python."


def made(name: str, body: str, **values: object):
    lesson = LESSONS[name]
    outcome = lesson.compute(lesson.apply(lesson.start(), values))
    return device_design(lesson, outcome), device_files(lesson, outcome, "token", body)


@pytest.mark.slow
def test_wasm_under_node_gives_the_same_bits(tmp_path) -> None:
    assert run_wasm(write_files(tmp_path, made("kalman", "c")[1])).endswith(SAME)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["separation", "network"])
def test_fmi_unit_gives_the_same_bits_under_fmpy(tmp_path, name: str) -> None:
    design, files = made(name, "fmu")
    assert fmu_differences(write_files(tmp_path, files) / "lab.fmu", design) == 0


def test_plain_python_gives_the_same_bits(tmp_path) -> None:
    assert run_python(write_files(tmp_path, made("network", "micropython")[1])).endswith(SAME)


@pytest.mark.parametrize("name", ["network", "separation", "robust-observer"])
def test_structured_text_gives_the_same_bits_in_an_interpreter_of_its_subset(name: str) -> None:
    design, files = made(name, "st")
    assert st_differences(str(files["FB_Lab.st"]), design) == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kalman", "fault-diagnosis", "bilinear-observer"])
def test_sanitizers_find_nothing(tmp_path, name: str) -> None:
    assert run_c(write_files(tmp_path, made(name, "c")[1]), SANITIZERS).endswith(SAME)


def test_float_of_a_filter_with_missing_readings_gives_the_same_bits_in_c(tmp_path) -> None:
    lesson = LESSONS["network"]
    outcome = lesson.compute(lesson.start())
    assert run_c(write_files(tmp_path, device_files(lesson, outcome, "token", "c", single=True)), ["-O3"]).endswith(SAME)


def test_simulink_script_holds_the_same_matrices(tmp_path) -> None:
    design, files = made("noise", "simulink")
    folder = write_files(tmp_path, files)
    ran = subprocess.run(["octave-cli", "--quiet", "--eval", "lab_blocks; printf('%.17g ', A, L, Ts);"], cwd=folder, capture_output=True,
                         text=True, check=True)
    tables = {each.name: each.values for each in design.routine.constants}
    by_columns = np.array(tables["A"]).reshape(2, 2).T.ravel()
    assert [float(v) for v in ran.stdout.split()] == [*by_columns, *tables["L"], design.routine.period]


def test_arduino_sketch_names_its_columns_and_compiles_as_c_does(tmp_path) -> None:
    design, files = made("separation", "arduino")
    folder = write_files(tmp_path, files) / "lab"
    assert header_line(design.routine) in (folder / "lab.ino").read_text()
    assert header_line(design.routine) == "# t,u:u1,u:u2,u:u3,y:VL,y:HL,y:VR,y:HR"
    subprocess.run(["gcc", *STRICT, "-c", "lab.c"], cwd=folder, check=True)


def test_every_body_has_a_readme_and_no_name_of_a_signal_leaves_its_place() -> None:
    assert shutil.which("gcc")
    for body in BODIES:
        files = made("noise", body)[1]
        assert "observer" in str(files["README.md"]) and len(files) >= 2
