"""Votes and counts of a room: what is acknowledged is on the disk, what would tell who chose what is not shown."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from observer_lab.classroom.answer_grids import ACROSS, COLUMNS, LEVELS, LONGEST_SKETCH, UP, PoleGrid, SketchGrid
from observer_lab.classroom.kept_room import KeptPages, KeptRoom, VoteWriter
from observer_lab.classroom.page_store import KEPT_ACTS, KEPT_BATCHES, StandingPage
from observer_lab.classroom.redis_connection import RoomProblem
from observer_lab.classroom.room import LECTURE, MAX_PLACES, UNSOLVED, ClassRuns, OwnRun, overview, read_runs, seeds_of
from observer_lab.classroom.room_store import FILE, STEPS, RoomStore
from observer_lab.classroom.votes import (
    HIDDEN_BELOW,
    MAX_BINS,
    Asked,
    Vote,
    histogram,
    is_ballot,
    read_pole_question,
    read_question,
    votes_on,
    votes_on_typed,
)
from observer_lab.course.lesson import Board
from observer_lab.page.room.class_seats import own_run_html
from observer_lab.text import NO_WORDS

FIRST_FORM = """
CREATE TABLE room (id INTEGER PRIMARY KEY CHECK (id = 1), secret TEXT NOT NULL, state TEXT NOT NULL, hands INTEGER NOT NULL);
CREATE TABLE votes (number INTEGER PRIMARY KEY, lesson TEXT NOT NULL, scene TEXT NOT NULL, round INTEGER NOT NULL,
  open INTEGER NOT NULL, counts TEXT NOT NULL, asked TEXT NOT NULL, edges TEXT NOT NULL);
CREATE TABLE ballots (vote INTEGER NOT NULL, ballot TEXT NOT NULL, answer REAL NOT NULL, PRIMARY KEY (vote, ballot)) WITHOUT ROWID;
CREATE TABLE presence (worker INTEGER NOT NULL, place TEXT NOT NULL, people INTEGER NOT NULL, slower INTEGER NOT NULL,
  PRIMARY KEY (worker, place));
CREATE TABLE drawn (id INTEGER PRIMARY KEY CHECK (id = 1), seed INTEGER NOT NULL, taken INTEGER NOT NULL);
CREATE TABLE seats (seat INTEGER PRIMARY KEY, worker INTEGER NOT NULL);
CREATE TABLE runs (id INTEGER PRIMARY KEY CHECK (id = 1), number INTEGER NOT NULL, words TEXT NOT NULL);
INSERT INTO runs VALUES (1, 0, '');
INSERT INTO room VALUES (1, 'the-word-of-before', '1.token', 0);
INSERT INTO drawn VALUES (1, 42, 7);
INSERT INTO votes VALUES (1, 'separation', 'why', 1, 0, '[3, 2, 1]', '', '[]'), (2, 'separation', 'why', 2, 1, '[0, 0, 0]', '', '[]');
INSERT INTO ballots VALUES (2, 'ballot0001', 1.0);
"""
GRID = PoleGrid("observer", -10.0, 2.0, 8.0)


def opened(store: KeptRoom, scene: str = "why", options: int = 3) -> Vote:
    store.open_vote("separation", scene, options)
    return store.votes()[-1]


def ballots(vote: Vote, *options: int) -> list[tuple[int, str, int]]:
    return [(vote.number, f"ballot{k:04d}", option) for k, option in enumerate(options)]


def test_counts_are_hidden_until_five_have_voted(store: KeptRoom) -> None:
    vote = opened(store)
    store.cast(ballots(vote, *[1] * (HIDDEN_BELOW - 1)))
    store.close_vote()
    store.mark_vote(replace(store.votes()[-1], counts_out=True))
    few = store.votes()[-1]
    assert few.visible and (few.total, few.shown) == (HIDDEN_BELOW - 1, None)
    vote = opened(store)
    store.cast(ballots(vote, *[1] * (HIDDEN_BELOW - 1), 0))
    store.mark_vote(replace(vote, counts_out=True))
    assert store.votes()[-1].shown is None and not store.votes()[-1].visible, "an open vote is not marked"
    store.close_vote()
    assert store.votes()[-1].shown is None and store.votes()[-1].sealed().total == 0
    for counts_out, revealed, until in ((True, False, 0), (False, False, 7), (True, True, 0), (False, True, 0)):
        store.mark_vote(replace(store.votes()[-1], counts_out=counts_out, revealed=revealed, talks=until))
        found = store.votes()[-1]
        assert (found.counts_out, found.revealed, found.talks) == (counts_out, revealed, until)
        assert found.shown == ((1, HIDDEN_BELOW - 1, 0) if counts_out else None) and found.sealed().total == 5 * counts_out


def test_a_browser_that_votes_again_replaces_its_vote(store: KeptRoom) -> None:
    vote = opened(store)
    assert store.cast([(vote.number, "sameballot", 0), (vote.number, "sameballot", 2)]) == [True, True]
    assert store.votes()[-1].counts == (0, 0, 1)


def test_a_vote_that_is_closed_unknown_or_beyond_the_options_does_not_count(store: KeptRoom) -> None:
    vote = opened(store)
    assert store.cast([(vote.number, "ballot01", 3), (vote.number, "ballot02", -1), (vote.number + 1, "ballot03", 0)]) == [False] * 3
    store.close_vote()
    assert store.cast(ballots(vote, 0)) == [False]
    assert store.votes()[-1].counts == (0, 0, 0)


def test_closing_keeps_the_counts_and_no_ballot(tmp_path: Path) -> None:
    store = RoomStore(tmp_path)
    vote = opened(store)
    store.cast(ballots(vote, 0, 1, 1, 2, 1))
    store.close_vote()
    assert store.votes()[-1].counts == (1, 3, 1) and not store.votes()[-1].open
    with sqlite3.connect(tmp_path / FILE) as database:
        assert database.execute("SELECT COUNT(*) FROM ballots").fetchone() == (0,)
        columns = {row[1] for table in ("votes", "ballots", "presence") for row in database.execute(f"PRAGMA table_info({table})")}
    assert columns == {"number", "lesson", "scene", "round", "open", "counts", "vote", "ballot", "answer", "asked", "edges", "worker",
                       "place", "people", "slower", "counts_out", "revealed", "talks"}


def test_a_file_of_the_first_form_is_brought_up_to_date_and_one_of_a_later_version_refused(tmp_path: Path) -> None:
    """As `FIRST_FORM` was written by fbea0ee: a vote that was closed had shown all, the secret and the room's seed stay."""
    with sqlite3.connect(tmp_path / FILE) as database:
        database.executescript(FIRST_FORM)
    stores = [RoomStore(tmp_path) for _ in range(2)]
    for store in stores:
        assert store.secret == "the-word-of-before" and store.seed == 42 and store.state == "1.token"
        first, second = store.votes()
        assert (first.counts, first.open, first.visible, first.revealed) == ((3, 2, 1), False, True, True)
        assert (second.counts, second.open, second.visible, second.revealed) == ((0, 1, 0), True, False, False)
    with sqlite3.connect(tmp_path / FILE) as database:
        assert database.execute("PRAGMA user_version").fetchone() == (len(STEPS),)
        database.execute(f"PRAGMA user_version = {len(STEPS) + 1}")
    with pytest.raises(RoomProblem, match="later version"):
        RoomStore(tmp_path)


def test_asking_again_makes_a_second_round_beside_the_first(store: KeptRoom) -> None:
    first = opened(store)
    store.cast(ballots(first, 0, 0, 0, 1, 1))
    second = opened(store)
    store.cast(ballots(second, 1, 1, 1, 1, 1))
    opened(store, "surprise")
    found = votes_on(store.votes(), "separation", "why")
    assert [(vote.round, vote.counts, vote.open) for vote in found] == [(1, (3, 2, 0), False), (2, (0, 5, 0), False)]


def test_a_process_that_ends_at_any_moment_loses_no_acknowledged_vote(tmp_path: Path) -> None:
    """Each acknowledgement is followed by a look through a connection of its own, which sees committed rows alone."""
    store = RoomStore(tmp_path)
    vote, writer, seen, done = opened(store), VoteWriter(store), [], threading.Event()
    other = sqlite3.connect(tmp_path / FILE, check_same_thread=False)

    def told(ballot: str, counted: bool) -> None:
        row = other.execute("SELECT COUNT(*) FROM ballots WHERE ballot = ?", (ballot,)).fetchone()[0]
        seen.append((counted, row))
        if len(seen) == 300:
            done.set()
    writer.start()
    for number, ballot, option in ballots(vote, *[k % 3 for k in range(300)]):
        writer.cast(number, ballot, option, lambda counted, ballot=ballot: told(ballot, counted))
    assert done.wait(60) and set(seen) == {(True, 1)}
    writer.close()
    assert RoomStore(tmp_path).votes()[-1].counts == (100, 100, 100)


def test_the_presenters_word_and_the_state_survive(store: KeptRoom, room: Callable[[], KeptRoom]) -> None:
    assert store.state == ""
    store.keep_state("1.abc")
    again = room()
    assert (again.secret, again.state) == (store.secret, "1.abc") and len(store.secret) >= 32


def test_the_presenters_word_and_the_state_survive_and_the_file_is_for_its_owner(tmp_path: Path) -> None:
    store = RoomStore(tmp_path)
    store.keep_state("1.abc")
    assert (RoomStore(tmp_path).secret, RoomStore(tmp_path).state) == (store.secret, "1.abc")
    assert (tmp_path / FILE).stat().st_mode & 0o077 == 0


def test_the_counts_of_all_workers_are_added(store: KeptRoom, room: Callable[[], KeptRoom]) -> None:
    other = room()
    store.report(0, {LECTURE: 3, "kalman/why": 1, UNSOLVED + "kalman/band": 1}, 2)
    other.report(1, {LECTURE: 4, "kalman/why": 2, "noise": 1}, 1)
    view = overview(*store.presence(), store.votes())
    assert (view.here, view.following, view.slower) == (11, 7, 3)
    assert dict(view.places) == {"kalman/why": 3, "noise": 1} and view.unsolved == (("kalman/band", 1),)
    other.lower_hands()
    assert store.presence()[1] == 0 and store.hands == 1
    store.forget_presence()
    assert store.presence() == ({}, 0)


def test_numbers_of_followers_are_given_once_and_a_restart_keeps_the_seed(store: KeptRoom, room: Callable[[], KeptRoom]) -> None:
    other = room()
    assert [store.take_seats(0, 2), other.take_seats(1, 3), store.take_seats(0, 1)] == [[1, 2], [3, 4, 5], [6]]
    store.leave_seats([2, 6])
    assert other.seats() == (1, 3, 4, 5)
    store.empty_worker(1)
    assert other.seats() == (1,) and other.take_seats(1, 1) == [7]
    assert room().seed == store.seed and 0 <= store.seed < 2**63
    store.forget_presence()
    assert store.seats() == () and store.take_seats(0, 1) == [8]


def test_seeds_differ_from_follower_to_follower_and_from_room_to_room() -> None:
    drawn = [seed for room in (1, 2, 2**62) for seed in seeds_of(room, tuple(range(1, 301)))]
    assert len(set(drawn)) == len(drawn) == 900 and seeds_of(2, (7,)) == (drawn[306],)


def test_runs_of_a_class_reach_all_workers_and_end_with_the_server(store: KeptRoom, room: Callable[[], KeptRoom]) -> None:
    other, before = room(), store.run_number
    runs = ClassRuns({"en": "error"}, (0.0, 1.0), {4: OwnRun((0.0, -0.5), (0.0, 0.3), True), 9: OwnRun((0.0, 2.0), (0.0, 0.3), False)})
    store.keep_runs(runs.write())
    assert other.run_number == before + 1 and read_runs(other.runs()) == runs
    other.keep_runs("")
    assert (store.run_number, store.runs()) == (before + 2, "")
    store.keep_runs(runs.write())
    store.forget_presence()
    assert other.runs() == ""


def test_an_overview_names_few_places() -> None:
    assert len(overview({f"lesson{k}": k for k in range(1, 20)}, 0, ()).places) == MAX_PLACES


@pytest.mark.parametrize("word", ["", "short", "with space 123", "a" * 65, 12345678, None, "ümläut12345", "semi;colon12"])
def test_what_is_no_ballot_is_not_taken(word: object) -> None:
    assert not is_ballot(word)


def test_a_page_is_the_whole_and_the_batches_after_it(pages: Callable[[], KeptPages]) -> None:
    mine, other = pages(), pages()
    series = mine.begin_series()
    for k in range(1, 5):
        mine.append("en-wide", series, k, b"%d" % k)
    mine.stand("en-wide", series, 2, b"whole")
    assert other.standing("en-wide") == StandingPage(series, 2, b"whole")
    assert other.after("en-wide", series, 2) == [(3, b"3"), (4, b"4")]
    mine.append("en-wide", series, 4, b"again")
    assert other.after("en-wide", series, 3) == [(4, b"again")], "a batch that was sent twice is one"
    mine.append("en-wide", series, KEPT_BATCHES + 5, bytes(range(256)))
    mine.stand("en-wide", series, KEPT_BATCHES + 3, b"whole")
    assert other.after("en-wide", series, 0) == [(4, b"again"), (KEPT_BATCHES + 5, bytes(range(256)))]
    assert other.standing("zh-wide") is None and other.series == series
    other.want("zh-phone")
    assert mine.wanted() == ["zh-phone"]
    assert mine.after("en-wide", mine.begin_series(), 0) == []


def test_commands_of_a_hand_reach_every_worker_in_their_order_and_a_lead_runs_out(pages: Callable[[], KeptPages]) -> None:
    one, other = pages(), pages()
    mark = other.last_act()
    for k in range(KEPT_ACTS + 5):
        one.add_act(f"act {k}")
    found = other.acts_after(mark)
    assert [words for _, words in found[-KEPT_ACTS:]] == [f"act {k}" for k in range(5, KEPT_ACTS + 5)]
    assert found[-1][0] == one.last_act() and not other.acts_after(one.last_act())
    assert [words for _, words in other.acts_after(found[-3][0])] == [f"act {k}" for k in range(KEPT_ACTS + 3, KEPT_ACTS + 5)]
    assert not one.is_led()
    one.keep_lead(30.0)
    assert other.is_led()
    other.end_lead()
    assert not one.is_led()
    one.keep_lead(0.01)
    time.sleep(0.02)
    assert not other.is_led()


def test_numbers_are_counted_between_round_edges_and_an_absurd_one_spreads_nothing(store: KeptRoom) -> None:
    store.open_vote("kalman", "gain", 0, Asked("How large is the gain?"))
    vote = store.votes()[-1]
    numbers = [0.31, 0.33, 0.35, 0.38, 0.42, 0.47, 0.52, 0.36, 0.34, 0.39] * 4 + [1e12]
    assert store.cast([(vote.number, f"ballot{k:04d}", number) for k, number in enumerate(numbers)]) == [True] * len(numbers)
    assert store.cast([(vote.number, f"odd{k:09d}", odd) for k, odd in enumerate((np.nan, np.inf, -np.inf, 1e300))]) == [False] * 4
    store.close_vote()
    closed = store.votes()[-1]
    assert closed.total == len(numbers) and len(closed.edges) == len(closed.counts) + 1 <= MAX_BINS + 1
    assert closed.edges[0] <= 0.31 and 0.52 <= closed.edges[-1] < 0.7
    np.testing.assert_allclose(closed.edges, np.round(np.array(closed.edges) / 0.05) * 0.05, atol=1e-12)


@pytest.mark.parametrize("numbers", [[], [0.0], [3.0] * 9, [-1e12, 1e12], [1e-300, 2e-300], [-5.0, -5.0, 7.0], [1e12, 1e12 - 1]])
def test_every_number_is_in_some_bin(numbers: list[float]) -> None:
    edges, counts = histogram(numbers)
    assert sum(counts) == len(numbers) and len(counts) <= MAX_BINS and (len(edges) == len(counts) + 1 or not numbers)
    assert all(np.isfinite(edges)) and list(edges) == sorted(edges)


def test_poles_are_counted_by_place_and_only_those_on_the_plane(store: KeptRoom, room: Callable[[], KeptRoom]) -> None:
    store.open_vote("separation", "drag", 0, Asked("", (), GRID))
    vote = store.votes()[-1]
    poles = [-4 + 2j, -4 - 2j, -4.02 + 1.97j, -1 + 0j, -1 + 0.05j]
    assert store.cast([(vote.number, f"ballot{k:04d}", pole) for k, pole in enumerate(poles)]) == [True] * 5
    odd = [complex(np.nan, 1), complex(-1, np.nan), complex(np.inf, 0), complex(-1, -np.inf), 1e300 + 0j, -10.3 + 0j, -1 + 8.5j, 3, 2.0, -1]
    assert store.cast([(vote.number, f"odd{k:09d}", each) for k, each in enumerate(odd)]) == [False] * len(odd)
    assert store.votes()[-1].cloud == () and store.votes()[-1].sealed().total == 0, "nothing while the vote is open"
    store.close_vote()
    assert store.votes()[-1].cloud == () and store.votes()[-1].sealed().total == 0, "nothing until it is shown"
    store.mark_vote(replace(vote, counts_out=True))
    closed = room().votes()[-1]
    assert closed.asked == Asked("", (), GRID) and closed.sealed() == closed and dict(closed.cloud) == {-4 + 2j: 3, -1 + 0j: 2}


def test_a_cloud_of_fewer_than_five_poles_is_hidden_and_other_votes_take_no_pole(store: KeptRoom) -> None:
    store.open_vote("separation", "drag", 0, Asked("Where?", (), GRID))
    store.cast([(store.votes()[-1].number, f"ballot{k:04d}", -1 + 1j) for k in range(HIDDEN_BELOW - 1)])
    assert store.votes()[-1].cloud == () and store.votes()[-1].total == HIDDEN_BELOW - 1
    for asked in (Asked("How large?"), Asked("Which?", ("a", "b")), None):
        store.open_vote("separation", "why", 3, asked)
        assert store.cast([(store.votes()[-1].number, "ballot0001", 1 + 0j)]) == [False]


@pytest.mark.parametrize("board", [
    Board("a", NO_WORDS, ()), Board("a", NO_WORDS, (), re_low=-1.2, re_high=1.2, im_high=1.2, disc=True),
    Board("a", NO_WORDS, (), re_low=-3.3e5, re_high=1.7e4, im_high=9.1e4),
    Board("a", NO_WORDS, (), re_low=-8e-4, re_high=-1e-4, im_high=3e-4)])
def test_every_cell_of_a_plane_is_a_round_place_in_its_window_and_the_nearest_to_itself(board: Board) -> None:
    grid = PoleGrid(board.id, board.re_low, board.re_high, board.im_high, board.disc)
    poles = [grid.pole_at(cell) for cell in range(grid.cells)]
    assert [grid.cell_of(pole) for pole in poles] == list(range(grid.cells)) == [grid.cell_of(pole.conjugate()) for pole in poles]
    assert 100 < grid.cells <= (ACROSS + 1) * (UP + 1)
    edge = grid.step * 1e-6
    assert all(board.re_low - edge <= pole.real <= board.re_high + edge and 0 <= pole.imag <= board.im_high + edge for pole in poles)


@pytest.mark.parametrize("words, asked", [("", Asked("", (), GRID)), (" Where? \n", Asked("Where?", (), GRID)), ("Where?\na\nb", None),
                                          ("x" * 301, None)])
def test_a_question_for_a_pole_has_no_options(words: str, asked: Asked | None) -> None:
    assert read_pole_question(words, GRID) == asked


CURVE, BARS = SketchGrid(COLUMNS), SketchGrid(3, bars=True)
unit = st.floats(0, 1)


@given(heights=st.lists(unit, min_size=COLUMNS, max_size=LONGEST_SKETCH), bars=st.lists(unit, min_size=3, max_size=3))
def test_a_drawing_is_kept_as_one_number_and_stands_where_it_was_drawn(heights: list[float], bars: list[float]) -> None:
    for grid, drawn in ((CURVE, heights), (BARS, bars)):
        number = grid.number_of(drawn)
        assert number is not None and number == int(number) < 2**53 and float(repr(number)) == number
        cells = grid.cells_of(number)
        assert len(cells) == grid.pieces and all(0 <= cell < grid.cells for cell in cells)
        along = np.interp(np.linspace(0, len(drawn) - 1, grid.columns), np.arange(len(drawn)), drawn)
        for column, level in (place for cell in cells for place in grid.places_of(cell)):
            assert abs(level / (LEVELS - 1) - along[column]) <= 0.5 / (LEVELS - 1) + 1e-9
        pieces = [grid.places_of(cell) for cell in cells]
        assert grid.bars or all(before[1] == after[0] for before, after in pairwise(pieces)), "the pieces of a curve hang together"


def test_drawings_are_counted_by_pieces_and_nothing_else_is_a_drawing(store: KeptRoom, room: Callable[[], KeptRoom]) -> None:
    for grid, drawn in ((CURVE, (0.0,) * 20 + (1.0,) * 20), (BARS, (0.0, 0.3, 1.0))):
        asked = Asked("", sketch=grid)
        store.open_vote("virtual-sensor", "predict", 0, asked)
        vote = store.votes()[-1]
        assert store.cast([(vote.number, f"ballot{k:04d}", drawn) for k in range(5)]) == [True] * 5
        assert store.cast([(vote.number, "ballot0000", tuple(1 - share for share in drawn))]) == [True], "one's own is replaced"
        nan, few = (float("nan"), *drawn[1:]), drawn[:2]
        odd = [nan, few, (), (1.1, *drawn[1:]), (-0.1, *drawn[1:]), drawn * 3, 0, 1.0, -1 + 1j]
        assert store.cast([(vote.number, f"odd{k:09d}", each) for k, each in enumerate(odd)]) == [False] * len(odd)
        assert store.votes()[-1].total == 5 and store.votes()[-1].shown is None
        store.close_vote()
        store.mark_vote(replace(vote, counts_out=True))
        closed = room().votes()[-1]
        assert closed.asked == asked and closed.total == 5 and closed.shown is not None
        assert sorted(set(closed.shown)) == [0, 1, 4] if grid is BARS else max(closed.shown) == 4
    for asked in (Asked("How large?"), Asked("Which?", ("a", "b")), Asked("", (), GRID), None):
        store.open_vote("separation", "why", 3, asked)
        assert store.cast([(store.votes()[-1].number, "ballot0001", (0.5,) * COLUMNS)]) == [False]


def test_who_looks_in_from_another_process_and_leaves_takes_no_vote_along(tmp_path: Path) -> None:
    """SQLite deletes its log with the last connection. The others hold locks on the file, and any closing of it here would end these."""
    look = ("import sqlite3, sys; d = sqlite3.connect(sys.argv[1]); "
            "print(d.execute('SELECT COUNT(*) FROM votes').fetchone()[0]); d.close()")

    def seen() -> int:
        return int(subprocess.run([sys.executable, "-c", look, str(tmp_path / FILE)], capture_output=True, check=True, timeout=60).stdout)
    word, held = RoomStore(tmp_path), RoomStore(tmp_path)
    for count in range(3):
        held.open_vote("separation", "why", 3)
        assert seen() == count + 1
    assert len(word.votes()) == 3
    word.close()
    held.open_vote("separation", "why", 3)
    assert seen() == 4
    held.close()


def test_a_typed_question_is_a_vote_of_its_own_beside_the_scenes(store: KeptRoom) -> None:
    asked = Asked("Which one?", ("this", "that"))
    opened(store)
    for _ in range(2):
        store.open_vote("separation", "why", 0, asked)
    assert store.cast([(store.votes()[-1].number, "ballot0001", 1), (store.votes()[-1].number, "ballot0002", 2)]) == [True, False]
    assert [vote.round for vote in votes_on(store.votes(), "separation", "why")] == [1]
    assert [(vote.round, vote.asked, vote.counts) for vote in votes_on_typed(store.votes(), "separation", "why")] == [
        (1, asked, (0, 0)), (2, asked, (0, 1))]


@pytest.mark.parametrize("words, asked", [
    ("How large?", Asked("How large?")), (" Which? \n\n a \n b\n", Asked("Which?", ("a", "b"))), ("", None), ("\n \n", None),
    ("Which?\nonly one", None), ("Which?" + "\nx" * 9, None), ("x" * 301, None), ("Which?\na\n" + "b" * 121, None)])
def test_a_question_is_its_first_line_and_its_options_the_others(words: str, asked: Asked | None) -> None:
    assert read_question(words) == asked


def test_a_page_draws_a_run_of_its_own_in_its_language_and_a_large_start_hides_nothing() -> None:
    runs = ClassRuns({"en": "height error [mm]", "zh": "高度误差 [mm]"}, (0.0, 1.0, 2.0, 3.0, 4.0),
                     {4: OwnRun((900.0, 0.1, -0.1, 0.2, 0.1), (400.0, 0.1, 0.1, 0.1, 0.1), True)})
    english, chinese = (own_run_html(runs, runs.runs[4], language) for language in ("en", "zh"))
    assert "height error" in english and "inside" in english and "高度误差" in chinese
    assert ">500<" not in english and ">0.2<" in english, "its axis is that of the errors after the start"
