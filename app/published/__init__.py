"""Compare every published number of the sources with ours, and name the slips in the sources."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from unicodedata import combining

from . import (
    arm,
    bilinear,
    classics,
    diagnosis,
    duan,
    network,
    nonlinear,
    notes,
    platform,
    platform_filter,
    platform_lqg,
    platform_siso,
    showdown,
    tutorial,
)
from .record import Published, Result, verify_one

__all__ = ["Published", "Result", "records", "table", "verify_all", "verify_one"]


def records() -> tuple[Published, ...]:
    """All published values that this version can compute, in the order of the sources."""
    return (
        *tutorial.RECORDS,
        *notes.RECORDS,
        *duan.RECORDS,
        *platform.RECORDS,
        *platform_filter.RECORDS,
        *platform_siso.RECORDS,
        *platform_lqg.RECORDS,
        *showdown.RECORDS,
        *bilinear.RECORDS,
        *nonlinear.RECORDS,
        *classics.RECORDS,
        *diagnosis.RECORDS,
        *network.RECORDS,
        *arm.RECORDS,
    )


def verify_all(published: Iterable[Published]) -> tuple[Result, ...]:
    """Compute ours for each and judge."""
    return tuple(verify_one(p) for p in published)


def table(results: Sequence[Result]) -> str:
    """The results as a text table: source | item | printed | ours | verdict, the slips and a count at the end."""
    head = ("source", "item", "printed", "ours", "verdict")
    rows = [(r.published.source, r.published.item, r.published.printed or "(not printed)", _show(r.ours),
             r.verdict if r.holds else r.verdict.upper()) for r in results]
    wide = [max(_width(row[k]) for row in (head, *rows)) for k in range(len(head))]
    lines = [" | ".join(cell + " " * (w - _width(cell)) for cell, w in zip(row, wide, strict=True)).rstrip()
             for row in (head, *rows)]
    lines.insert(1, "-|-".join("-" * w for w in wide))
    slips = [r for r in results if r.published.kind == "slip"]
    lines += ["", "Slips in the sources:"]
    lines += [f"  {r.published.source}, {r.published.item}: {r.published.note}" for r in slips]
    wrong = [r for r in results if not r.holds]
    lines += ["", f"{len(results)} values, {len(slips)} slips, {len(wrong)} not as expected."]
    lines += [f"  {r.published.source}, {r.published.item}: expected {r.published.kind}, "
              f"{'right ' + r.published.right if r.published.right else 'printed ' + r.published.printed}"
              for r in wrong]
    return "\n".join(lines)


def _width(text: str) -> int:
    return sum(1 for letter in text if not combining(letter))


def _show(values: Sequence[float]) -> str:
    return ", ".join(f"{v:.6g}".replace("-", "−") if abs(v) > 1e-15 else "0" for v in values)
