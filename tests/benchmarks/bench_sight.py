"""Measures every lesson on the page in both languages at seven sizes: first knob, smallest words, what is cut, what overlaps.

`PYTHONPATH=. python tests/benchmarks/bench_sight.py [LESSON …] [--size laptop|…] [--language en|zh] [--sheets]`; a line for each page,
and at the end how many keep each law. One tab walks through all lessons of a size, a few seconds a page without a graphics card. With
`--sheets` a picture of every page, or of three parts of a sheet, stays in artefacts/<size>, and all of a size and a language on one
contact sheet, artefacts/sheet-<size>-<language>.png.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "e2e"))

from conftest import ARTEFACTS, chromium, serving
from PIL import Image
from playwright.sync_api import sync_playwright
from sight import WAITING, Sight, look
from tab import FLAGS, ON_TOP, Tab

from observer_lab.lessons import LESSONS
from observer_lab.page.words import phrases

SIZES = {"laptop": (1366, 768, False), "hall": (1920, 1080, True), "wall": (3840, 2160, True), "projector": (1024, 768, False),
         "tablet": (768, 1024, False), "phone": (390, 844, False), "across": (844, 390, False)}
BY_HAND = ("tablet", "phone", "across")  # a finger presses, and a sheet takes the place of the columns
SHOWN = "predict", "knobs", "curves"  # the parts of it that are pictured
THUMB, ACROSS, GAP = 640, 4, 8  # px of a picture's width on a contact sheet, how many in a row, px between two


def pages(tab: Tab, lessons: list[str], languages: list[str], large: bool) -> Iterator[tuple[str, str, Sight]]:
    """Every lesson in every language, measured, its prediction skipped."""
    if large:
        tab.key("m")
    now = "en"
    for language in languages:
        if language != now:
            tab.key("l")
            now = language
        for lesson in lessons:
            words = LESSONS[lesson].words[language]
            if tab.page.locator(".ol-parts").is_visible():  # of a phone
                tab.page.locator(".ol-parts [data-part=predict]").click()
            tab.choose_lesson(words.title, words.question, phrases.LESSON(language))
            hidden = tab.page.evaluate(WAITING) if not tab.page.locator(".ol-parts").is_visible() else []
            if tab.page.locator(".ol-veil").count():
                tab.predict(phrases.SKIP(language))
                tab.reveal(phrases.REVEAL(language))
            tab.answered(rests=True)
            tab.close_any_notices()
            seen = look(tab, large, every=True)
            yield lesson, language, seen._replace(cut=(*hidden, *seen.cut))


def sheet(pictures: list[Path]) -> Image.Image:
    """Pictures of one size in rows."""
    small = []
    for path in pictures:
        with Image.open(path) as picture:
            small.append(picture.convert("RGB").resize((THUMB, round(THUMB * picture.height / picture.width)), Image.Resampling.LANCZOS))
    wide, high = small[0].size
    rows = -(-len(small) // ACROSS)
    whole = Image.new("RGB", (ACROSS * (wide + GAP), rows * (high + GAP)), "white")
    for k, picture in enumerate(small):
        whole.paste(picture, (k % ACROSS * (wide + GAP), k // ACROSS * (high + GAP)))
    return whole


def keep(tab: Tab, size: str, lesson: str, language: str) -> list[Path]:
    """Pictures of the page as it stands: one, or one of each part that a sheet shows of it."""
    folder = ARTEFACTS / size
    folder.mkdir(parents=True, exist_ok=True)
    kept = list[Path]()
    for part in SHOWN if size in BY_HAND else ("",):
        if part:
            tab.page.locator(f".ol-parts [data-part={part}]").click()
            tab.answered(rests=True)
        tab.page.evaluate(ON_TOP)
        kept.append(folder / f"{LESSONS[lesson].number:02d}-{lesson}-{language}{part and '-'}{part}.png")
        tab.picture(kept[-1])
    return kept


def main() -> None:
    """Measure what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("lessons", nargs="*", default=list(LESSONS))
    parser.add_argument("--size", action="append", choices=SIZES)
    parser.add_argument("--language", action="append", choices=("en", "zh"))
    parser.add_argument("--sheets", action="store_true")
    asked = parser.parse_args()
    seen: list[tuple[bool, Sight]] = []
    with serving() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        for size in asked.size or SIZES:
            across, up, large = SIZES[size]
            context = browser.new_context(viewport={"width": across, "height": up}, has_touch=size in BY_HAND, reduced_motion="reduce")
            tab, kept = Tab(context.new_page(), address, drawn=False), dict[str, list[Path]]()
            for lesson, language, sight in pages(tab, asked.lessons, asked.language or ["en", "zh"], large):
                seen.append((large, sight))
                print(f"{size:9} {lesson:18} {language}  knob {sight.knob or 'in view'}  words {sight.words:g} px = 1/{sight.one_over:g} "
                      f"({sight.smallest})  cut {list(sight.cut)[:4]}  over {list(sight.over)[:3]}  empty {sight.empty:.0%}  "
                      f"screens {sight.screens:g}  hall {list(sight.hall)}", flush=True)
                if asked.sheets:
                    kept.setdefault(language, []).extend(keep(tab, size, lesson, language))
            context.close()
            for language, pictures in kept.items():
                sheet(pictures).save(ARTEFACTS / f"sheet-{size}-{language}.png")
    every, halls = [sight for _, sight in seen], [sight for large, sight in seen if large]
    print(f"{len(every)} pages: knob in view {sum(s.knob == '' for s in every)}, nothing cut {sum(not s.cut for s in every)}, no words on "
          f"words {sum(not s.over for s in every)}; in large print {len(halls)}: words at least 1/50 of the height "
          f"{sum(s.one_over <= 50.0 for s in halls)}, as a hall needs it {sum(not s.hall for s in halls)}")


if __name__ == "__main__":
    main()
