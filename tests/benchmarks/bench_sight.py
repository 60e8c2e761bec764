"""Measures every lesson on the page in both languages at four sizes: first knob, smallest words, what is cut, what overlaps.

`PYTHONPATH=. python tests/benchmarks/bench_sight.py [LESSON …] [--size laptop|hall|wall|phone] [--language en|zh]`; a line for each page,
and at the end how many keep each law. Takes about twenty seconds a page without a graphics card.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "e2e"))

from conftest import chromium, serving
from playwright.sync_api import sync_playwright
from sight import Sight, look
from tab import FLAGS, Tab

from lessons import LESSONS

SIZES = {"laptop": (1366, 768, False), "hall": (1920, 1080, True), "wall": (3840, 2160, True), "phone": (390, 844, False)}


def measure(tab: Tab, lesson: str, language: str, large: bool) -> Sight:
    """Open a lesson in a language and look at it."""
    words = LESSONS[lesson].words["en"]
    tab.choose_lesson(words.title, words.question)
    tab.predict("skip")
    if large:
        tab.key("m")
    if language != "en":
        tab.key("l")
    tab.answered(rests=True)
    tab.close_any_notices()
    return look(tab)


def main() -> None:
    """Measure what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("lessons", nargs="*", default=list(LESSONS))
    parser.add_argument("--size", action="append", choices=SIZES)
    parser.add_argument("--language", action="append", choices=("en", "zh"))
    asked = parser.parse_args()
    pages, knobs, cuts, overs, small, halls = 0, 0, 0, 0, 0, 0
    with serving() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        for size in asked.size or SIZES:
            across, up, large = SIZES[size]
            for lesson in asked.lessons:
                for language in asked.language or ("en", "zh"):
                    context = browser.new_context(viewport={"width": across, "height": up}, has_touch=size == "phone")
                    seen = measure(Tab(context.new_page(), address, drawn=False), lesson, language, large)
                    context.close()
                    pages += 1
                    knobs += seen.knob == ""
                    cuts += not seen.cut
                    overs += not seen.over
                    halls += large
                    small += large and seen.one_over <= 50.0
                    print(f"{size:6} {lesson:18} {language}  knob {seen.knob or 'in view'}  words {seen.words:g} px = 1/{seen.one_over:g} "
                          f"({seen.smallest})  cut {list(seen.cut)[:4]}  over {list(seen.over)[:3]}  empty {seen.empty:.0%}  "
                          f"screens {seen.screens:g}", flush=True)
    print(f"{pages} pages: knob in view {knobs}, nothing cut {cuts}, no words on words {overs}, "
          f"words at least 1/50 of the height on {small} of {halls} in large print")


if __name__ == "__main__":
    main()
