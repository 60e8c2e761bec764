"""Dots and hats above letters are drawn at every scale of a screen."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page

from observer_lab.page.words.prose import mathml

DARK = 170  # grey level of ink


def ink_height(page: Page, latex: str) -> int:
    """Rows of the screen that hold ink of a formula."""
    page.set_content(f'<p id=m style="font-size:15px;padding:20px;width:80px;background:white;color:black">{mathml(latex)}</p>')
    grey = np.asarray(Image.open(BytesIO(page.locator("#m").screenshot())).convert("L"))
    return int((grey < DARK).any(axis=1).sum())


@pytest.mark.parametrize("scale", [1, 1.25, 1.5, 2, 3])
def test_dots_and_hats_are_drawn_at_every_scale_of_a_screen(browser: Browser, scale: float) -> None:
    with browser.new_context(device_scale_factor=scale) as context:
        page = context.new_page()
        bare = ink_height(page, "x")
        for latex in (r"\dot x", r"\hat x"):
            assert ink_height(page, latex) > bare, latex
        hat = ink_height(page, r"\hat x")
        assert ink_height(page, r"\dot{\hat x}") > hat
        sizes = page.evaluate("() => [...document.querySelectorAll('#m mover > mo')].map(mark => getComputedStyle(mark).fontSize)")
        assert sizes == ["15px", "15px"], "a mark in small print can vanish"
