"""What people type leads to what answers it, first or among the first three."""

from __future__ import annotations

import json

import pytest

from observer_lab import engine
from observer_lab.cli.entry import main
from observer_lab.course.search.finder import finder
from observer_lab.course.search.questions import parse_questions, questions
from observer_lab.engine import filters
from observer_lab.lessons import LESSONS
from observer_lab.text import languages

MOST_WORDS, FEWEST_PHRASES = 60, 120
FIRST, AMONG_THREE = 0.9, 1.0  # of the phrases that the list holds
# typed otherwise than the list has it: with a slip, in another order, as a question
OTHERWISE = {
    "missing measurement": "missing", "sensor drops samples": "missing", "outlier": "outliers", "reject an outlier": "outliers",
    "variable timestep": "irregular", "timestamps irregular": "irregular", "tuning Q R": "tune", "how to choose Q": "tune",
    "how to tune a kalman filter": "tune", "covariance is not positive-definite": "definite", "steady state error": "offset",
    "track a setpoint": "offset", "add an integrator": "integral", "lqi": "integral", "observer delay": "delay",
    "deadtime": "delay", "how much latency": "latency", "smith": "predictor", "estimate disturbances": "disturbance",
    "load torque estimate": "disturbance", "gyroscope bias": "bias", "estimate bias": "bias", "moving-horizon": "horizon",
    "mhe estimator": "horizon", "run on arduino uno": "arduino", "microcontrollers": "arduino", "observer versus kalman": "versus",
    "what is a luenberger observer": "what", "virtual sensors": "what", "choosing observer poles": "gain",
    "pole placement": "placement", "state-feedback": "placement", "the separation principle": "separate",
    "is it observable": "observable", "observability rank": "observable", "unobservable modes": "hidden", "detectable": "hidden",
    "anti windup": "windup", "actuator saturates": "windup", "lqr weights": "lqr", "gain margins": "margins",
    "lqg robust": "margins", "mismatch of the model": "wrong", "detect sensor faults": "fault", "false alarms": "threshold",
    "ekf vs ukf": "nonlinear", "ekf divergence": "diverges", "innovation whiteness": "consistency", "nees test": "consistency",
    "subspace identification n4sid": "identify", "rts": "smoother", "offline smoothing": "smoother", "reduced order": "reduced",
    "functional observers": "functional", "unknown inputs": "unknown", "peaking phenomenon": "peaking", "hankel": "order",
    "balanced model reduction": "order", "discretize": "sampled", "zero order hold": "sampled", "load my own matrices": "own",
    "decouple mimo loops": "decouple", "read a csv": "identify", "import log": "identify"}


@pytest.mark.parametrize("language", languages())
def test_every_phrase_of_the_list_finds_its_answer(language: str) -> None:
    entries, search = questions()[language].entries, finder(LESSONS, language)
    typed = [(phrase, entry.title) for entry in entries for phrase in entry.phrases]
    assert len(typed) >= FEWEST_PHRASES and len(entries) == 40
    found = {phrase: [hit.title for hit in search.find(phrase, 3)] for phrase, _ in typed}
    assert sum(found[phrase][:1] == [title] for phrase, title in typed) >= FIRST * len(typed)
    assert sum(title in found[phrase] for phrase, title in typed) >= AMONG_THREE * len(typed)


def test_other_wordings_find_it_too() -> None:
    search, titles = finder(LESSONS, "en"), {each.id: each.title for each in questions()["en"].entries}
    found = {typed: [hit.title for hit in search.find(typed, 3)] for typed in OTHERWISE}
    later = {typed: hits for typed, hits in found.items() if hits[:1] != [titles[OTHERWISE[typed]]]}
    lost = {typed: hits for typed, hits in found.items() if titles[OTHERWISE[typed]] not in hits}
    assert len(later) <= 0.15 * len(OTHERWISE), later
    assert len(lost) <= 0.05 * len(OTHERWISE), lost


@pytest.mark.parametrize(("together", "apart"), [("deadtime", "dead time"), ("statefeedback", "state feedback"),
                                                  ("poleplacement", "pole placement"), ("timestep", "time step")])
def test_two_words_written_together_find_what_they_find_apart(together: str, apart: str) -> None:
    search = finder(LESSONS, "en")
    assert search.find(together, 3)[:1] == search.find(apart, 3)[:1] != ()
    assert search.find("xyzzyqwerty") == ()


def test_every_question_leads_to_a_scene_and_a_name_that_are_there() -> None:
    for entry in questions()["en"].entries:
        assert entry.scene in [scene.id for scene in LESSONS[entry.lesson].path], entry.id
        assert not entry.name or hasattr(engine, entry.name) or hasattr(filters, entry.name), entry.id


@pytest.mark.parametrize("language", languages())
def test_no_answer_is_longer_than_it_may_be(language: str) -> None:
    for entry in questions()[language].entries:
        words = entry.answer if language == "zh" else entry.answer.split()
        assert 20 <= len(words) <= MOST_WORDS * (3 if language == "zh" else 1), (entry.id, len(words))
        assert language == "en" or entry.title != next(e.title for e in questions()["en"].entries if e.id == entry.id)


def test_a_question_without_phrases_is_refused() -> None:
    with pytest.raises(ValueError, match="lacks a phrase"):
        parse_questions("en", "# Title\n## one: What?\nnothing\n")


def test_find_prints_the_answer_and_how_to_open_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["find", "missing", "measurements"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("Some measurements are missing.") and "observer-lab link network --view guide --scene packets" in printed
    assert main(["find", "丢包", "--lang", "zh", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["scene"] == "packets"
    assert main(["find", "丢包", "--json"]) == 0  # Chinese words need no option
    assert json.loads(capsys.readouterr().out)[0]["scene"] == "packets"
    assert main(["find", "ctrb"]) == 0 and "from observer_lab.engine import ctrb" in capsys.readouterr().out
    assert main(["find", "xyzzy"]) == 2 and "try other words" in capsys.readouterr().err


def test_a_link_opens_a_scene_of_the_guide(capsys: pytest.CaptureFixture[str]) -> None:
    from observer_lab.session.state.token import read_token

    assert main(["link", "separation", "--view", "guide", "--scene", "command", "--set", "command=1.5", "--json"]) == 0
    saved = read_token(json.loads(capsys.readouterr().out)["token"], LESSONS)
    assert (saved.mode, saved.scene) == ("guide", "command") and saved.design["command"] == 1.5
    assert saved.design["stiffness_error"] == 30.0  # as the path has set it by then
    assert main(["link", "separation", "--scene", "nowhere"]) == 2
    assert "it has meet, recall" in capsys.readouterr().err
