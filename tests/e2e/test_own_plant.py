"""A person's own plant in the browser: a file is chosen, the page becomes that plant's, and a reload knows it."""

from __future__ import annotations

from pathlib import Path

from tab import Tab, eventually

PLANTS = Path(__file__).parents[2] / "app" / "plants" / "data"
MINE, TORN = "the plant is faster than its model by [%]", "Upload a plant"


def choose(tab: Tab, file: str | Path) -> None:
    """Choose a file with the upload button."""
    with tab.page.expect_file_chooser() as chooser:
        tab.page.get_by_role("button", name=TORN).first.click()
    chooser.value.set_files(file)


def test_an_uploaded_plant_changes_the_plots_and_survives_a_torn_file_and_a_reload(tab: Tab, tmp_path: Path) -> None:
    lesson = tab.shown()
    choose(tab, PLANTS / "motor.json")
    note = tab.page.get_by_text("This page shows “Motor with a flexible shaft”")
    eventually(note.count, lambda n: n > 0, "the note at the head")
    mine = eventually(tab.shown, lambda shown: shown != lesson and "output tachometer" in shown, "the plant's own plots")
    torn = tmp_path / "torn.json"
    torn.write_text("{", encoding="utf-8")
    choose(tab, torn)
    eventually(lambda: tab.page.get_by_text("not readable JSON").count(), lambda n: n > 0, "one sentence")
    assert "output tachometer" in tab.shown()
    tab.page.reload()
    tab.settle()
    assert "output tachometer" in eventually(tab.shown, lambda shown: "tachometer" in shown, "the plant after a reload")
    tab.slide(MINE, "ArrowRight", 5)
    eventually(tab.shown, lambda shown: shown != mine, "a curve follows the plant's own slider")
    assert not tab.complaints
