"""Whether anything of the page moves under a hand: the boxes of all words and buttons outside the stage, its figures and its sliders."""

from __future__ import annotations

from playwright.sync_api import Page

MOVED = 0.6  # px
REMEMBER = """() => {
  const skip = '.uplot, svg, canvas, math, input, style, script, .ol-figure, .ol-caption,' +
    '[data-ol-slider], [data-ol-number], [data-ol-hint]';
  const path = e => {
    const out = [];
    for (; e !== document.body; e = e.parentElement) out.unshift([...e.parentElement.children].indexOf(e));
    return out;
  };
  const says = e => e.matches('button, summary, label') || [...e.childNodes].some(n => n.nodeType === 3 && n.data.trim());
  window.olStood = [...document.body.querySelectorAll('*')].filter(e => !e.closest(skip) && e.checkVisibility() && says(e) &&
    getComputedStyle(e).display !== 'inline' && e.offsetHeight).map(e => [e, path(e), e.getBoundingClientRect()]);
  return window.olStood.length;
}"""
COMPARE = """far => window.olStood.flatMap(([e, path, {x, y, width, height}]) => {
  let now = e;
  if (!e.isConnected) {  // written anew: what stands in its place, if it is of the same kind
    now = path.reduce((at, k) => at?.children[k], document.body);
    if (!now || now.tagName + now.className !== e.tagName + e.className) return [];
  }
  const b = now.getBoundingClientRect(), by = [b.x - x, b.y - y, b.width - width, b.height - height];
  return by.some(d => Math.abs(d) > far) ? [`${now.tagName} “${now.textContent.slice(0, 30)}” by ${by.map(Math.round)}`] : [];
})"""


def remember(page: Page) -> int:
    """Remember where everything stands; of how many boxes."""
    return int(page.evaluate(REMEMBER))


def moved(page: Page) -> list[str]:
    """What stands elsewhere than it was remembered."""
    found: list[str] = page.evaluate(COMPARE, MOVED)
    return found
