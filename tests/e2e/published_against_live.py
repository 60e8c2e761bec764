"""Compare a published folder with the live page, state by state: `python tests/e2e/published_against_live.py FOLDER [LESSON …]`.

It tries every scene of the lessons on entry, every option of its question, its kick, each knob in sight at each of its points, and
one pole at one place, in the languages and themes of the folder. A line for each state that differs, a table at the end; the status
is 1 where one differs, where a page reported an error, or where a request left the folder. `--looks en-light,zh-dark-phone`,
`--kinds entry,option` and `--most 2` choose among them; without `--whole` each lesson is compared in one look after another, in turn.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Browser, Locator, Page, Request, sync_playwright
from tab import ANSWERED, CURVES, FLAGS, HARMLESS, UNDRAWN, eventually

from observer_lab.course.guiding.predictions import prediction_of
from observer_lab.course.knobs import Choice, Knob, Number, Poles, Switch
from observer_lab.course.lesson import Lesson
from observer_lab.course.scenes import Choose, Move, Press, Scene, Solve, entry_values
from observer_lab.engine.kernels import prepare_kernels
from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.page.record.recorded_screen import WINDOWS
from observer_lab.page.words import phrases
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token
from observer_lab.static_pages.points import Points, values_of

SEEN = """() => ({
  card: document.querySelector('.ol-card')?.innerText ?? '', answer: document.querySelector('.ol-answer')?.innerText ?? '',
  way: [...document.querySelectorAll('.ol-way button')].map(each => each.innerText),
  figures: [...document.querySelectorAll('.ol-figure')].filter(each => each.checkVisibility()).map(each => each.innerText),
  captions: [...document.querySelectorAll('.ol-caption')].filter(each => each.checkVisibility()).map(each => each.innerText),
  knobs: [...document.querySelectorAll('[role=slider], input[type=checkbox]')].filter(each => each.checkVisibility())
    .map(each => (each.ariaValueNow === null ? String(each.checked) : Number(each.ariaValueNow).toPrecision(8))),
  boards: Object.entries(window.__viserMutable?.nodeRefFromName ?? {})  // viser keeps the names of what has gone
    .filter(([name, node]) => node && name.startsWith('/board/')).map(([name]) => name).sort(),
})"""
TOLD = 400  # letters of what differs
PIXEL = 2e-3  # of a curve's range: less than one pixel of a chart
KINDS = ("entry", "option", "kick", "knob", "pole")
FORGOTTEN = "() => { try { localStorage.clear(); sessionStorage.clear(); } catch { /* about:blank has none */ } }"
GRIPS = """name => {  // places of the poles on a board, in its own frame
  const points = [];
  window.observerLabViser.node(name)?.traverse(each => {
    if (each.getPositionAt) for (let k = 0; k < (each.instancesCount ?? each.count); k += 1) points.push(each.getPositionAt(k).toArray());
  });
  return points;
}"""
BOARDS = "() => Object.keys(window.__viserMutable.nodeRefFromName).filter(name => /^\\/board\\/[^/]+\\/grips$/.test(name))"
PIXEL_OF = """([name, point]) => {
  const viser = window.observerLabViser, {x, y, width, height} = viser.canvas().getBoundingClientRect(), at = viser.onScreenOf(name, point);
  return [x + at[0] * width, y + at[1] * height];
}"""
STRAIGHT = 1e-3  # of a board's height: the largest distance of a pole from where a straight scale has it


def seen(page: Page) -> dict[str, Any]:
    """What a page shows, with its curves."""
    return {**page.evaluate(SEEN), "curves": sorted(page.evaluate(CURVES), key=lambda curve: curve[0])}


def differences(live: dict[str, Any], published: dict[str, Any]) -> list[str]:
    """In what two pages differ; curves by less than a pixel do not."""
    out = [_told(name, live[name], published[name]) for name in live if name not in ("curves", "way") and live[name] != published[name]]
    if [title for title, _ in live["curves"]] != [title for title, _ in published["curves"]]:
        return [*out, "titles of charts"]
    for (title, ours), (_, theirs) in zip(live["curves"], published["curves"], strict=True):
        if len(ours) != len(theirs) or not all(map(_same_row, ours, theirs)):
            out.append(f"curves of {title}")
    return out


def _told(name: str, live: Any, published: Any) -> str:
    """What differs, with both, those of a list that differ alone."""
    if isinstance(live, list) and len(live) == len(published):
        live, published = ([each for each, other in zip(ours, theirs, strict=True) if each != other]
                           for ours, theirs in ((live, published), (published, live)))
    return f"{name} ({json.dumps(live, ensure_ascii=False)[:TOLD]} live, {json.dumps(published, ensure_ascii=False)[:TOLD]} published)"


def _same_row(ours: list[float | None], theirs: list[float | None]) -> bool:
    known = [abs(value) for value in ours if value is not None]
    most = PIXEL * max([*known, 1e-12])
    return len(ours) == len(theirs) and all(
        (a is None) == (b is None) and (a is None or b is None or abs(a - b) <= most) for a, b in zip(ours, theirs, strict=True))


def at_scene(page: Page, scene: str) -> None:
    """Wait until the card of a scene stands and nothing covers the page: until then no hand can press anything."""
    eventually(lambda: (page.locator(".ol-card").get_attribute("data-scene"), page.locator(".ol-cover:visible").count()),
               lambda found: found == (scene, 0), f"the scene {scene}")


def press(page: Page, value: str) -> None:
    """Press a button of the card, also where something lies over it."""
    page.locator(f'[data-value="{value}"]').first.dispatch_event("click")


def settled(page: Page) -> dict[str, Any]:
    """What a page shows once two looks in a row agree."""
    last: list[dict[str, Any]] = [{}]

    def look() -> bool:
        now = seen(page)
        same, last[0] = now == last[0], now
        page.wait_for_timeout(250)
        return same
    eventually(look, bool, "a page at rest")
    return last[0]


@dataclass
class Pair:
    """The live page and the published one, in one look."""

    live: Page
    published: Page
    served: str
    folder: str
    language: str
    dark: bool

    def open(self, lesson: Lesson, scene: Scene, **knobs: Any) -> None:
        """Open both on a scene as somebody who was never here; the live one with other values of knobs too, where some are given."""
        start = lesson.start()
        begun = lesson.apply(start, {**entry_values(lesson.path, lesson.path.index(scene), start), **knobs})
        token = write_token(lesson, SavedState(begun, self.language, mode="guide", scene=scene.id))
        theme = "dark" if self.dark else "light"
        for page, address in ((self.live, f"{self.served}#{token}"),
                              (self.published, f"{self.folder}?lesson={lesson.id}&lang={self.language}&theme={theme}&scene={scene.id}")):
            page.goto("about:blank")
            page.goto(address)
            at_scene(page, scene.id)

    def differences(self) -> list[str]:
        """In what the two differ once the server has answered the live one and both are at rest."""
        eventually(lambda: self.live.evaluate(ANSWERED, True), lambda said: said is True, "an answer to what was done")
        return differences(settled(self.live), settled(self.published))

    @property
    def pages(self) -> tuple[Page, Page]:
        """Both."""
        return self.live, self.published


@dataclass
class Tally:
    """How many states of each kind were tried, and which differ."""

    tried: Counter[str] = field(default_factory=Counter)
    different: Counter[str] = field(default_factory=Counter)

    def add(self, kind: str, state: str, found: list[str]) -> None:
        """Count one, and print it where it differs."""
        self.tried[kind] += 1
        self.different[kind] += bool(found)
        if found:
            print(f"{state}: {', '.join(found)}", flush=True)

    def table(self) -> str:
        """The counts by kind."""
        rows = [f"{kind:<8} {self.tried[kind]:>6} {self.different[kind]:>10}" for kind in KINDS]
        return "\n".join(["state     tried  different", *rows, f"all      {self.tried.total():>6} {self.different.total():>10}"])


def states(pair: Pair, lesson: Lesson, points: Points, kinds: tuple[str, ...] = KINDS,
           scenes: tuple[Scene, ...] = (), most: int = 0) -> Iterator[tuple[str, str, list[str]]]:
    """Kind and name of each state of a lesson, or of some scenes of it, and in what the two pages differ there."""
    for scene in scenes or lesson.path:
        name = f"{lesson.id}/{scene.id}"
        pair.open(lesson, scene)
        if "entry" in kinds:
            yield "entry", name, pair.differences()
        if "knob" in kinds:
            yield from _knobs(pair, lesson, scene, points, most)
        if "pole" in kinds:
            yield from _pole(pair, lesson, scene, points)
        if isinstance(scene.do, Choose) and "option" in kinds:
            for k in range(len(prediction_of(lesson, scene, "en").options)):
                pair.open(lesson, scene)
                for page in pair.pages:
                    press(page, f"option:{k}")
                    _done(page, scene)
                yield "option", f"{name}/option {k}", pair.differences()
        elif isinstance(scene.do, Press) and scene.do.button == "kick" and "kick" in kinds:
            pair.open(lesson, scene)
            for page in pair.pages:
                page.keyboard.press("k")
                _done(page, scene)
            yield "kick", f"{name}/kick", pair.differences()


def _entry(lesson: Lesson, scene: Scene) -> dict[str, Any]:
    """The values of all knobs on entering a scene."""
    start = lesson.start()
    return {**{knob.name: start[knob.name] for knob in lesson.knobs}, **entry_values(lesson.path, lesson.path.index(scene), start)}


def _done(page: Page, scene: Scene) -> None:
    eventually(page.locator(".ol-way .ol-next").count, bool, f"the end of {scene.id}")


def _knobs(pair: Pair, lesson: Lesson, scene: Scene, points: Points, most: int) -> Iterator[tuple[str, str, list[str]]]:
    """Each knob in sight at each of its points, or at its last `most` where that is not 0, the others as on entry."""
    entry = _entry(lesson, scene)
    for knob in (lesson.knob(name) for name in dict.fromkeys((*scene.knobs, *(scene.do.knobs if isinstance(scene.do, Move) else ())))):
        widgets = [_widget(page, knob, pair.language) for page in pair.pages]
        if isinstance(knob, Poles) or not all(widget.count() and widget.last.is_visible() for widget in widgets):
            continue
        for k, value in enumerate(values_of(knob, entry[knob.name], points)[-most:]):
            if k and isinstance(scene.do, (Move, Solve)):  # the first move that does what was asked keeps its run
                pair.open(lesson, scene)
                widgets = [_widget(page, knob, pair.language) for page in pair.pages]
            for widget in widgets:
                _set(widget, knob, value)
            yield "knob", f"{lesson.id}/{scene.id}/{knob.name} = {value}", pair.differences()
        pair.open(lesson, scene)


def _widget(page: Page, knob: Knob, language: str) -> Locator:
    return page.locator(".mantine-Flex-root", has=page.get_by_text(label_of(knob, language), exact=True))


def _set(widget: Locator, knob: Knob, value: Any) -> None:
    row = widget.last
    if isinstance(knob, Number):
        field = row.locator("input").last
        field.fill(f"{value:.10g}")
        field.press("Enter")
    elif isinstance(knob, Switch):
        if row.locator("input").last.is_checked() != value:
            row.locator("input").last.click(force=True)
    elif isinstance(knob, Choice):
        row.locator("input").first.click()
        row.page.locator("[role=listbox]:visible [role=option]").nth([name for name, _ in knob.options].index(value)).click(force=True)


def _pole(pair: Pair, lesson: Lesson, scene: Scene, points: Points) -> Iterator[tuple[str, str, list[str]]]:
    """One pole or pair at the place that is farthest from its own: dragged there on the published page, opened there on the live one."""
    names = dict.fromkeys((*scene.knobs, *(scene.do.knobs if isinstance(scene.do, Move) else ())))
    for knob in (lesson.knob(name) for name in names):
        if not isinstance(knob, Poles):
            continue
        now = _entry(lesson, scene)[knob.name]
        places = [value for value in values_of(knob, now, points) if len(set(value) - set(now)) == 2]
        pair.open(lesson, scene)
        found = next(filter(None, (_scale(pair.published, board, now) for board in pair.published.evaluate(BOARDS))), None)
        if not places or found is None:
            continue
        aim = max(places, key=lambda value: abs(_moved(value, now) - _moved(now, value)))
        board, place = found
        (x0, y0), (x1, y1) = (pair.published.evaluate(PIXEL_OF, [board, place(pole)]) for pole in (_moved(now, aim), _moved(aim, now)))
        pair.open(lesson, scene, **{knob.name: aim})
        mouse = pair.published.mouse
        mouse.move(x0, y0)
        mouse.down()
        for share in np.linspace(0.1, 1.0, 10).tolist():
            mouse.move(x0 + share * (x1 - x0), y0 + share * (y1 - y0))
            pair.published.wait_for_timeout(60)
        mouse.up()
        for page in pair.pages:  # a run stays where it was under a hand; one that is opened rests where it tells most
            page.get_by_role("button", name=phrases.REWIND(pair.language)).click()
        found = pair.differences()
        told = [name for name in found if not name.startswith(("answer", "card"))]  # a design that was opened is nothing that was done
        yield "pole", f"{lesson.id}/{scene.id}/{knob.name} = {aim}", told


def _moved(value: tuple[complex, ...], other: tuple[complex, ...]) -> complex:
    """The pole of one design that is not in the other, above the real axis."""
    return max(set(value) - set(other), key=lambda pole: pole.imag)


def _scale(page: Page, board: str, poles: tuple[complex, ...]) -> tuple[str, Callable[[complex], list[float]]] | None:
    """The board, and where on it a pole lies, None where it shows other poles."""
    grips = np.array(sorted(map(tuple, page.evaluate(GRIPS, board))))
    known = np.array(sorted((pole.real, pole.imag) for pole in poles))
    if grips.shape != (len(known), 3) or np.ptp(known, axis=0).min() == 0:
        return None
    across, up = (np.polyfit(known[:, k], grips[:, side], 1) for k, side in enumerate((0, 2)))
    if max(np.abs(np.polyval(across, known[:, 0]) - grips[:, 0]).max(), np.abs(np.polyval(up, known[:, 1]) - grips[:, 2]).max()) > STRAIGHT:
        return None
    return board, lambda pole: [float(np.polyval(across, pole.real)), float(grips[0, 1]), float(np.polyval(up, pole.imag))]


def opened(browser: Browser, complaints: list[str], home: str, dark: bool = False, width: str = "wide") -> Page:
    """A page that asks for calm, whose errors and whose requests to elsewhere are written down."""
    across, up = map(int, WINDOWS[width][0])
    context = browser.new_context(viewport={"width": across, "height": up}, reduced_motion="reduce",
                                  color_scheme="dark" if dark else "light")
    context.add_init_script(f"({UNDRAWN})(); ({FORGOTTEN})()")
    page = context.new_page()

    def ask(request: Request) -> None:
        if not request.url.startswith((home, "data:", "blob:", "about:")):
            complaints.append(f"a request left: {request.url[:120]}")
    page.on("request", ask)
    page.on("pageerror", lambda error: complaints.append(error.stack or str(error)))
    page.on("console", lambda said: complaints.append(said.text)
            if said.type == "error" and not any(word in said.text for word in HARMLESS) else None)
    return page


def pair_of(browser: Browser, served: str, folder: Path, look: str, complaints: list[str]) -> Pair:
    """Both pages in a look such as zh-dark, or zh-dark-phone."""
    language, theme, width = (*look.split("-"), "wide")[:3]
    page, dark = (folder / "index.html").resolve().as_uri(), theme == "dark"
    live, published = (opened(browser, told, home, dark, width) for told, home in (([], served), (complaints, page.rpartition("/")[0])))
    return Pair(live, published, served, page, language, dark)


def looks_in(folder: Path, lesson: str) -> list[str]:
    """The languages and themes in which a lesson stands in a folder."""
    return sorted({path.stem.rpartition("-")[0] for path in (folder / "data" / lesson).glob("*-wide.js")})


def main() -> int:
    """Compare the lessons of the folder."""
    from conftest import chromium, serving

    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("lessons", nargs="*")
    parser.add_argument("--looks", default="")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--scenes", default="", help="these scenes alone")
    parser.add_argument("--points", type=int, default=7)
    parser.add_argument("--most", type=int, default=0, help="values of a knob that are tried, its ends first (default: all)")
    parser.add_argument("--whole", action="store_true", help="each lesson in every look")
    asked = parser.parse_args()
    there = [path.name for path in sorted((asked.folder / "data").iterdir()) if path.is_dir() and path.name in LESSONS]
    tally, bad = Tally(), 0
    prepare_kernels().join()  # a server that still compiles them computes in the plain ways, which differ by rounding
    with sync_playwright() as playwright, serving(0, "--view", "guide") as served:
        browser = playwright.chromium.launch(args=FLAGS, executable_path=chromium())
        for number, id in enumerate(asked.lessons or there):
            looks = asked.looks.split(",") if asked.looks else looks_in(asked.folder, id)
            for look in looks if asked.whole or asked.looks else [looks[number % len(looks)]]:
                complaints: list[str] = []
                pair = pair_of(browser, served, asked.folder, look, complaints)
                scenes = tuple(scene for scene in LESSONS[id].path if scene.id in asked.scenes.split(","))
                kinds = tuple(asked.kinds.split(","))
                for kind, state, found in states(pair, LESSONS[id], Points(asked.points), kinds, scenes, asked.most):
                    tally.add(kind, f"{look} {state}", found)
                for page in pair.pages:
                    page.context.close()
                bad += len(complaints)
                print(f"{look} {id}: {tally.tried.total()} states so far; {len(complaints)} errors and requests to elsewhere "
                      f"{json.dumps(complaints)[:400]}", flush=True)
    print(tally.table())
    return int(bad + tally.different.total() > 0)


if __name__ == "__main__":
    sys.exit(main())
