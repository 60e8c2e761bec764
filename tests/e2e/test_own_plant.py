"""A person's own plant in the browser: a file is chosen, the page becomes that plant's, and a reload knows it."""

from __future__ import annotations

import json
from pathlib import Path

from tab import Tab, eventually

from observer_lab.lessons import LESSONS

PLANTS = Path(__file__).parents[2] / "app" / "plants" / "data"
MINE, TORN = "the plant is faster than its model by [%]", "Upload a plant"
SEVERAL = "inputs, which also multiply the state"
MIXER = {"name": "Mixer", "A": [[-2, 1, 0, 0, 1], [0, -3, 1, 1, 0], [1, 0, -2, 0, 1], [0, 1, 0, -4, 1], [1, 0, 1, 0, -3]],
         "B": [[1, 0], [0, 1], [1, 0], [1, 1], [0, 1]], "C": [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 0]],
         "F1": [[0, 0, 0, 1, 1], [1, 0, 0, 0, 1], [0, 1, 0, 1, 0], [0, 0, 1, -1, 0], [0, 0, 0, 0, -1]],
         "F2": [[0, 0, 0, 0, 1], [0, -1, 0, 0, 0], [1, 0, 0, 0, 0], [0, 0, 0, 0, 2], [0, 0, 1, 0, 0]], "K": [[0, 0, 0, 1, 1]]}  # two inputs


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
    takes_a_bilinear_one(tab, tmp_path / "mixer.json")
    assert not tab.complaints


def test_a_plant_that_is_dropped_on_the_button_is_taken(tab: Tab) -> None:
    lesson = tab.shown()
    tab.page.get_by_role("button", name=TORN).first.evaluate("""(button, words) => {
      const data = new DataTransfer();
      data.items.add(new File([words], 'motor.json', {type: 'application/json'}));
      button.dispatchEvent(new DragEvent('drop', {bubbles: true, cancelable: true, dataTransfer: data}));
    }""", (PLANTS / "motor.json").read_text(encoding="utf-8"))
    eventually(tab.shown, lambda shown: shown != lesson and "output tachometer" in shown, "the plant's own plots")


def takes_a_bilinear_one(tab: Tab, file: Path) -> None:
    """The motor came along, which is linear; F1, F2 and K of the next file are the page's, and each input has a drive of its own."""
    words = LESSONS["bilinear-observer"].words["en"]
    tab.choose_lesson(words.title, words.question)
    eventually(tab.page.get_by_text("F is zero").count, lambda n: n > 0, "a linear plant")
    assert SEVERAL not in tab.shown()
    file.write_text(json.dumps(MIXER), encoding="utf-8")
    choose(tab, file)
    eventually(tab.page.get_by_text("This page shows “Mixer”").count, lambda n: n > 0, "the note at the head")
    mixer = eventually(tab.shown, lambda shown: SEVERAL in shown, "both inputs")
    tab.slide("amplitude of u2", "ArrowRight", 3)
    eventually(tab.shown, lambda shown: shown != mixer and SEVERAL in shown, "the curves follow its input")
