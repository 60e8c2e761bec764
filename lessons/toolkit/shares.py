"""Shares in per cent as they are said: not 100 % of what is not whole, and not 0 % of what is there."""

from __future__ import annotations

from observer_lab.text import Text, same, text


def percent(share: float) -> Text:
    """A share of 0 … 1 in per cent to three digits: "99.5", "100" only for all of it, "0" only for none."""
    value = 100 * share
    if 0 < value < 0.1:
        return text("less than 0.1")
    if 99.9 < value < 100 - 1e-9:
        return text("more than 99.9")
    return same(f"{value:.3g}")
