"""Turn Markdown with $LaTeX$ into Markdown or HTML with MathML."""

from __future__ import annotations

import html
import re
from decimal import Decimal
from functools import lru_cache

from latex2mathml.converter import convert

from ...course.glossary import as_attribute, explained
from ...course.prose import Prose
from ...text import superscript


@lru_cache(maxsize=4096)
def mathml(latex: str, display: bool = False) -> str:
    """One equation as MathML. A formula that the converter refuses is shown as its source."""
    try:
        drawn = latex.replace("bmatrix", "matrix").replace("pmatrix", "matrix")  # the style sheet draws the brackets
        return _with_accents(_escaped(convert(drawn, display="block" if display else "inline")))
    except Exception:  # the converter raises many kinds of errors for malformed LaTeX
        return f"<code>{html.escape(latex)}</code>"


WORDS_IN_FORMULA = re.compile(r"(<mtext[^>]*>)([^<]*(?:<(?!/mtext>)[^<]*)+)(?=</mtext>)")


def _escaped(markup: str) -> str:
    """MathML in which a < within words stands for itself; the converter hands it on."""
    return WORDS_IN_FORMULA.sub(lambda words: words[1] + words[2].replace("<", "&lt;"), markup)


MOVER = re.compile(r"(<mover[^>]*>|</mover>)")
ACCENT = re.compile(r"<mo[^>]*>&#x0*(?:2D9|A8|5E|2C6|7E|2DC|AF|203E);</mo>$", re.I)  # dot, two dots, hat, tilde, bar


def _with_accents(markup: str) -> str:
    """MathML in which a dot, hat, tilde or bar above something is said to be an accent: drawn in full size, close to its letter."""
    parts, opened = MOVER.split(markup), list[int]()
    for k, part in enumerate(parts):
        if part.startswith("<mover"):
            opened.append(k)
        elif part == "</mover>":
            at = opened.pop()
            if ACCENT.search(parts[k - 1]) and "accent=" not in parts[at]:
                parts[at] = '<mover accent="true">'
    return "".join(parts)


MINUS = re.compile(r"(?:(?<=[\s(\[,=≈<>，：（；～…])|^)-(?=\.?\d)")


EXPONENT_NUMBER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+−-]?\d+)(?!\w)")


def with_minus(words: str) -> str:
    """Words with their numbers as one writes them, −3.1·10⁻⁵ and not -3.1e-05, 1200 and not 1.2e+03."""
    return MINUS.sub("−", EXPONENT_NUMBER.sub(_written, words) if "e" in words else words)


def _written(number: re.Match[str]) -> str:
    mantissa, power = number[1], int(number[2].replace("−", "-"))
    if -3 <= power <= 4:
        return f"{Decimal(f'{mantissa}e{power}'):f}"
    return ("" if mantissa == "1" else f"{mantissa}·") + "10" + superscript(power)


INLINE = re.compile(r"\$(.+?)\$([,.;:?!)，。；：？！）、]*)", re.S)


@lru_cache(maxsize=1024)
def render_markdown(markdown: str) -> str:
    """Markdown whose $…$ and $$…$$ have become MathML."""
    text = re.sub(r"\$\$(.+?)\$\$", lambda m: mathml(m[1].strip(), True), markdown, flags=re.S)
    return INLINE.sub(lambda m: _tied(mathml(m[1].strip()), m[2]), text)


def _tied(formula: str, mark: str) -> str:
    """A formula and the mark behind it, which is not to begin the next line."""
    return f'<span class="ol-tied">{formula}{mark}</span>' if mark else formula


TERM = re.compile(r'data-term="([^"]*)"')


def explained_html(words: Prose, markup: str) -> str:
    """Markup of a lesson in which the first use of each term of the glossary carries its explanation and its formula."""
    glossary = words.glossary
    if glossary is None:
        return markup

    def with_formula(term: re.Match[str]) -> str:
        entry = glossary.entry(html.unescape(term[1]))
        return term[0] if entry is None else f'{term[0]} data-formula="{as_attribute(mathml(entry.formula, True))}"'
    return TERM.sub(with_formula, explained(markup, glossary))


def formula_html(latex: str) -> str:
    """A live equation; each part behind a quad may begin a line of its own."""
    parts = [mathml(part.strip(), True) for part in latex.split(r"\quad")]
    return '<div class="ol-formula">' + (parts[0] if len(parts) == 1 else "".join(f"<span>{part}</span>" for part in parts)) + "</div>"


def equation_html(equation: str) -> str:
    """The lines of an equation in a derivation."""
    return '<div class="ol-formula ol-derived">' + "".join(f"<div>{mathml(line, True)}</div>" for line in equation.split("\n")) + "</div>"


def judged_html(solved: bool, words: str, stale: str = "") -> str:
    """Words with a sign and a colour that say whether something was right; grey, with `stale` below, where that is no longer known."""
    kind = ("ol-right" if solved else "ol-wrong") + (" ol-stale" if stale else "")
    since = f'<div class="ol-note ol-since">{stale}</div>' if stale else ""
    return f'<div class="ol-note {kind}">{"✓" if solved else "✗"} {with_minus(words)}</div>{since}'
