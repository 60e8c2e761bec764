"""A person's own record in the browser: its columns are named, a filter is fitted, exported, and run on the second half."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import FileChooser
from tab import Tab, eventually

from observer_lab.lessons import LESSONS
from observer_lab.page.words import phrases
from observer_lab.session.handlers.tasks import CANCELLED

OUTPUT = "output on the unused part"
ROWS, GONE, EMPTY = 800, (50, 51, 120, 610), (7, 90, 733)  # rows that are missing; rows whose output is empty
POLE, STEADY, LEVEL, DISTURBANCE, SENSOR = 0.9, 2.0, 20.0, 0.05, 0.2  # x⁺ = 0.9 x + 0.2 u + w, y = x + 20 °C + v; deviations of w and v


@dataclass(frozen=True, eq=False)
class Heater:
    """A log of a heater as bytes, and what it holds: u (N, 1), y (N, 1) with NaN in gaps, the true temperature (N,)."""

    log: bytes
    u: np.ndarray
    y: np.ndarray
    clean: np.ndarray


def heater() -> Heater:
    """A semicolon file with decimal commas, ISO times and gaps."""
    rng, x, rows = np.random.default_rng(1), 0.0, ["Zeit;Heizung [V];T1 [°C];Raum"]
    u, y, clean = np.zeros((ROWS, 1)), np.full((ROWS, 1), np.nan), np.zeros(ROWS)
    on = np.repeat(rng.integers(0, 2, ROWS), 7)
    for k in range(ROWS):
        u[k] = 1.5 * on[k]
        clean[k] = x + LEVEL
        read = round(float(clean[k] + SENSOR * rng.standard_normal()), 4)
        x = POLE * x + (1 - POLE) * STEADY * float(u[k, 0]) + DISTURBANCE * rng.standard_normal()
        if k not in (*GONE, *EMPTY):
            y[k] = read
        said = "" if k in EMPTY else f"{read:.4f}"
        if k not in GONE:
            rows.append(f"2026-01-05T10:{k // 60:02d}:{k % 60:02d};{u[k, 0]};{said};21.5".replace(".", ","))
    return Heater("\n".join(rows).encode(), u, y, clean)


def chosen(tab: Tab) -> FileChooser:
    """The browser's dialog for files, opened by the page's button."""
    with tab.page.expect_file_chooser() as chooser:
        tab.page.get_by_role("button", name=phrases.UPLOAD_RECORD("en")).first.click()
    return chooser.value


def name_column(tab: Tab, column: str, role: str) -> None:
    """Say in the preview what a column of the file is."""
    field = tab.row(phrases.COLUMN("en").format(name=column)).locator("input").first
    field.click()
    tab.page.locator(f'xpath=//*[@role="option"][normalize-space(.)="{role}"]').locator("visible=true").click()
    tab.answered()


@pytest.mark.slow
def test_a_file_becomes_a_filter_that_runs_on_its_second_half(
        new_tab: Callable[..., Tab], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = heater()
    file = tmp_path / "heater.csv"
    file.write_bytes(log.log)
    tab, words = new_tab(), LESSONS["record"].words["en"]
    tab.choose_lesson(words.title, words.question)
    assert dict(tab.curves())[OUTPUT][0][0] == 40  # s: the lesson's own record
    tab.unfold(phrases.RECORD_FILE("en"))
    chosen(tab).set_files(file)
    eventually(tab.page.get_by_text("say which one is the time").count, lambda n: n == 1, "the question about the columns")
    assert tab.button(phrases.USE_RECORD("en")).is_disabled()
    for column, role in (("Zeit", phrases.ROLE_TIME), ("Heizung [V]", phrases.ROLE_INPUT), ("T1 [°C]", phrases.ROLE_OUTPUT)):
        name_column(tab, column, role("en"))
    eventually(tab.page.get_by_text("Step 1 s, 800 rows, 800 s.").count, lambda n: n == 1, "what was read")
    assert tab.page.get_by_text("Rows that are missing: 4.").count() == 1
    tab.press(phrases.USE_RECORD("en"))
    eventually(lambda: dict(tab.curves()).get(OUTPUT, [[None]])[0][0], lambda first: first == ROWS // 2,
               "the second half of the record as a figure")
    fitted = tab.shown()
    assert tab.value("order of the model") == 1
    tab.predict("A")
    tab.key("e")
    tab.page.locator(".mantine-Modal-content").get_by_role("tab", name=phrases.SCRIPTS("en"), exact=True).click()
    with tab.page.expect_download() as download:
        tab.button(phrases.PYTHON("en")).first.click()
    script = tmp_path / download.value.suggested_filename
    download.value.save_as(script)
    assert script.suffix == ".py" and tab.shown() == fitted
    judge_on_the_second_half(script, log, monkeypatch)
    eventually(tab.close_a_dialog, lambda left: left == 0, "the dialog closed")


def judge_on_the_second_half(script: Path, log: Heater, monkeypatch: pytest.MonkeyPatch) -> None:
    """The exported filter, on rows that no fit has seen, is about as good as the best filter of the plant that made them."""
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    half, settled = np.arange(ROWS // 2, ROWS), 30
    _, found, sigma, _ = runpy.run_path(str(script))["estimate"](half.astype(float), log.u[half], log.y[half])
    away = (found[:, 0] - log.clean[half[-len(found):]])[settled:]
    error, best = float(np.sqrt(np.mean(away**2))), error_of_the_best(log, half, settled)
    assert 0.9 * best < error < 1.25 * best < 0.8 * SENSOR, (error, best)
    assert 0.7 < error / np.median(sigma) < 1.4, (error, np.median(sigma))  # and its own sigma says so


def error_of_the_best(log: Heater, rows: np.ndarray, settled: int) -> float:
    """Root mean square error of the scalar Kalman filter that knows the plant and its noises."""
    x, P, away = 0.0, 1.0, []
    for k in rows:
        if np.isfinite(log.y[k, 0]):
            gain = P / (P + SENSOR**2)
            x, P = x + gain * (log.y[k, 0] - LEVEL - x), (1 - gain) * P
        away.append(x + LEVEL - log.clean[k])
        x, P = POLE * x + (1 - POLE) * STEADY * log.u[k, 0], POLE**2 * P + DISTURBANCE**2
    return float(np.sqrt(np.mean(np.square(away[settled:]))))


DROP = """([name, words]) => {
  const folder = document.querySelector('input[type=file][accept*=".csv"]').closest(window.observerLabViser.parts.folder);
  const data = new DataTransfer();
  data.items.add(new File([words], name, {type: 'text/csv'}));
  const event = type => new DragEvent(type, {bubbles: true, cancelable: true, dataTransfer: data});
  folder.dispatchEvent(event('dragover'));
  const marked = folder.classList.contains('ol-drop-here');
  const kept = !document.body.dispatchEvent(event('drop'));  // beside the folder: the page stays, and nothing is read
  folder.dispatchEvent(event('dragover'));
  folder.dispatchEvent(event('drop'));
  return [marked, kept, folder.classList.contains('ol-drop-here')];
}"""


@pytest.mark.slow
def test_a_file_that_is_dropped_on_the_folder_is_looked_at(new_tab: Callable[..., Tab]) -> None:
    tab, words = new_tab(), LESSONS["record"].words["en"]
    tab.choose_lesson(words.title, words.question)
    tab.unfold(phrases.RECORD_FILE("en"))
    assert tab.page.evaluate(DROP, ["dropped.csv", heater().log.decode()]) == [True, True, False]
    eventually(tab.page.get_by_text("dropped.csv", exact=True).count, lambda n: n == 1, "the preview of the dropped file")


@pytest.mark.slow
def test_a_long_fit_says_how_long_and_is_cancelled(new_tab: Callable[..., Tab], tmp_path: Path) -> None:
    rng, file, rows = np.random.default_rng(1), tmp_path / "long.csv", 9000
    u, y = rng.choice([-1.0, 1.0], rows), np.zeros((rows, 2))
    for k in range(rows - 1):
        y[k + 1] = 0.9 * y[k] + [0.1, 0.2] * (u[k] + 0.3 * rng.standard_normal(2))
    read = y + 0.1 * rng.standard_normal(y.shape)
    lost = rng.random(y.shape) < 0.1
    cells = [["" if gone else f"{value:.4f}" for gone, value in zip(*pair, strict=True)] for pair in zip(lost, read, strict=True)]
    file.write_text("\n".join(["t,u,y1,y2", *(f"{k},{u[k]},{a},{b}" for k, (a, b) in enumerate(cells))]))
    tab, words = new_tab(), LESSONS["record"].words["en"]
    tab.choose_lesson(words.title, words.question)
    before = tab.curves()
    tab.unfold(phrases.RECORD_FILE("en"))
    chosen(tab).set_files(file)
    eventually(tab.page.get_by_text("Step 1 s, 9000 rows").or_(tab.page.get_by_text("9,000 rows")).count, lambda n: n > 0, "what was read")
    tab.press(phrases.USE_RECORD("en"))
    eventually(tab.page.get_by_text("s left.").count, lambda n: n == 1, "how long the fit goes on")
    assert tab.button(phrases.USE_RECORD("en")).is_disabled() and tab.curves() == before
    tab.press(phrases.CANCEL_JOB("en"))
    eventually(tab.page.get_by_text(CANCELLED("en")).count, lambda n: n > 0, "that the fit was cancelled")
    assert tab.page.get_by_text("s left.").locator("visible=true").count() == 0 and tab.curves() == before
    assert tab.button(phrases.USE_RECORD("en")).is_enabled()
