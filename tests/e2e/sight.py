"""What an eye would measure on the page: the first knob in view, the smallest words, what is cut, what lies on what."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from playwright.sync_api import Page
from tab import Tab

from observer_lab.page.charts.print_sizes import SHEET_MAX_WIDTH_PX

AGAIN = 4  # times that a page with faults is looked at
MOST_EMPTY = 0.4  # of the figures' column in large print, where there is more to show
PARTS = ("predict", "knobs", "curves", "why", "tasks")
MEASURE = """() => {
  const seen = e => e.checkVisibility({opacityProperty: true, visibilityProperty: true}) && e.getClientRects().length > 0;
  const scale = e => { const box = e.ownerSVGElement ?? e; const m = box.getScreenCTM?.(); return m ? Math.hypot(m.a, m.b) : 1; };
  const inside = (a, b, by) => a.left >= b.left - by && a.right <= b.right + by;
  const out = {words: 1e9, smallest: '', cut: [], over: [], peeps: []};
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walk.nextNode());) {
    const e = node.parentElement, words = node.textContent.trim();
    if (!words || e.closest('style, script, .ol-cover, .ol-spoken, .ol-poles, math, sub, sup') || !seen(e)) continue;
    const svg = e instanceof SVGElement, size = parseFloat(getComputedStyle(e).fontSize) * (svg ? scale(e) : 1);
    if (size < out.words) { out.words = size; out.smallest = words.slice(0, 40); }
    const range = document.createRange();
    range.selectNodeContents(node);
    const box = range.getBoundingClientRect(), view = e.closest('svg, [data-scrollarea-viewport]')?.getBoundingClientRect();
    if (view && !inside(box, view, 1)) out.cut.push(words.slice(0, 40));
  }
  for (const e of document.querySelectorAll('.ol-question, .ol-note, .ol-caption, .mantine-Button-label, .ol-option'))
    if (seen(e) && e.clientWidth && e.scrollWidth > e.clientWidth + 1) out.cut.push(e.textContent.slice(0, 40));
  for (const label of document.querySelectorAll('label')) for (const node of seen(label) ? label.childNodes : []) {
    for (const {index, 0: word} of (node.nodeType === 3 ? node.textContent : '').matchAll(/[\\p{Script=Latin}\\p{Script=Greek}\\d]+/gu)) {
      const range = document.createRange();
      range.setStart(node, index);
      range.setEnd(node, index + word.length);
      const tops = [...range.getClientRects()].map(box => Math.round(box.top));
      if (Math.max(...tops) - Math.min(...tops) > 4) out.cut.push(`${word} of ${label.textContent}`.slice(0, 40));
    }
  }
  for (const field of document.querySelectorAll('.mantine-Select-input, .mantine-NumberInput-input'))
    if (seen(field) && field.scrollWidth > field.clientWidth + 1) out.cut.push(`field: ${field.value}`);
  for (const slider of document.querySelectorAll('.mantine-Slider-root')) {
    const foot = slider.querySelector('[role=slider]').getBoundingClientRect().bottom;  // the handle comes as far as its stops' numbers
    for (const mark of slider.querySelectorAll('.mantine-Slider-markLabel'))
      if (seen(mark) && mark.textContent && foot > mark.getBoundingClientRect().top + 1) out.over.push(`a handle on ${mark.textContent}`);
  }
  for (const drawn of document.querySelectorAll('.ol-figure svg, .u-over')) {
    if (!seen(drawn)) continue;
    const named = [...drawn.querySelectorAll('text, .ol-name:not([hidden])')].filter(t => t.textContent.trim());
    const names = named.map(t => [t.textContent, t.getBoundingClientRect()]);
    names.forEach(([a, p], i) => names.slice(i + 1).forEach(([b, q]) => {
      const [x, y] = [Math.min(p.right, q.right) - Math.max(p.left, q.left), Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top)];
      if (x > 2 && y > 0.3 * Math.min(p.height, q.height)) out.over.push(`${a} on ${b}`.slice(0, 60));
    }));
  }
  for (const chart of Object.values(window.__viserTestpoints?.uplots ?? {}))
    if (chart.chart.root.isConnected && seen(chart.chart.root)) for (const axis of chart.chart.axes) {
      const size = parseFloat(String(axis.font?.[0] ?? '').match(/([\\d.]+)px/)?.[1]) / devicePixelRatio;
      if (size < out.words) { out.words = size; out.smallest = 'numbers of a chart'; }
    }
  const captions = [...document.querySelectorAll('[data-dock-region=right] .ol-caption[data-figure]')].filter(e => e.checkVisibility());
  const view = captions[0]?.closest('[data-scrollarea-viewport]'), {top, bottom} = view?.getBoundingClientRect() ?? {};
  const figures = captions.map(e => e.parentElement.previousElementSibling);
  const inView = e => { const b = e.getBoundingClientRect(); return Math.max(0, Math.min(b.bottom, bottom) - Math.max(b.top, top)); };
  const taken = [...figures, ...captions].reduce((sum, e) => sum + inView(e), 0);
  const could = view && (view.scrollHeight > view.clientHeight + 4 || view.querySelector('.uplot'));  // nothing else to show is no fault
  out.empty = could ? Math.max(0, 1 - taken / (bottom - top)) : 0;
  out.peeps = figures.filter(e => e.getBoundingClientRect().bottom > bottom && inView(e) > 4 && inView(e) < .45 * e.offsetHeight)
    .map(e => e.querySelector('.u-title, caption, text')?.textContent ?? '');
  out.words = Math.round(10 * out.words) / 10;
  return out;
}"""
KNOB = """sheet => {  // what keeps the first knob out of view, or in a column any of those that are turned often
  const folder = document.querySelector('div:has(>.ol-part-knobs) + .mantine-Paper-root');
  const row = [...folder?.querySelectorAll('input, [role=slider]') ?? []].find(e => e.checkVisibility() && e.type !== 'hidden');
  if (!row) return 'no knob';
  const rows = folder.querySelector(':scope > div:nth-child(2) > div');
  if (innerWidth > sheet && innerHeight >= 768 && rows.scrollHeight > rows.clientHeight + 1)
    return `knobs cut by their box: ${rows.scrollHeight} px in ${rows.clientHeight}`;
  const box = row.getBoundingClientRect(), x = box.x + box.width / 2, y = box.y + box.height / 2;
  if (x < 0 || y < 0 || x > innerWidth || y > innerHeight) return `at ${Math.round(x)}, ${Math.round(y)}`;
  const top = document.elementFromPoint(x, y);
  return folder.contains(top) ? '' : `under ${top?.className}`;
}"""
WAITING = """() => {  // of a prediction that waits: the sentences that cannot be read without scrolling, but the last, which skips it
  const options = [...document.querySelectorAll('.ol-option:enabled')].filter(e => e.checkVisibility()), out = [];
  for (const option of options.filter(e => e.dataset.to === options[0].dataset.to).slice(0, -1)) {
    const box = option.getBoundingClientRect(), top = document.elementFromPoint(box.x + box.width / 2, box.bottom - 3);
    if (!option.contains(top)) out.push(`out of sight: ${option.textContent.slice(0, 30)}`);
  }
  return out;
}"""
HALL = """() => {  // what is not as a hall needs it: the question on top, prose folded, three knobs at most, one chart
  const out = [], seen = e => e.checkVisibility() && e.getClientRects().length > 0, y = e => e.getBoundingClientRect().top;
  const question = document.querySelector('.ol-question'), column = question.closest('[data-scrollarea-viewport]');
  const above = [...column.querySelectorAll('input, button')].filter(e => seen(e) && y(e) < y(question));
  if (above.length) out.push(`the question, at ${y(question)} px, is not on top: ${above.map(e => y(e) + e.outerHTML.slice(0, 200))}`);
  const heads = [...column.querySelectorAll('.mantine-Paper-root > .mantine-Paper-root')].filter(e => seen(e) && e.querySelector('svg'));
  const open = heads.filter(e => e.lastElementChild.matches('[class*="chevron-up"]')).map(e => e.textContent);
  if (open.length > 2) out.push(`open: ${open}`);  // what is predicted, and the knobs
  const folder = document.querySelector('div:has(>.ol-part-knobs) + .mantine-Paper-root'), head = folder.firstElementChild;
  const own = e => heads.filter(each => each.parentElement.contains(e)).at(-1) === head;
  const knobs = [...folder.querySelectorAll('label')].filter(e => seen(e) && e.textContent && own(e)).map(e => e.textContent);
  if (knobs.length < 1 || knobs.length > 3) out.push(`knobs: ${knobs}`);
  const charts = [...document.querySelectorAll('[data-dock-region=right] .uplot')].filter(e => {
    const view = e.closest('[data-scrollarea-viewport]').getBoundingClientRect();
    return seen(e) && y(e) < view.bottom - 4 && e.getBoundingClientRect().bottom > view.top + 4;
  });
  if (charts.length > 1) out.push(`${charts.length} charts at once`);
  for (const view of document.querySelectorAll('[data-dock-region=right] [data-scrollarea-viewport]')) if (view.checkVisibility()) {
    const all = view.getBoundingClientRect(), captions = [...view.querySelectorAll('.ol-caption[data-figure]')];
    if (!captions.some(e => Math.abs(y(e.parentElement.previousElementSibling) - all.top) < 60)) out.push('no figure stands at the top');
    const empty = all.bottom - captions.at(-1).getBoundingClientRect().bottom, tables = [...view.querySelectorAll('.ol-table')];
    const air = Math.max(...tables.map(e => parseFloat(e.style.getPropertyValue('--air')) || 0));
    if (tables.length && !view.querySelector('.uplot') && empty > .2 * all.height && air < 8)
      out.push('rows stand close above an empty column');
  }
  return out;
}"""
TABS = """() => {  // what is wrong with the row of the figures' tabs in large print
  const out = [], row = document.querySelector('[data-dock-region=right] [role=tablist]');
  const tabs = [...row?.children ?? []].filter(e => e.checkVisibility()), box = row?.getBoundingClientRect();
  if (!tabs.length) return out;
  if (new Set(tabs.map(e => Math.round(e.getBoundingClientRect().top))).size > 1) out.push('tabs in more than one row');
  for (const words of tabs.map(e => e.lastElementChild))
    if (words.scrollWidth > words.clientWidth + 1) out.push(`the tab ${words.textContent} is cut`);
  const faded = name => 2 * row.hasAttribute(name) * parseFloat(getComputedStyle(document.documentElement).fontSize);
  const chosen = tabs.find(e => e.ariaSelected === 'true'), at = chosen?.getBoundingClientRect();
  if (!at || at.left < box.left + faded('data-before') - 1 || at.right > box.right - faded('data-after') + 1)
    out.push(`the chosen tab ${chosen?.textContent} is not in view`);
  const over = row.scrollWidth - row.clientWidth;
  if (row.hasAttribute('data-before') !== row.scrollLeft > 1 || row.hasAttribute('data-after') !== row.scrollLeft < over - 1)
    out.push('the row of tabs fades at an end where it does not go on, or does not where it does');
  return out;
}"""
QUESTION = """() => {  // px of the smallest words of a question's figure, and how far it goes beyond the window
  const words = [...document.querySelectorAll('.ol-figure[data-figure=question] text')].filter(each => each.textContent.trim());
  const size = each => parseFloat(getComputedStyle(each).fontSize) * Math.hypot(each.getScreenCTM().a, each.getScreenCTM().b);
  const below = document.querySelector('.ol-figure[data-figure=question]>svg')?.getBoundingClientRect().bottom ?? 0;
  return {words: Math.min(innerHeight, ...words.map(size)), beyond: below - innerHeight, high: innerHeight, wide: innerWidth};
}"""
LETTERS = {True: 1 / 64, False: 1 / 90}  # of the window's height: the least words of a question's figure, in a hall and elsewhere
PHONE = 897  # px: narrower windows have a sheet below the stage, and the figure below the card
REACH = """() => {
  const view = document.querySelector('.ol-parts').closest('[data-scrollarea-viewport]');
  return view.scrollHeight / innerHeight;
}"""


class Sight(NamedTuple):
    """What was measured: words in px and as a share of the window's height, one over it; `knob` is empty where one is in view,
    `hall` where a page in large print is as a hall needs it."""

    knob: str
    words: float
    one_over: float
    smallest: str
    cut: tuple[str, ...]
    over: tuple[str, ...]
    empty: float
    screens: float
    hall: tuple[str, ...] = ()


def leaves(tab: Tab) -> Iterator[str]:
    """The tabs of the figures on the right, each brought to the front and then the first again; the names of those after the first."""
    heads = tab.page.locator("[data-dock-region=right] [data-dock-tab]")
    for k in (*range(1, heads.count()), 0):
        heads.nth(k).click()
        tab.answered(rests=True)
        if k:
            yield heads.nth(k).inner_text()


def _measured(tab: Tab, large: bool) -> tuple[dict[str, Any], list[str]]:
    """What is seen now, and what a hall misses; looked at again where something is wrong, as charts may still be growing."""
    seen, faults = {}, list[str]()
    for _ in range(AGAIN):
        seen, faults = tab.page.evaluate(MEASURE), tab.page.evaluate(HALL) if large else []
        if not large or not (faults or seen["peeps"] or seen["cut"]):
            break
        tab.answered(rests=True)
    return seen, faults


def look(tab: Tab, large: bool = False, every: bool = False) -> Sight:
    """Measure the page as it stands, in large print or not; in a sheet part by part, elsewhere with `every` tab of the figures."""
    size = tab.page.viewport_size
    assert size is not None
    parts: tuple[str, ...] = PARTS if size["width"] <= SHEET_MAX_WIDTH_PX else ("",)
    found: list[dict[str, Any]] = []
    knob, screens, further = "", 0.0, list[str]()
    for part in parts:
        if part:
            tab.page.locator(f".ol-parts [data-part={part}]").click()
            tab.answered()
            if part != "curves":  # charts are looked at one after the other
                screens = max(screens, tab.page.evaluate(REACH))
        if part in ("", "knobs"):
            knob = tab.page.evaluate(KNOB, SHEET_MAX_WIDTH_PX)
        seen, faults = _measured(tab, large)
        found.append(seen)
        further += faults
        for name in leaves(tab) if every and not part else ():
            seen, faults = _measured(tab, large)
            found.append({**seen, **{kind: [f"{name}: {words}" for words in seen[kind]] for kind in ("cut", "over", "peeps")}})
            further += [f"{name}: {fault}" for fault in faults]
    least = min(found, key=lambda it: it["words"])
    hall = () if not large else (*further, *tab.page.evaluate(TABS),
                                 *(f"little more than the title of {w}" for it in found for w in it["peeps"]),
                                 *(f"{it['empty']:.0%} of the figures' column empty" for it in found if it["empty"] > MOST_EMPTY))
    return Sight(knob, least["words"], round(size["height"] / least["words"], 1), least["smallest"],
                 tuple(w for it in found for w in it["cut"]), tuple(w for it in found for w in it["over"]),
                 round(max(it["empty"] for it in found), 2), round(screens, 2), hall)


def question_faults(page: Page, hall: bool) -> list[str]:
    """What keeps a question's figure from being read: small words, or a place beyond the window; a phone scrolls to it."""
    found = page.evaluate(QUESTION)
    if found["wide"] < PHONE:
        return []
    small = found["words"] < LETTERS[hall] * found["high"]
    return ([f"the question's figure has words of {found['words']:.1f} px"] if small else []) + (
        [f"the question's figure is beyond by {found['beyond']:.0f} px"] if found["beyond"] > 0 else [])
