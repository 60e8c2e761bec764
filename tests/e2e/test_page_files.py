"""Every script of the page is read by a browser without a complaint."""

from __future__ import annotations

import pytest
from laws import each
from playwright.sync_api import Page

from observer_lab.page import web

VISER = f"({web.file_text('viser_dom.js')})"  # which the other scripts call
COMPILES = "source => typeof new Function('return (' + source + ')')()"
RULES = """text => {
  const count = rules => [...rules].reduce((sum, rule) => sum + 1 + count(rule.cssRules ?? []), 0);
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  return count(sheet.cssRules);
}"""


@each("file", sorted(file.name for file in web.FOLDER.glob("*/*.js")))
def test_a_script_compiles_to_one_function(blank: Page, file: str) -> None:
    assert blank.evaluate(COMPILES, web.file_text(file)) == "function"


def test_no_rule_of_a_style_is_dropped(blank: Page) -> None:
    for file in web.FOLDER.glob("*/*.css"):
        text = web.file_text(file.name)
        assert blank.evaluate(RULES, text) == text.count("{"), file.name


def test_a_script_that_fails_costs_nothing_that_comes_with_it(blank: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    """viser runs a script in the middle of a batch of messages; what is thrown there would end the batch, half a page with it."""
    source = web.file_text
    monkeypatch.setattr(web, "file_text", lambda name: source(name) if name == "apart.js" else "() => { null.of; }\n")
    with blank.expect_event("pageerror") as told:
        assert (
            blank.evaluate("source => { new Function(source)(); return 'goes on'; }", web.call_reporting_errors("tab", title="x"))
            == "goes on"
        )
    assert "null" in str(told.value)


TABS = """([viser, script, comes, again]) => new Promise(done => {
  const tab = name => `<button data-dock-tab aria-selected="${name === 'old1'}">${name}</button>`;
  document.body.innerHTML = `<div data-scrollarea-viewport><p class="ol-question"></p><i class="ol-mark" data-stands="1"></i></div>
    <div data-dock-region="right"><div data-scrollarea-viewport><b></b></div>${['old0', 'old1', 'old2', 'old3'].map(tab).join('')}</div>`;
  window.observerLabKeep = Object.assign(window.observerLabKeep ?? {run: 0}, {lesson: 'one', hand: {}, figure: null});
  const tabs = () => [...document.querySelectorAll('[data-dock-tab]')], chose = [];
  document.addEventListener('keydown', event => {
    tabs().forEach(each => each.setAttribute('aria-selected', each === event.target));
    chose.push(event.target.textContent);
  });
  eval(viser)();
  eval(script)({lesson: 'one', large: false});
  let k = 0;
  const next = () => {
    if (k === comes) return setTimeout(() => done(chose), 200);
    if (k === again) eval(script)({lesson: 'one', large: true});
    if (k % 4 === 0) document.querySelector('.ol-question').replaceWith(document.querySelector('.ol-question').cloneNode());
    tabs()[0].remove();  // the old ones go as the new ones come
    tabs().at(-1).insertAdjacentHTML('afterend', tab(`new${k++}`));
    setTimeout(next, 150);
  };
  next();
})"""


def test_the_chosen_tab_is_told_by_its_place_when_all_tabs_are_new(blank: Page) -> None:
    """Half-way through a new layout the second of four tabs was the third of the old ones: it was turned to, and stayed."""
    assert blank.evaluate(TABS, [VISER, f"({web.file_text('keep.js')})", 4, None]) == ["new1"]


@pytest.mark.parametrize("again", [0, 1, 2, 3])
def test_the_chosen_tab_is_kept_through_two_changes_at_once(blank: Page, again: int) -> None:
    """A language and then a size of print, before the language's tabs were all there: any of them was left chosen."""
    assert blank.evaluate(TABS, [VISER, f"({web.file_text('keep.js')})", 8, again])[-1] == "new5"


CROWDED = """([viser, script]) => {
  const [wide, high] = [396, 724], steps = [...Array(160).keys()], between = (low, top) => steps.map(k => (k % 2 ? low : top));
  document.body.innerHTML = `<style>.ol-name{position:absolute;left:0;top:0;font:22px monospace;white-space:nowrap}</style>
    <div id="root"><div id="over" style="position:relative;width:${wide}px;height:${high}px"></div></div>`;
  const chart = {data: [steps, between(60, 600), between(60, 560), between(644, 701)], over: document.querySelector('#over'),
    root: document.querySelector('#root'), hooks: {}, valToPos: (value, axis) => (axis === 'x' ? value / 160 * wide : value),
    series: [{}, ...['true', 'estimate', 'steps down: none heard'].map(label => ({label, _stroke: '#333333'}))]};
  window.__viserTestpoints = {uplots: {one: {chart}}};
  eval(viser)();
  eval(script)();
  const boxes = [...document.querySelectorAll('.ol-name')].filter(e => !e.hidden).map(e => e.getBoundingClientRect());
  return [boxes.length, boxes.some((a, i) => boxes.some((b, j) => i < j && a.left < b.right && b.left < a.right && a.top < b.bottom
    && b.top < a.bottom))];
}"""


def test_a_long_name_that_finds_no_free_place_goes_first(blank: Page) -> None:
    """A short name stood in the only row that a long one could have, and was written over."""
    assert blank.evaluate(CROWDED, [VISER, f"({web.file_text('names.js')})"]) == [3, False]
