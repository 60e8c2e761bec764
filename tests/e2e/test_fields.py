"""Number fields take what a person writes, and hold the value itself where a slider moves in decades."""

from __future__ import annotations

import math

import numpy as np
import pytest
from laws import each
from playwright.sync_api import Page
from tab import Tab

from observer_lab.lessons import LESSONS
from observer_lab.page import web

WIDTH = "assumed Q / true Q"


@pytest.fixture
def reader(blank: Page) -> Page:
    blank.evaluate("source => { (0, eval)(source); }", web.script_call("fields", fields={}))
    return blank


@each("words, unit, meant", [
    ("0.05", "", 0.05), ("5e-2", "", 0.05), ("5E-2", "", 0.05), ("50 m", "", 0.05), ("50m", "", 0.05), (".5", "%", 0.5), ("5 %", "%", 5.0),
    ("5·10⁻¹⁵", "", 5e-15), ("10⁻⁵", "", 1e-5), ("2x10^3", "", 2e3), ("−3", "", -3.0), ("-10³", "", -1e3), ("0,05", "", 0.05),
    ("50 m", "m", 50.0), ("50 mm", "m", 0.05), ("2 m", "mm", 2000.0), ("50 µm", "mm", 0.05), ("50 um", "mm", 0.05), ("3 ms", "ms", 3.0),
    ("12 s", "ms", 12e3), ("2 k", "N", 2e3), ("2 kN", "N", 2e3), ("3 m/s²", "m/s²", 3.0), ("7", "(m/s)² s", 7.0), ("1 µ", "V", 1e-6),
    ("2 m²", "mm²", 2e6),
    ("5 mm² s", "m² s", 5e-6), ("2 mm/s", "m/s", 2e-3), ("3 m/s", "mm/s", 3e3), ("4 mm", "µm", 4e3), ("1 kg", "g", 1e3)])
def test_a_number_is_read_as_it_is_written(reader: Page, words: str, unit: str, meant: float) -> None:
    assert reader.evaluate("([words, unit]) => observerLabFields.read(words, unit)", [words, unit]) == pytest.approx(meant, rel=1e-15)


@each("words, unit", [("", ""), ("abc", ""), ("1,000", ""), ("1 2", ""), ("1.2.3", ""), ("3 Hz", "rad"), ("--1", ""),
                       ("5 mm", "s"), ("e5", ""), ("1 /s", "m/s"), ("1 in", "min"), ("1 k%", "%")])
def test_what_is_no_number_or_could_be_two_is_not_guessed(reader: Page, words: str, unit: str) -> None:
    assert math.isnan(reader.evaluate("([words, unit]) => observerLabFields.read(words, unit)", [words, unit]))


def test_what_the_page_writes_it_reads(reader: Page) -> None:
    rng = np.random.default_rng(0)
    values = (rng.choice([-1.0, 1.0], 400) * 10 ** rng.uniform(-18, 12, 400)).tolist()
    read = reader.evaluate("values => values.map(v => observerLabFields.read(observerLabFields.written(v), ''))", values)
    assert read == pytest.approx(values, rel=5e-3)


def test_a_slider_in_decades_takes_its_value_and_a_slip_costs_one_sentence(tab: Tab) -> None:
    words = LESSONS["kalman"].words["en"]
    tab.choose_lesson(words.title, words.question)
    for typed, value in (("0.5", 0.5), ("20 m", 0.02), ("5·10⁰", 5.0)):
        tab.type_number(WIDTH, typed)
        assert tab.value(WIDTH) == pytest.approx(value, rel=5e-3)
    for slip, sentence in (("nonsense", "finite number"), ("1e9", "0.01 … 100")):
        before = tab.shown()
        tab.type_number(WIDTH, slip)
        assert sentence in tab.notices() and tab.value(WIDTH) == 5.0 and tab.shown() == before
        tab.close_any_notices()
    field = tab.row(WIDTH).locator("input").last
    field.fill("7")
    field.press("Escape")
    assert tab.value(WIDTH) == 5.0
    field.press("ArrowUp")
    tab.answered(rests=True)
    assert tab.value(WIDTH) > 5.0
