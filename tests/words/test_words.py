"""Plain English: the rules find what readers stumbled on, leave plain sentences alone, and no new offender comes in."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from report import figures, offenders
from word_rules import MAX_WORDS, NUMBERS, offences, word_count
from word_sources import Sentence, every_sentence, markdown, pages, sentences

DECODED = (  # sentences and phrases on which readers stumbled
    "it believes its model and is deaf", "what trusts a noisy sensor trembles with it", "told the wish", "told the truth",
    "an honest wire", "the error keeps its promise", "the error leaves its promise", "the error lives by itself",
    "paid once per surprise", "turn K_d on its side", "how loudly a start is heard", "a mode that is bolted", "delay it bears",
    "gains from 0.07 to 5.4 are borne", "settles / departs", "comes home / does not", "The run departs.", "bold, timid, shy",
    "bold", "timid", "shy", "the filter at the start is told of", "without a say", "It falls silent.", "accused, rightly", "liar",
    "witness", "innocent", "may be lost: 69.4 % may be", "no analysis that applies here says no", "The loop does not get there.",
    "which entry the observer is to be slower", "expanded anew", "who takes most out of the resonances", "A vector 16.7 long.",
    "mend", "Which observer forgives a wrong model?", "Are there two problems or one?",
    "Of an axis that stays at 1 the noise lets nothing through.", "What is so is revealed.", "that which is not seen",
    "the poles, of which two are real", "The filter who is right wins.", "What is not measured stays unknown.",
    "That the sensor is noisy makes no difference.", "Never does the estimate leave the band.", "Filters do not hear, they weigh.",
    "The filters promise too much.", "the loop keeps believing all sensors", "claimed in vain", "the output is listened to",
    "J does not see N", "The window forgets at its edge.", "a wrong start is forgotten", "The error dies out.", "the slow twin",
    "The member keeps quiet.", "a lie of the sensor", "the observer is still told the force", "The blocks are not home.",
    "The estimate claims 2 N m.", "the sensor is blind for two motions",
    "Nor does any later one.", "In the middle of the deck stands a sensor.", "So does the observer.",
    "It costs 1.3e+02.", "A change of -39.6 is seen.", "It is 67000 % off.", "The cost is −6.3·10⁻¹⁰ % larger.", "It is 3 .",
    "The input is 12,000 % larger.", "A peak of 5 () is seen.")
PLAIN = (
    "It trusts the model and ignores the sensor.", "An observer that trusts a noisy sensor becomes noisy too.",
    "given the commanded force", "given the applied force", "a signal that carries the applied force",
    "The error follows ė = (A − LC)e.", "The error departs from ė = (A − LC)e.", "The error dynamics are autonomous.",
    "paid after every disturbance", "Transpose K_d.", "output energy of an initial state", "a fixed mode", "delay margin",
    "stable for gains from 0.07 to 5.4", "decays", "grows", "recovers", "does not recover", "over-confident", "under-confident",
    "the default filter assumes", "It has no effect on û.", "correctly identified", "faulty sensor", "residual", "fault-free",
    "Up to 69.4 % losses can be tolerated.", "All applicable checks pass.", "It cannot reach this effort.",
    "There the observer must be slower.", "relinearised", "Which controller reduces the resonances most?", "of norm 16.7",
    "repair", "fix", "Which observer tolerates a wrong model?",
    "You can design a controller. Can you already design an observer?", "How hot is the core you cannot touch?",
    "Disk margin 0.2: a gain change of 20 % can make the loop unstable.", "Think of the observer as a virtual sensor.",
    "Compute the recovery map", "Stiffness error (%)", "The eigenvector lies in the kernel of $C$.", "You know the gain.",
    "What is the pole of the error?", "In the middle the sensor reads 0.", "The error settles within 2 s.", "From 1·10⁻⁵ to −3.2 %",
    "Which of the three motions does it see?", "Of course the gain is finite.", "Type `-1`.", "The gain is $K=-1$.")


@pytest.mark.parametrize("sentence", DECODED)
def test_a_sentence_that_has_to_be_decoded_is_found(sentence: str) -> None:
    assert offences(sentence)


@pytest.mark.parametrize("sentence", PLAIN)
def test_a_plain_sentence_is_left_alone(sentence: str) -> None:
    assert offences(sentence) == []


@given(st.integers(1, 60))
def test_a_sentence_is_too_long_beyond_the_limit_alone(count: int) -> None:
    long = "The " + "gain " * (count - 1)
    assert word_count(long) == count and bool(offences(long)) == (count > MAX_WORDS)


def test_formulas_code_and_places_count_as_one_word_and_are_not_judged() -> None:
    said = "The gain $\\frac{a}{-1}$ of `run --set x=-1` and {peak:.3g} {unit} is at [[place]]."
    assert word_count(said) == 11 and offences(said) == []


def test_comments_of_scripts_may_write_numbers_in_ascii() -> None:
    assert offences("tolerance 1e-6") and not offences("tolerance 1e-6", (NUMBERS,)) and offences("told the wish", (NUMBERS,))


def test_sentences_of_markdown_stand_at_their_lines() -> None:
    page = ("# A title\n\nOne sentence. Another\none, e.g. this.\n- an item\n  that goes on\n  > why\n\n```\ncode that is not read\n```\n"
            "| cell | - |\n|---|---|\n## task here: Its title\n$$x=1$$\n### solution\nDone.")
    assert [(one.line, one.words) for one in markdown(page, "page")] == [
        (1, "A title"), (3, "One sentence."), (3, "Another one, e.g. this."), (5, "an item that goes on"), (7, "why"), (12, "cell"),
        (14, "Its title"), (17, "Done.")]


def test_a_sentence_ends_at_its_stop() -> None:
    assert sentences("The gain is 0.5 by D. G. Luenberger. Is it? “Yes.” It is {x}. $K$ grows.") == [
        "The gain is 0.5 by D. G. Luenberger.", "Is it?", "“Yes.”", "It is {x}.", "$K$ grows."]
    assert sentences("The error is up to [[e:.2g]] K. The core cools.") == ["The error is up to [[e:.2g]] K.", "The core cools."]
    assert sentences("The core is at 5 K. The force is 2 N. It rests.") == ["The core is at 5 K.", "The force is 2 N.", "It rests."]


def test_figures_are_median_and_percentile() -> None:
    short, long = Sentence("One two three.", "a", 1), Sentence("word " * 30, "a", 2)
    assert figures([short] * 9 + [long]) == "10 sentences; median 3 words, 95th percentile 30, longest 30"


@pytest.mark.slow
def test_no_sentence_has_to_be_decoded() -> None:
    """`python tests/words/report.py` prints the same."""
    every = every_sentence()
    assert len(every) > 5000 and len(pages()) > 40
    bad = offenders(every)
    assert not bad, "\n".join(f"{one.where}: {'; '.join(why)}: {one.words}" for one, why in bad.items())


@pytest.mark.slow
def test_every_kind_of_source_is_read() -> None:
    files = {one.file for one in every_sentence()}
    wanted = {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "en.md", "path.md", "teacher.md", "phrases.py", "serve.py", "options.py",
              "own.py"}
    assert {name for name in wanted if not any(file.endswith(name) for file in files)} == set()


IDIOMS = (  # of captions, verdicts and names, each with what is said now in PLAIN
    "Caught.", "promised by A − LC", "The line is taken at its word.", "The error is left alone.", "no L saves the estimate",
    "colour in the innovations", "Answered with no: stable.", "a filter that doubts too much", "HL lies from 2 s on.",
    "The bank names nobody.", "Unstable in this world: SISO.", "There is nothing to feel above 60 km.", "Both states still speak.",
    "The rest is rounding, nothing else.", "NIS is content.", "No test finds it out.")


@pytest.mark.parametrize("sentence", IDIOMS)
def test_an_idiom_of_a_caption_is_found(sentence: str) -> None:
    assert offences(sentence)
