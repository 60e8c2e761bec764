"""The glossary: every term is used, explained in both languages, found in texts, and marked in a page without harm."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import pytest
from catalogues import said
from commands import refused
from hypothesis import given
from hypothesis import strategies as st
from word_rules import word_count

from observer_lab.cli.entry import main
from observer_lab.course.glossary import explained, parse_glossary
from observer_lab.course.prose import ProseError
from observer_lab.course.sentences import prose_parts
from observer_lab.lessons import LESSONS, folder, glossaries
from observer_lab.page.words.prose import mathml, render_markdown

EN, ZH = glossaries()["en"], glossaries()["zh"]
AWAITED = {  # standard terms that the rewriting of the lessons brings in
    "reference input", "feedback gain", "fixed mode", "reduced-order observer", "under-confident",
    "symmetric root locus", "recovery map", "mean time between false alarms"}
FIELD_WORDS = (  # beyond a first course, or of our own: each that a lesson uses has an entry
    "virtual sensor", "observer", "Luenberger", "estimate", "estimation error", "observer gain", "feedback gain", "state feedback",
    "innovation", "residual", "fixed mode", "hidden mode", "observable", "unobservable", "controllable", "uncontrollable",
    "detectable", "stabilizable", "observability matrix", "observability Gramian", "PBH", "Hankel", "balanced truncation",
    "separation principle", "separation meter", "compensator", "duality", "ghost", "board", "trust", "peaking", "half axis",
    "ellipsoid", "typical size", "functional observer", "unknown input", "reduced-order observer", "RLO", "Sylvester", "Diophantine",
    "coprime", "invariant zero", "Cayley", "Ackermann", "Lyapunov", "Riccati", "Kalman filter", "LQR", "LQG", "LQE", "EKF", "UKF",
    "sigma point", "Cramér–Rao", "NIS", "NEES", "whiteness", "over-confident", "under-confident", "covariance", "variance",
    "standard deviation", "process noise", "sensor noise", "white noise", "bias", "prior", "χ²", "Monte-Carlo", "likelihood ratio",
    "cost function", "finite horizon", "symmetric root locus", "root locus", "loop gain", "crossover", "gain margin", "phase margin",
    "disk margin", "delay margin", "loop transfer recovery", "sensitivity function", "saturation", "windup", "anti-windup",
    "commanded force", "applied force", "recovery map", "region of attraction", "sampling period", "packet loss", "fault",
    "threshold", "false alarm", "mean time between false alarms", "CUSUM", "fault isolation", "bank of observers", "backlash",
    "load torque", "encoder", "quantisation", "Coulomb friction", "decoupling", "SISO", "transmissibility", "geophone", "rms", "decibel",
    "spectral radius", "unit circle", "singular value", "bilinear", "equal effort", "integral action", "pole placement")
PAGE = "# An observer\n\nAn observer has an **observer gain**. See `observer`, [an observer](a \"observer\") and $observer$.\n"


def lesson_words(language: str) -> list[str]:
    return [words for lesson in LESSONS.values() for _, words in prose_parts(lesson.words[language])]


@pytest.mark.slow
def test_every_term_is_used_by_a_lesson() -> None:
    messages = [english for (_, english), where in said().items() if "lessons/" in where]
    used = {each.id for each in EN.used([*lesson_words("en"), *messages])}
    assert {each.id for each in EN.entries} - used - AWAITED == set()
    assert {each.id for each in EN.entries} >= AWAITED


def test_every_field_word_that_a_lesson_uses_has_an_entry() -> None:
    words = "\n".join(lesson_words("en")).lower()
    assert [word for word in FIELD_WORDS if word.lower() in words and EN.entry(word) is None] == []
    assert sum(EN.entry(word) is not None for word in FIELD_WORDS) > 110


def test_both_languages_have_the_same_terms_and_formulas() -> None:
    assert [(each.id, each.formula) for each in EN.entries] == [(each.id, each.formula) for each in ZH.entries]
    assert 90 <= len(EN.entries) <= 150
    assert not any(re.search(r"[㐀-鿿]", each.text) for each in EN.entries) and all(re.search(r"[㐀-鿿]", each.text) for each in ZH.entries)


def test_explanations_have_the_length_that_can_be_read_at_once() -> None:
    assert {each.id: count for each in EN.entries if not 15 <= (count := word_count(each.text)) <= 40} == {}
    assert {each.id: count for each in ZH.entries if not 25 <= (count := len("".join(each.text.split()))) <= 90} == {}


def test_every_formula_is_drawn() -> None:
    assert [each.id for each in EN.entries if "<math" not in mathml(each.formula) or "<code>" in mathml(each.formula)] == []


def test_the_longest_form_is_found_in_any_case_number_and_hyphenation() -> None:
    text = "Observability matrices of the Unknown-Input  observer; kalman filters, NIS but not nis, Gramians, unobservable, my-observer"
    assert [(text[f.start:f.end], f.entry.id) for f in EN.find(text)] == [
        ("Observability matrices", "observability matrix"), ("Unknown-Input  observer", "unknown-input observer"),
        ("kalman filters", "kalman filter"), ("NIS", "normalised innovation squared"), ("Gramians", "gramian"),
        ("unobservable", "unobservable")]
    assert [f.entry.id for f in ZH.find("卡尔曼滤波器的新息和观测器增益")] == ["kalman filter", "innovation", "observer gain"]


@given(st.lists(st.sampled_from([*(form for each in EN.entries for form in each.forms), " ", ", ", "xyz", "the "]), max_size=12))
def test_what_is_found_stands_in_order_and_is_a_form_of_its_entry(parts: list[str]) -> None:
    text = " ".join(parts)
    found = EN.find(text)
    assert all(a.end <= b.start for a, b in pairwise(found))
    assert all(EN.entry(text[f.start:f.end]) == f.entry for f in found)
    assert {part for part in parts if EN.entry(part) is not None} == set() or found


@pytest.mark.parametrize("glossary", [EN, ZH], ids=["en", "zh"])
def test_every_form_finds_its_own_entry(glossary) -> None:
    wrong = [form for each in glossary.entries for form in each.forms if [f.entry for f in glossary.find(f"({form})")] != [each]]
    assert wrong == []


@pytest.mark.parametrize(("said", "term"), [
    ("线圈的出力随气隙增大而减弱", "backlash"), ("抵消、限幅都有代价", "cost function"), ("测量曲线上毫无迹象", "unscented kalman filter"),
    ("输入被截断的时间占 5 %", "balanced truncation"), ("过程噪声的设定值", "reference input"), ("连续与采样", "sampling period"),
    ("分离原理何时失效", "fault"), ("摆杆倾斜 6°", "pitch")])
def test_a_word_in_another_sense_is_not_marked(said: str, term: str) -> None:
    """In Chinese a short form is easily a piece of another word; the English of these has not the term."""
    assert EN.entry(term) is not None and term not in {found.entry.id for found in ZH.find(said)}


@pytest.mark.slow
def test_chinese_marks_hardly_a_term_that_the_english_lesson_has_not() -> None:
    """Where a Chinese form fires in lessons whose English never has the term, the form is too short: 间隙 was both gap and backlash."""
    stray: dict[str, set[str]] = {}
    for lesson in LESSONS.values():
        used = {each.id for each in EN.used(words for _, words in prose_parts(lesson.words["en"]))}
        for each in ZH.used(words for _, words in prose_parts(lesson.words["zh"])):
            if each.id not in used:
                stray.setdefault(each.id, set()).add(lesson.id)
    assert {term: where for term, where in stray.items() if len(where) > 6} == {}
    assert "backlash" not in stray


def test_a_broken_file_is_refused_with_what_is_wrong() -> None:
    for text, said_of_it in (("# G\n\n## pole\n\nA root.\n", "no formula for pole"), ("# G\n\n## pole\n\n$s$\n", "no explanation for pole"),
                             ("# G\n\n## a\n- b\n\nx\n\n$s$\n\n## b\n\ny\n\n$s$\n", "the form b twice")):
        with pytest.raises(ProseError, match=said_of_it):
            parse_glossary(text)


# --- in a page ---------------------------------------------------------------------------------------------------------
class Terms(HTMLParser):
    """The terms that are marked in a page, with what they say, and the page's own text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.marked: list[tuple[str, str, str]] = []
        self.inside: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        told = dict(attrs)
        if tag == "abbr":
            assert not {"math", "code", "a", "abbr", "h1", "h2"} & set(self.inside), self.inside
            assert told["class"] == "ol-term" and told["tabindex"] == "0"
            self.marked.append((told["data-term"] or "", told["title"] or "", ""))
        self.inside.append(tag)

    def handle_endtag(self, tag: str) -> None:
        self.inside.pop()


def without(page: str) -> str:
    return re.sub(r"</?abbr[^>]*>", "", page)


def test_the_first_use_of_a_term_is_marked_outside_of_headings_code_links_and_formulas() -> None:
    page = explained(PAGE, EN)
    assert re.findall(r">([^<]+)</abbr>", page) == ["observer", "observer gain"] and page.startswith("# An observer\n\nAn <abbr ")
    assert without(page) == PAGE and explained(page, EN) == page


def test_a_rendered_page_keeps_its_formulas_and_tags() -> None:
    words = render_markdown("The rank $\\mathrm{rank}(A)$ & more")
    page = f'<h2>Rank</h2><p title="rank">{words} <a href="rank">rank</a> <code>rank</code> RANK</p>'
    marked = explained(page, EN)
    assert [key for key, _, _ in Terms(marked).marked] == ["rank"] and without(marked) == page
    assert re.findall(r"<math.*?</math>", marked) == re.findall(r"<math.*?</math>", page)


def test_an_explanation_cannot_break_out_of_its_attribute() -> None:
    evil = parse_glossary("# G\n\n## a b\n\n\"><script>alert('{x}')</script> & so\n\n$s$\n")
    page = explained("<p>a b</p>", evil)
    assert Terms(page).marked == [("a b", "\"><script>alert('{x}')</script> & so", "")] and "<script" not in page and "{" not in page


@pytest.mark.slow
@pytest.mark.parametrize("language", ["en", "zh"])
def test_all_texts_of_lessons_are_unchanged_but_for_the_marks(language: str) -> None:
    glossary, count = glossaries()[language], 0
    for words in lesson_words(language):
        for page in (words, render_markdown(words)):
            marked = explained(page, glossary)
            assert without(marked) == page
            keys = [key for key, _, _ in Terms(marked).marked] if page is not words else re.findall(r'data-term="([^"]*)"', marked)
            assert len(keys) == len(set(keys))
            count += len(keys)
    assert count > 2000


@given(st.lists(st.sampled_from(["observer", "`", "$", "<b>", "</b>", "<math>", "</math>", "\n", "# ", "[", "](x)", "pole ", "&amp;", "{x}",
                                 "<", ">", "```\n", "zero", "    "]), max_size=14))
def test_marking_only_ever_adds_marks(parts: list[str]) -> None:
    page = "".join(parts)
    marked = explained(page, EN)
    assert without(marked) == without(page) and explained(marked, EN) == marked


# --- on the command line -------------------------------------------------------------------------------------------------
def test_glossary_prints_one_term_or_all(capsys) -> None:
    assert main(["glossary", "Observer", "gains"]) == 0
    assert capsys.readouterr().out.startswith("- **observer gain**: The matrix")
    assert main(["glossary", "--lang", "zh", "observer gain"]) == 0
    assert capsys.readouterr().out.startswith("- **观测器增益**: 乘在新息上")
    assert main(["glossary", "--json"]) == 0
    assert [each["id"] for each in json.loads(capsys.readouterr().out)] == [each.id for each in EN.entries]


@pytest.mark.parametrize("language", ["en", "zh"])
def test_teach_ends_with_the_terms_of_the_lesson(language: str, capsys) -> None:
    assert main(["teach", "kalman", "--lang", language]) == 0
    told = capsys.readouterr().out
    used = glossaries()[language].used(
        words for where, words in prose_parts(LESSONS["kalman"].words[language]) if not where.startswith("reference"))
    notes, _, terms = told.rpartition("\n## ")
    assert notes and len(used) > 15 and terms.count("\n- **") == len(used)
    assert "whiteness" in {each.id for each in used} and "backlash" not in {each.id for each in used}


def test_an_unknown_term_is_refused_with_terms_that_are_spelled_like_it(capsys) -> None:
    assert "innovation" in refused(capsys, "glossary", "inovation") and "print all terms" in refused(capsys, "glossary", "qqqq")


def test_the_glossary_is_packaged_with_the_lessons() -> None:
    assert (folder("kalman").parent / "glossary.md").is_file() and Path(folder("kalman").parent, "kalman", "en.md").is_file()
