"""A lesson that was published as a folder is walked from its file, with the network off."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, Request
from published_against_live import at_scene, pair_of, press, states
from published_walk import PLACES, served, walked
from tab import HARMLESS, eventually

from observer_lab.cli.entry import main
from observer_lab.course.knobs import Number
from observer_lab.course.lectures import Lecture, Stop
from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.page.record.recorded_screen import WINDOWS, Look
from observer_lab.static_pages.points import Points, values_of
from observer_lab.static_pages.site import write_folder

LESSON = "separation"
PATH, WORDS = LESSONS[LESSON].path, LESSONS[LESSON].words["en"]
GRID = Points(3, 3, 2)
STATES = {"predict": 4, "drag": 2, "command": 4}  # of a scene that are compared with the live page; the script compares all
GRIP = """() => { const viser = window.observerLabViser, name = '/board/observer/grips', canvas = viser?.canvas()?.getBoundingClientRect();
  const points = canvas && window.__viserMutable.nodeRefFromName[name] && viser.onScreenOf('/board/observer', [-.1333, -.05, .625]);
  return points ? [canvas.x + points[0] * canvas.width, canvas.y + points[1] * canvas.height] : null; }"""
CLOCK = "() => Number(document.querySelector('.ol-clock')?.dataset.share ?? 'NaN')"
DECK = """() => { const held = window.__viserMutable?.nodeRefFromName['/plant/deck'];
  return (held && 'current' in held ? held.current : held)?.position.toArray() ?? null; }"""


def options_in(folder: Path) -> list[str]:
    """How the lesson is published, with a store beside the folder."""
    grid = ["--points", f"{GRID.slider}", "--grid", f"{GRID.across}x{GRID.up}"]
    return ["--lang", "en", "--theme", "light", *grid, "--cache", str(folder.parent / "store")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The lesson, published with few points."""
    folder = tmp_path_factory.mktemp("published") / "site"
    assert main(["publish", LESSON, "-o", str(folder), *options_in(folder)]) == 0
    return folder


@pytest.fixture
def page(still_page: Callable[..., Page], folder: Path) -> Iterator[Page]:
    """A page without a network; nothing fails on it and nothing is asked of anybody."""
    page, asked, complaints = still_page(1366, 768), list[Request](), list[str]()
    page.emulate_media(reduced_motion="no-preference")
    page.context.set_offline(True)
    page.on("request", lambda request: asked.append(request))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text)
            if said.type == "error" and not any(word in said.text for word in HARMLESS) else None)
    yield page
    assert not complaints, complaints
    assert asked and {request.url.split(":")[0] for request in asked} <= {"file", "data", "blob"}
    home = folder.parent.as_uri()
    assert all(request.url.startswith(home) for request in asked if request.url.startswith("file:"))


def test_the_folder_is_walked_without_a_server(page: Page, folder: Path) -> None:
    page.goto((folder / "index.html").as_uri())
    for here, there in pairwise(PATH):
        at_scene(page, here.id)
        assert WORDS.scenes[here.id].title in page.inner_text(".ol-card")
        press(page, "turn:1")
        at_scene(page, there.id)
    press(page, "turn:-1")
    at_scene(page, PATH[-2].id)


def test_an_answer_is_performed_and_judged_and_the_run_plays(page: Page, folder: Path) -> None:
    page.goto((folder / "index.html").as_uri() + "?scene=predict")
    at_scene(page, "predict")
    press(page, "option:0")
    eventually(lambda: page.inner_text(".ol-answer"), lambda said: "right board stayed" in said, "the verdict")
    before = eventually(lambda: page.evaluate(CLOCK), lambda share: share > 0, "the run in motion")
    eventually(lambda: page.evaluate(CLOCK), lambda share: share > before, "the run farther on")
    press(page, "turn:1")
    at_scene(page, "why")
    press(page, "turn:-1")
    at_scene(page, "predict")
    assert "right board stayed" in page.inner_text(".ol-answer")
    page.reload()
    at_scene(page, "predict")
    eventually(lambda: page.locator(".ol-dot[data-done]").count(), lambda count: count >= 2, "the dots of what was done")


def test_a_switch_leads_to_its_recorded_state_and_a_kick_moves_the_deck(page: Page, folder: Path) -> None:
    page.goto((folder / "index.html").as_uri() + "?scene=command")
    at_scene(page, "command")
    page.get_by_label("integral", exact=False).last.click(force=True)
    eventually(lambda: page.inner_text(".ol-answer"), lambda said: "integrator" in said, "what is said of the integrator")
    rest = page.evaluate(DECK)
    page.get_by_role("button", name="kick").click()
    eventually(lambda: page.evaluate(DECK), lambda at: at != rest, "the deck after the kick")


def test_a_kick_plays_where_calm_is_asked_for_as_on_the_live_page(page: Page, folder: Path) -> None:
    page.emulate_media(reduced_motion="reduce")
    page.goto((folder / "index.html").as_uri() + "?scene=command")
    at_scene(page, "command")
    page.get_by_role("button", name="kick").click()
    before = eventually(lambda: page.evaluate(CLOCK), lambda share: share > 0, "the run in motion")
    eventually(lambda: page.evaluate(CLOCK), lambda share: share > before, "the run farther on")


def test_a_typed_number_snaps_to_a_computed_value(page: Page, folder: Path) -> None:
    """The slider shows the value whose picture is shown, not the one that was typed."""
    knob = LESSONS[LESSON].knob("command")
    assert isinstance(knob, Number)
    page.goto((folder / "index.html").as_uri() + "?scene=command")
    at_scene(page, "command")
    row = page.locator(".mantine-Flex-root", has=page.get_by_text(label_of(knob, "en"), exact=True)).last
    stands = eventually(lambda: float(row.locator("[role=slider]").get_attribute("aria-valuenow") or "nan"), math.isfinite, "the slider")
    computed = [stands, *values_of(knob, stands, GRID)]
    for share in (0.13, 0.62, 0.87):
        typed = knob.low + share * (knob.high - knob.low)
        row.locator("input").last.fill(f"{typed:.10g}")
        row.locator("input").last.press("Enter")
        near = min(computed, key=lambda value: abs(value - typed))
        assert near != pytest.approx(typed)
        eventually(lambda: float(row.locator("[role=slider]").get_attribute("aria-valuenow") or "nan"),
                   lambda at, near=near: at == pytest.approx(near), f"the slider at {near}")


def test_a_dialog_is_loaded_when_it_is_opened(page: Page, folder: Path) -> None:
    """Its pictures are larger than the rest of a lesson, and most readers go from scene to scene."""
    asked = list[str]()
    page.on("request", lambda request: asked.append(request.url))
    page.goto((folder / "index.html").as_uri())
    at_scene(page, PATH[0].id)
    assert not [url for url in asked if "-dialogs" in url] and any("/data/" in url for url in asked)
    for key, inside in (("o", "All lessons"), ("i", "Glossary"), ("h", "Keyboard commands")):
        page.keyboard.press(key)
        eventually(page.locator(".mantine-Modal-content", has_text=inside).count, bool, f"the dialog {inside}")
        page.keyboard.press(key)
        eventually(page.locator(".mantine-Modal-content").count, lambda count: count == 0, f"no dialog of {key}")
    assert len({url for url in asked if "-dialogs" in url}) == 2


def test_a_pole_is_dragged_to_a_computed_place(page: Page, folder: Path) -> None:
    page.goto((folder / "index.html").as_uri() + "?scene=drag")
    at_scene(page, "drag")
    x, y = eventually(lambda: page.evaluate(GRIP), lambda at: at is not None, "a pole to hold")
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(x + 10 * step, y + 3 * step)
        page.wait_for_timeout(60)
    page.mouse.up()
    eventually(lambda: page.inner_text(".ol-answer"), lambda said: "decays more slowly" in said, "what is said of the slower observer")


def test_a_pole_goes_to_a_computed_place_by_keys(page: Page, folder: Path) -> None:
    page.goto((folder / "index.html").as_uri() + "?scene=drag")
    at_scene(page, "drag")
    slider = page.locator('[data-slider="observer.4.0"]')
    slider.wait_for(state="attached")
    eventually(lambda: page.evaluate("() => observerLabSlide.values['observer.4.0']"), bool, "where the slowest pole stands")
    before = float(slider.input_value())
    slider.focus()
    page.keyboard.press("ArrowRight")
    eventually(lambda: page.inner_text(".ol-answer"), lambda said: "decays more slowly" in said, "what is said of the slower observer")
    eventually(lambda: float(slider.input_value()), lambda now: now > before + 0.5, "the slider stands at the computed place")
    placed = float(slider.input_value())
    page.keyboard.press("ArrowLeft")
    eventually(lambda: float(slider.input_value()), lambda now: now < placed, "and the other way, again to one")


@pytest.mark.parametrize("name", ["predict", "drag", "command"])
def test_the_page_shows_what_the_live_one_does(browser: Browser, guide: str, folder: Path, name: str) -> None:
    """On entry, with every answer, a pole at another place, each knob at each of its points."""
    complaints: list[str] = []
    pair = pair_of(browser, guide, folder, "en-light", complaints)
    scene = next(scene for scene in PATH if scene.id == name)
    found = {state: different for _, state, different in states(pair, LESSONS[LESSON], GRID, scenes=(scene,))}
    for each in pair.pages:
        each.context.close()
    assert len(found) >= STATES[name] and all(different == [] for different in found.values()), found
    assert not complaints, complaints


@pytest.mark.parametrize("place", PLACES)
def test_every_reader_can_walk_the_folder(browser: Browser, folder: Path, place: str) -> None:
    """From a file, from a web server, in a sandboxed frame, on a phone: no error, no request to elsewhere, nothing serious for axe."""
    with served(folder) as home:
        walk = walked(browser, folder, home, LESSON, "en-light", place)
    assert walk.scenes == len(PATH) and (walk.complaints, walk.rules) == ([], [])


def test_the_questions_of_a_folder_lead_to_its_scenes(page: Page, folder: Path) -> None:
    page.goto((folder / "questions-en.html").as_uri())
    page.locator("input").fill("separation principle")
    assert page.locator("section:visible h2").all_inner_texts() == ["Can I design controller and observer separately?"]
    page.locator("section:visible a").click()
    at_scene(page, "predict")


def with_lecture(folder: Path, *stops: tuple[str, str]) -> Path:
    """The folder's lesson beside the page of a lecture with these stops: lesson and scene."""
    site = folder.parent / f"lecture of {len(stops)}"
    site.mkdir()
    (site / "data").symlink_to(folder / "data")
    lecture = Lecture({"en": "A lecture"}, tuple(Stop(lesson, scene, {}, 1.0) for lesson, scene in stops), float(len(stops)))
    write_folder({id: LESSONS[id] for id in dict.fromkeys(lesson for lesson, _ in stops)}, [Look("en", False, width) for width in WINDOWS],
                 site, lecture)
    return site


def test_next_and_back_follow_the_stops_of_a_lecture(page: Page, folder: Path) -> None:
    """Back to an earlier scene, on from the last scene of a path, and at the end to the lecture's page."""
    last = PATH[-1].id
    way = ["drag", "predict", last, "drag", "command"]
    site = with_lecture(folder, *((LESSON, scene) for scene in way))
    page.goto((site / "lecture-en.html").as_uri())
    page.locator("ol a").first.click()
    for here, there in pairwise(way):
        at_scene(page, here)
        assert page.locator('.ol-way [data-value="turn:1"]').is_visible()
        press(page, "turn:1")
        at_scene(page, there)
    for there in reversed(way[:-1]):
        press(page, "turn:-1")
        at_scene(page, there)
    press(page, "turn:-1")
    page.wait_for_url("**/lecture-en.html")
    page.locator("ol a").nth(3).click()
    at_scene(page, "drag")
    press(page, "scene:0")  # no stop: the path goes on
    at_scene(page, PATH[0].id)
    press(page, "turn:1")
    at_scene(page, PATH[1].id)


def test_a_stop_of_another_lesson_is_opened(still_page: Callable[..., Page], folder: Path) -> None:
    page, (first, *_) = still_page(1366, 768), LESSONS["noise"].path
    site = with_lecture(folder, (LESSON, PATH[0].id), ("noise", first.id), (LESSON, PATH[-1].id))
    page.goto((site / "index.html").as_uri() + f"?lesson={LESSON}&scene={PATH[-1].id}")
    at_scene(page, PATH[-1].id)
    press(page, "turn:-1")
    page.wait_for_url(f"**/index.html?lesson=noise&lang=en&theme=light&scene={first.id}&stop=1")
    page.goto((site / "index.html").as_uri() + f"?lesson={LESSON}&scene={PATH[0].id}")
    at_scene(page, PATH[0].id)
    assert page.locator('.ol-way [data-value="turn:-1"]').is_visible(), "the first scene of a path has a way back to the lecture"
    press(page, "turn:1")
    page.wait_for_url("**&stop=1")


def test_a_second_time_nothing_is_recorded(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written = {path: path.stat().st_mtime_ns for path in folder.rglob("*.js")}
    assert main(["publish", LESSON, "-o", str(folder), *options_in(folder), "--zip"]) == 0
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.js")} == written
    assert "<iframe src=" in capsys.readouterr().out and folder.with_suffix(".zip").is_file()
    assert main(["publish", "-o", str(folder)]) == 2 and "--course" in capsys.readouterr().err
    assert main(["publish", "--course", "nothing", "-o", str(folder)]) == 2 and "estimation" in capsys.readouterr().err
