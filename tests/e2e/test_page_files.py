"""Every script of the page is read by a browser without a complaint."""

from __future__ import annotations

import pytest
from tab import Tab

from app.view import page

COMPILES = "source => typeof new Function('return (' + source + ')')()"
RULES = """text => {
  const count = rules => [...rules].reduce((sum, rule) => sum + 1 + count(rule.cssRules ?? []), 0);
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  return count(sheet.cssRules);
}"""


@pytest.mark.parametrize("file", sorted(file.name for file in page.FOLDER.glob("*.js")))
def test_a_script_compiles_to_one_function(tab: Tab, file: str) -> None:
    assert tab.page.evaluate(COMPILES, page.source(file)) == "function"


def test_no_rule_of_a_style_is_dropped(tab: Tab) -> None:
    for file in page.FOLDER.glob("*.css"):
        text = page.source(file.name)
        assert tab.page.evaluate(RULES, text) == text.count("{"), file.name
