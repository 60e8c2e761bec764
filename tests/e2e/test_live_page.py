"""A page beside a simulated plant in the browser. Lines come, a button records and drives. A page that is gone drives no more."""

import os
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import Browser
from tab import PATIENCE, eventually

LIVE = "from observer_lab.cli import main; raise SystemExit(main())"


def last_inputs(record: Path, rows: int = 20) -> list[float]:
    """The first input of the last whole rows of a record that is being written."""
    whole = record.read_text().rpartition("\n")[0].splitlines()[1:]
    return [float(row.split(",")[1]) for row in whole[-rows:]]


def test_page_that_drives_is_marked_and_drives_no_more_once_it_is_gone(browser: Browser, tmp_path) -> None:
    env = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    options = ("saturation", "--simulate", "--page", "0", "--drive", "3", "--record", "run.csv")
    served = subprocess.Popen([sys.executable, "-c", LIVE, "live", *options], cwd=tmp_path, env=env, stdout=subprocess.PIPE, text=True)
    try:
        assert served.stdout is not None
        page = browser.new_page(viewport={"width": 1366, "height": 768})
        errors: list[str] = []
        page.on("pageerror", lambda problem: errors.append(str(problem)))
        page.goto(served.stdout.readline().strip())
        running, patience = page.locator(".ol-running"), 1000 * PATIENCE
        running.get_by_text("taken").wait_for(timeout=patience)
        assert page.locator(".ol-driven").count() == 0 and set(last_inputs(tmp_path / "run.csv")) == {0.0}
        page.get_by_role("button", name="Drive the plant: send u").click(timeout=patience)
        page.locator(".ol-driven").wait_for(timeout=patience)
        eventually(lambda: last_inputs(tmp_path / "run.csv"), any, "an input that is sent")
        assert max(map(abs, last_inputs(tmp_path / "run.csv", 10_000))) <= 3.0
        assert errors == []
        page.close()
        eventually(lambda: set(last_inputs(tmp_path / "run.csv")), lambda inputs: inputs == {0.0}, "u = 0 without the page")
    finally:
        served.terminate()
        served.wait(60)
