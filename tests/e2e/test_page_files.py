"""Every script of the page is read by a browser without a complaint."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from laws import each
from playwright.sync_api import Browser, Page

from app.view import page

COMPILES = "source => typeof new Function('return (' + source + ')')()"
RULES = """text => {
  const count = rules => [...rules].reduce((sum, rule) => sum + 1 + count(rule.cssRules ?? []), 0);
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  return count(sheet.cssRules);
}"""


@pytest.fixture(scope="module")
def blank(browser: Browser) -> Iterator[Page]:
    """A page without the app: what is asked here is asked of the browser alone."""
    page = browser.new_page()
    yield page
    page.close()


@each("file", sorted(file.name for file in page.FOLDER.glob("*.js")))
def test_a_script_compiles_to_one_function(blank: Page, file: str) -> None:
    assert blank.evaluate(COMPILES, page.source(file)) == "function"


def test_no_rule_of_a_style_is_dropped(blank: Page) -> None:
    for file in page.FOLDER.glob("*.css"):
        text = page.source(file.name)
        assert blank.evaluate(RULES, text) == text.count("{"), file.name
