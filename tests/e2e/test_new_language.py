"""A language dropped in as a folder: on the page nothing stays English, nothing is cut off and nothing overlaps."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from playwright.sync_api import Browser
from pseudo import CODE, doubled, write_language
from sampling import some
from tab import Tab
from test_chinese_page import KNOWN

from observer_lab.lessons import LESSONS

SHOWN = """() => {
  const found = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const seen = e => {
    if (!e.checkVisibility({opacityProperty: true, visibilityProperty: true})) return false;
    for (let box = e; box; box = box.parentElement)  // a folder that is closed is as high as nothing
      if (!(box instanceof SVGElement) && box.clientHeight === 0 && getComputedStyle(box).overflowY === 'hidden') return false;
    return true;
  };
  while (walk.nextNode()) {
    const e = walk.currentNode.parentElement;
    if (!['STYLE', 'SCRIPT'].includes(e.tagName) && !e.closest('math') && seen(e)) found.push(walk.currentNode.data.trim());
  }
  for (const name of ['title', 'aria-label', 'placeholder', 'alt'])
    for (const e of document.querySelectorAll(`[${name}]`)) if (seen(e)) found.push(e.getAttribute(name));
  return found;
}"""
CUT = """() => {
  const cut = [], lines = [];
  const name = e => e.textContent.trim().slice(0, 50);
  for (const e of document.querySelectorAll('body *')) {
    if (e instanceof SVGElement || e.closest('math') || !e.checkVisibility({opacityProperty: true, visibilityProperty: true})) continue;
    const style = getComputedStyle(e), words = Array.from(e.childNodes).some(n => n.nodeType === Node.TEXT_NODE && n.data.trim());
    const hides = value => value === 'hidden' || value === 'clip';
    if (!words || style.position === 'fixed') continue;
    if ((hides(style.overflowX) || style.textOverflow === 'ellipsis') && e.scrollWidth > e.clientWidth + 1) cut.push(`cut: ${name(e)}`);
    if (hides(style.overflowY) && e.clientHeight && e.scrollHeight > e.clientHeight + 3) cut.push(`cut below: ${name(e)}`);
    if (e.matches('input,.ol-cover *')) continue;
    for (let row = e.parentElement; row && row !== document.body; row = row.parentElement)
      if (row.matches('button')) { lines.push([row, e]); break; }
  }
  for (const [button, words] of lines) {
    const box = button.getBoundingClientRect(), its = words.getBoundingClientRect();
    if (its.left < box.left - 1 || its.right > box.right + 1 || its.top < box.top - 1 || its.bottom > box.bottom + 1)
      cut.push(`beyond its button: ${name(words)}`);
  }
  const buttons = Array.from(document.querySelectorAll('button,[data-dock-tab]')).filter(b => b.checkVisibility() && b.offsetWidth);
  for (const [i, a] of buttons.entries()) for (const b of buttons.slice(i + 1)) {
    if (a.parentElement.parentElement !== b.parentElement.parentElement && a.parentElement !== b.parentElement) continue;
    const p = a.getBoundingClientRect(), q = b.getBoundingClientRect();
    if (Math.min(p.right, q.right) - Math.max(p.left, q.left) > 1 && Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top) > 1)
      cut.push(`overlap: ${name(a)} and ${name(b)}`);
  }
  if (document.documentElement.scrollWidth > innerWidth) cut.push('the whole page');
  return cut;
}"""
WORD = re.compile(r"[^\W\d_]{3,}")
OPENED = ("separation", "sandbox")


def english(shown: list[str]) -> set[str]:
    """What is left of English: a word with a vowel and without an accent that no language writes otherwise."""
    names = {"中文", "English", "Observer Lab"}
    return {words for words in shown if words not in names
            and any(w.isascii() and w not in KNOWN and set(w.lower()) & set("aeiou") for w in WORD.findall(words))}


def test_a_page_in_a_new_language_is_whole(browser: Browser, serve: Callable[..., AbstractContextManager[str]], tmp_path: Path,
                                           artefacts: Path) -> None:
    write_language(tmp_path)
    with serve(0, "--lang", CODE, OBSERVER_LAB_LOCALE=str(tmp_path)) as address:
        context = browser.new_context(viewport={"width": 1366, "height": 768}, reduced_motion="reduce")
        tab = Tab(context.new_page(), address, drawn=False)
        wrong: dict[str, object] = {}
        for name in some("a page in a new language", OPENED, 2):
            words = LESSONS[name].words["en"]
            tab.choose_lesson(doubled(words.title), doubled(words.question), doubled("lesson"))
            tab.predict("A")
            tab.picture(artefacts / f"new-language-{name}.png")
            tab.unfold()
            left, cut = english(tab.page.evaluate(SHOWN)), tab.page.evaluate(CUT)
            if left or cut:
                wrong[name] = (left, cut)
        context.close()
    assert not wrong and not tab.complaints, f"{wrong} {tab.complaints}"
