"""Every script of the page is read by a browser without a complaint."""

from __future__ import annotations

import pytest
from laws import each
from playwright.sync_api import Page

from app.view import page

COMPILES = "source => typeof new Function('return (' + source + ')')()"
RULES = """text => {
  const count = rules => [...rules].reduce((sum, rule) => sum + 1 + count(rule.cssRules ?? []), 0);
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  return count(sheet.cssRules);
}"""


@each("file", sorted(file.name for file in page.FOLDER.glob("*.js")))
def test_a_script_compiles_to_one_function(blank: Page, file: str) -> None:
    assert blank.evaluate(COMPILES, page.source(file)) == "function"


def test_no_rule_of_a_style_is_dropped(blank: Page) -> None:
    for file in page.FOLDER.glob("*.css"):
        text = page.source(file.name)
        assert blank.evaluate(RULES, text) == text.count("{"), file.name


def test_a_script_that_fails_costs_nothing_that_comes_with_it(blank: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    """viser runs a script in the middle of a batch of messages; what is thrown there would end the batch, half a page with it."""
    source = page.source
    monkeypatch.setattr(page, "source", lambda name: source(name) if name == "apart.js" else "() => { null.of; }\n")
    with blank.expect_event("pageerror") as told:
        assert blank.evaluate("source => { new Function(source)(); return 'goes on'; }", page.apart("tab", title="x")) == "goes on"
    assert "null" in str(told.value)
