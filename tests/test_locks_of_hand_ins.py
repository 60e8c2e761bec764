"""Hand-ins that were forged, altered, repeated, late or meant for another course: none counts, and each is named."""

from __future__ import annotations

import random
import re
import string
from collections import Counter
from collections.abc import Callable

import pytest
from course_makers import COURSE, DEADLINE, EXAM, SECRET, TASK, course_of, right_answer, token, toys

from observer_lab.course.exercises.exam import seed_of
from observer_lab.course.handin.course_file import Course
from observer_lab.course.handin.grading import best_points, grade
from observer_lab.course.handin.hand_in import HandIn, HandInError, Refusal, read_hand_in, write_hand_in, written_key
from observer_lab.course.handin.keys import CourseKeys, derive_key

OURS = course_of()
TWIN = course_of(COURSE.replace("toys-2026", "toys-2027"))  # a course with the same secret
GUESSED = course_of(COURSE.replace(SECRET, "a secret that somebody has guessed"))  # made with the program, without the secret
LETTERS = string.ascii_letters + string.digits + "-_"
EACH = 1250  # of eight kinds: ten thousand


def hand_in(rng: random.Random, course: Course = OURS, **changes: object) -> str:
    student = f"s{rng.randrange(10**6)}"
    return token(course, **{"student": student, "answer": right_answer(OURS, student), **changes})  # type: ignore[arg-type]


def other_signature(rng: random.Random) -> str:
    message, _, _ = hand_in(rng).rpartition(".")
    return f"{message}.{''.join(rng.choices(LETTERS, k=43))}"


def other_content(rng: random.Random) -> str:
    """The signature of one hand-in under the content of another, as by a student who writes his own key into a friend's."""
    first, second = hand_in(rng), hand_in(rng)
    return f"{first.rpartition('.')[0]}.{second.rpartition('.')[2]}"


def mutated(rng: random.Random) -> str:
    """One character replaced, left out, doubled, or its case changed."""
    while True:
        whole = hand_in(rng)
        place = rng.randrange(len(whole))
        change = rng.choice([rng.choice(LETTERS + ".=+/ é"), "", whole[place] * 2, whole[place].swapcase()])
        if (altered := whole[:place] + change + whole[place + 1:]) != whole:
            return altered


KINDS: dict[str, tuple[Callable[[random.Random], str], Refusal]] = {
    "another's secret": (lambda rng: hand_in(rng, GUESSED), Refusal.FORGED),
    "another signature": (other_signature, Refusal.FORGED),
    "another content": (other_content, Refusal.FORGED),
    "mutated": (mutated, Refusal.FORGED),
    "another course": (lambda rng: hand_in(rng, TWIN), Refusal.OTHER_COURSE),
    "late": (lambda rng: hand_in(rng, issued=DEADLINE + 1 + rng.randrange(10**6)), Refusal.LATE),
    "not asked": (lambda rng: hand_in(rng, item=rng.choice(["drill exam twice", "toy exam none", "other exam twice", ""])),
                  Refusal.NOT_ASKED),
}


@pytest.mark.slow
def test_of_ten_thousand_bad_hand_ins_none_counts_and_each_is_named() -> None:
    rng = random.Random(36)
    given = [(kind, make(rng)) for kind, (make, _) in KINDS.items() for _ in range(EACH)]
    replayed = [("replayed", token(OURS, f"again {k}", right_answer(OURS, f"again {k}"))) for k in range(EACH)]
    rng.shuffle(given)
    assert all(one.refusal is None and one.points == 5 for one in grade(OURS, toys(), replayed))  # the first time
    found = grade(OURS, toys(), [*replayed, *given, *replayed])[EACH:]
    assert len(found) == 8 * EACH == 10_000
    assert all(one.refusal is not None and one.why and one.points == 0 for one in found)
    named = Counter((one.source, one.refusal) for one in found)
    assert named["replayed", Refusal.DOUBLED] == EACH
    for kind, (_, refusal) in KINDS.items():
        renamed = named[kind, Refusal.OTHER_COURSE] if kind == "mutated" else 0  # where the letter stood in the name of the course
        assert named[kind, refusal] + renamed == EACH and renamed < EACH / 4, (kind, named)
    assert best_points(OURS, found) == {}


def test_good_hand_ins_count_among_bad_ones() -> None:
    rng = random.Random(1)
    good = [("good", token(OURS, f"s{k}", right_answer(OURS, f"s{k}"))) for k in range(20)]
    bad = [(kind, make(rng)) for kind, (make, _) in KINDS.items() for _ in range(20)]
    mixed = [*good, *bad]
    rng.shuffle(mixed)
    found = grade(OURS, toys(), mixed)
    assert {one.source for one in found if one.refusal is None} == {"good"}
    assert best_points(OURS, found) == {f"s{k}": {EXAM: 5.0} for k in sorted(range(20), key=lambda k: f"s{k}")}


def test_the_last_second_of_the_deadline_is_on_time() -> None:
    answer = right_answer(OURS, "s1")
    found = grade(OURS, toys(), [("", token(OURS, "s1", answer, issued=DEADLINE + late)) for late in (0, 1)])
    assert [one.refusal for one in found] == [None, Refusal.LATE] and found[0].points == 5


def test_the_first_tries_count_by_their_time_in_whatever_order_and_the_best_gives_the_points() -> None:
    answer = right_answer(OURS, "s1")
    tokens = [token(OURS, "S1", answer, issued=DEADLINE - 10), token(OURS, "s1", "0", issued=DEADLINE - 30),
              token(OURS, " s1 ", "1/3", issued=DEADLINE - 20), token(OURS, "s1", answer, issued=DEADLINE + 5)]
    found = grade(OURS, toys(), [("", one) for one in tokens])
    assert [one.refusal for one in found] == [Refusal.DOUBLED, None, None, Refusal.LATE]
    found = grade(OURS, toys(), [("", one) for one in tokens[:2]])
    assert [one.points for one in found] == [5, 0] and best_points(OURS, found) == {"S1": {EXAM: 5.0}}


def test_a_task_counts_where_the_server_has_signed_that_it_is_solved() -> None:
    found = grade(OURS, toys(), [("", token(OURS, "s1", answer, TASK)) for answer in ("solved", "unsolved")])
    assert [one.points for one in found] == [5, 0]


def test_the_answer_of_another_student_earns_nothing() -> None:
    answers = {right_answer(OURS, f"s{k}") for k in range(30)}
    assert len(answers) > 20
    assert grade(OURS, toys(), [("", token(OURS, "s1", right_answer(OURS, "s2")))])[0].points == 0


# --- keys ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("salt", "info", "derived"), [
    ("000102030405060708090a0b0c", "f0f1f2f3f4f5f6f7f8f9", "3cb25f25faacd57a90434f64d0362f2a2d2d0a90cf1a5a4c5db02d56ecc4c5bf"),
    ("", "", "8da4e775a563c18f715f802a063c5a31b8a11f5c5ee1879ec3454e5f3c738d2d")])
def test_keys_are_derived_as_the_standard_prints(salt: str, info: str, derived: str) -> None:
    """RFC 5869, appendix A, cases 1 and 3: the first block."""
    assert derive_key(b"\x0b" * 22, bytes.fromhex(salt), bytes.fromhex(info)).hex() == derived


def test_numbers_are_the_same_for_ever_and_need_the_secret() -> None:
    assert OURS.keys.seed("s1", EXAM, 0) == "dff689633561cc6ac40b64e3f017e5c48f38719b689b51a1294a6dc088875497"
    seeds = [OURS.keys.seed("s1", EXAM, 0), TWIN.keys.seed("s1", EXAM, 0), GUESSED.keys.seed("s1", EXAM, 0), OURS.keys.seed("s2", EXAM, 0),
             OURS.keys.seed("s1", TASK, 0), OURS.keys.seed("s1", EXAM, 1), seed_of("s1", "toy", "twice", 0)]
    assert len(set(seeds)) == len(seeds)


def test_the_keys_of_numbers_and_of_signatures_differ() -> None:
    keys = CourseKeys.of("toys-2026", SECRET)
    swapped = CourseKeys(keys._signing, keys._numbers, keys._students, keys._words)
    assert keys.sign("x") != swapped.sign("x") and not keys.signed("x", swapped.sign("x")) and keys.signed("x", keys.sign("x"))


def test_no_text_of_a_course_shows_its_secret_or_its_keys() -> None:
    shown = repr(OURS) + str(OURS) + repr(OURS.keys) + token(OURS)
    assert SECRET not in shown and OURS.keys._numbers.hex() not in shown and not re.search(r"b'|\\x", repr(OURS.keys))


# --- tokens --------------------------------------------------------------------------------------------------------
def test_a_hand_in_reads_back_and_survives_what_an_e_mail_takes() -> None:
    given = HandIn("toys-2026", EXAM, "李 伟", "−1,5·10⁻²", DEADLINE)
    written = write_hand_in(OURS, given)
    assert read_hand_in(OURS, written) == given and re.fullmatch(r"[A-Za-z0-9._-]+", written)


def test_the_longest_hand_in_is_read() -> None:
    given = HandIn("toys-2026", EXAM, "李" * 60, "１" * 200, DEADLINE)
    assert read_hand_in(OURS, write_hand_in(OURS, given)) == given


@pytest.mark.parametrize("odd", ["", "olh1", "olh1..", "olh1.." + "A" * 43, "olh1." + "A" * 3000 + "." + "A" * 43, "olh1.W10." + "A" * 43,
                                 "olh1.W1tbW1tbW1tbW10." + "A" * 43, "\ud800", "олх", "olh1.\n." + "A" * 43])
def test_odd_words_are_forged_and_nothing_breaks(odd: str) -> None:
    with pytest.raises(HandInError) as refused:
        read_hand_in(OURS, odd)
    assert refused.value.kind is Refusal.FORGED


@pytest.mark.parametrize(("key", "written"), [
    ("s1234567", "s1234567"), ("  Li   Wei ", "Li Wei"), ("李伟", "李伟"), ("ＬＩ", "LI"), ("a@b.nl", "a@b.nl"), ("", ""), ("=1+1", ""),
    ("-s1", ""), ("+s1", ""), ("@s1", ""), ("s1\x1b[31m", ""), ("s" * 61, ""), ("<b>", ""), ("s1,s2", ""), ('s"1', ""), ("s1\u202e", "")])
def test_a_key_is_no_formula_of_a_spreadsheet_and_no_command_of_a_terminal(key: str, written: str) -> None:
    assert written_key(key) == written
