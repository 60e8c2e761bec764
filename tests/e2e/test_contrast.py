"""Words can be read: every piece of text stands out from its ground by 4.5 to 1, as the browser computes it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Page
from tab import Tab, eventually

from observer_lab.lessons import LESSONS
from observer_lab.page.stage.viewpoint import BOARD_HEIGHT, BOARD_MARGIN

LEAST = 4.5  # WCAG 2.2, 1.4.3
PALE = """least => {
  const pen = new OffscreenCanvas(1, 1).getContext('2d', {willReadFrequently: true});
  const rgba = (colour, turned = 'none') => {
    pen.clearRect(0, 0, 1, 1);
    pen.filter = turned;  // colours of a drawing that is turned over for the dark
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = pen.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const over = (top, below, alpha) => [0, 1, 2].map(i => alpha * top[i] + (1 - alpha) * below[i]);
  const light = colour => {
    const [r, g, b] = colour.map(c => (c /= 255, c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = element => {
    if (!element) return [255, 255, 255];
    const [r, g, b, a] = rgba(getComputedStyle(element).backgroundColor);
    return a === 1 ? [r, g, b] : over([r, g, b], ground(element.parentElement), a);
  };
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), seen = {};
  for (let node; (node = walk.nextNode());) {
    const element = node.parentElement, words = node.textContent.trim();
    if (!words || ['STYLE', 'SCRIPT', 'TITLE'].includes(element.tagName)) continue;
    if (!element.checkVisibility({opacityProperty: true, visibilityProperty: true})) continue;
    const style = getComputedStyle(element), svg = element instanceof SVGElement;
    let alpha = 1, blurred = false, turned = 'none';
    for (let e = element; e; e = e.parentElement) {
      const its = getComputedStyle(e);
      alpha *= Number(its.opacity);
      blurred ||= its.filter.includes('blur');
      if (its.filter !== 'none') turned = its.filter;
    }
    if (blurred) continue;  // veiled: not to be read
    const below = ground(svg ? element.closest('svg').parentElement : element), colour = rgba(svg ? style.fill : style.color, turned);
    const [a, b] = [light(over(colour, below, colour[3] * alpha)), light(below)];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < least) seen[`${words.slice(0, 30)} | ${svg ? style.fill : style.color} on ${below.map(Math.round)}`] = ratio.toFixed(2);
  }
  return seen;
}"""


@pytest.mark.parametrize("name, size, large, dark", [
    ("separation", (1366, 768), False, False), ("saturation", (1366, 768), False, True), ("network", (1920, 1080), True, True),
    ("sandbox", (390, 844), False, False)], ids=str)
def test_words_stand_out_from_their_ground(walking: Tab, name: str, size: tuple[int, int], large: bool, dark: bool) -> None:
    words = LESSONS[name].words["en"]
    worn = [pair for pair, wanted in ((("large print",) * 2, large), (("dark", "light"), dark)) if wanted]
    walking.open_lesson(words.title, words.question, size)
    walking.predict("skip")
    for on, _ in worn:
        walking.press(on)
    assert walking.page.evaluate(PALE, LEAST) == {}
    for _, off in worn:
        walking.press(off)


def test_the_judge_of_contrast_knows_pale_from_dark(blank: Page) -> None:
    blank.evaluate("""() => { document.body.innerHTML = '<p style="color:#767676">dark enough</p><p style="color:#777">pale</p>'
      + '<p style="opacity:.5">faded</p><svg><text y="20" fill="#D55E00">orange</text></svg>'; }""")
    pale: dict[str, Any] = blank.evaluate(PALE, LEAST)
    assert sorted(key.split(" | ")[0] for key in pale) == ["faded", "orange", "pale"]


TITLE_FOOT = BOARD_HEIGHT / 2 + BOARD_MARGIN + 0.06  # stage units above the middle of a board
ON_TITLE = """([foot, top]) => {  // the box of pixels in which the title of a board begins
  const page = window.__viserMutable, held = page.nodeRefFromName['/board/observer'], node = 'current' in held ? held.current : held;
  const view = page.canvas.getBoundingClientRect();
  const at = z => node.localToWorld(node.position.clone().set(0, -0.06, z)).project(page.camera);
  const [low, high] = [at(foot), at(top)].map(({x, y}) => [view.x + (x + 1) / 2 * view.width, view.y + (1 - y) / 2 * view.height]);
  return {x: low[0] - 40, y: high[1], width: 80, height: low[1] - high[1]};
}"""


def test_labels_of_the_stage_stand_on_the_ground_of_the_theme(walking: Tab, tmp_path: Path) -> None:
    words = LESSONS["separation"].words["en"]
    walking.open_lesson(words.title, words.question, (1366, 768))
    if walking.page.locator(".ol-veil").count():
        walking.predict("skip")
    for theme, dark in (("dark", True), ("light", False)):
        walking.press(theme)

        def seen(dark: bool = dark) -> tuple[float, float]:  # how light the ground of the title is, and its letters
            walking.picture(tmp_path / "page.png")
            box = walking.page.evaluate(ON_TITLE, [TITLE_FOOT + 0.02, TITLE_FOOT + 0.1])
            with Image.open(tmp_path / "page.png") as page:
                title = page.crop((box["x"], box["y"], box["x"] + box["width"], box["y"] + box["height"]))
            grey = np.asarray(title.convert("L"), dtype=float)
            return float(np.median(grey)), float(np.percentile(grey, 99 if dark else 1))

        def legible(light: tuple[float, float], dark: bool = dark) -> bool:
            ground, ink = light
            return (ground < 80 if dark else ground > 200) and abs(ink - ground) > 110
        eventually(seen, legible, f"ground and letters of a label, which come after their board, {theme}")


SKINS = """() => {  // of the grounds of labels: how many there are, how many are round, and what the graphics card refuses
  const {scene, gl} = window.__viserMutable.scene.__r3f.root.getState(), grounds = new Set();
  scene.traverse(({material}) => { if (material?.fragmentShader?.includes('observerLabGround')) grounds.add(material); });
  const round = [...grounds].filter(({vertexShader, fragmentShader}) => vertexShader.includes('observerLabPlace = position.xy')
    && fragmentShader.match(/gl_FragColor = .*observerLabInside\\(\\)/));
  return [grounds.size, round.length, gl.info.programs.filter(({diagnostics}) => diagnostics?.runnable === false).length];
}"""


def test_labels_of_the_stage_have_round_corners_that_the_card_draws(walking: Tab) -> None:
    words = LESSONS["virtual-sensor"].words["en"]
    walking.open_lesson(words.title, words.question, (1366, 768))
    eventually(lambda: walking.page.evaluate(SKINS), lambda found: found[0] > 0 and found[1:] == [found[0], 0], "grounds of labels")
