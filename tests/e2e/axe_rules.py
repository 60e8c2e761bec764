"""Ask axe-core what breaks the rules of accessibility on a page."""

from __future__ import annotations

from typing import Any

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page


def serious(page: Page) -> list[tuple[str, list[Any]]]:
    """What axe-core calls serious or critical, and where."""
    found = Axe().run(page, options={"resultTypes": ["violations"]}).response["violations"]
    return [(rule["id"], [node["html"][:160] for node in rule["nodes"]][:4]) for rule in found if rule["impact"] in ("serious", "critical")]
