"""Say shares and ratios: in per cent while they are small, as a factor where they are large."""

from __future__ import annotations

from observer_lab.text import Text, format_number, same, text


def percent(share: float) -> Text:
    """A share of 0 … 1 in per cent to three digits: "99.5", "100" only for all of it, "0" only for none."""
    value = 100 * share
    if 0 < value < 0.1:
        return text("less than 0.1")
    if 99.9 < value < 100 - 1e-9:
        return text("more than 99.9")
    return same(format_number(value, ".3g"))


MAX_PERCENT = 1000.0  # beyond it a multiple is said


def more(change: float) -> Text:
    """A relative change with its direction: "4 % larger", "0.3 % smaller", "larger by a factor of 26"."""
    if change >= MAX_PERCENT / 100:
        return text("larger by a factor of {times:.2g}", times=change + 1)
    return text("{change:.2g} % larger", change=100 * change) if change >= 0 else text("{change:.2g} % smaller", change=-100 * change)


def apart(share: float) -> Text:
    """A relative difference: "4 %", or "a factor of 671"."""
    return text("{share:.2g} %", share=100 * share) if 100 * share <= MAX_PERCENT else text("a factor of {times:.3g}", times=share + 1)
