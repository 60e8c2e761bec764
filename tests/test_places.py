"""Who presents and who comes back always has a place; newcomers from one address leave some to others."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from hypothesis import given
from hypothesis import strategies as st

from observer_lab.page.access.places import HOLD_S, SCARCE, Place, PlaceTable, Visitor

WORKERS = 3
MOST = st.integers(1, 60)


@dataclass
class Crowd:
    """A table on a clock that is set, and who is inside."""

    most: int
    now: float = 0.0
    inside: dict[int, tuple[int, str, Place]] = field(default_factory=dict)  # by key: worker, address, place

    def __post_init__(self) -> None:
        self.table = PlaceTable(WORKERS, self.most, lambda: self.now)

    def come(self, worker: int, address: str = "", key: int = 0, presents: bool = False) -> Place | None:
        place = self.table.take(worker, Visitor(address, key, presents))
        if place is not None:
            self.inside[place.key] = worker, address, place
        return place

    def go(self, key: int, broke: bool = False) -> None:
        worker, _, place = self.inside.pop(key)
        self.table.leave(worker, place, broke)

    def fill(self, address: str) -> int:
        """As many tabs as there are places for; how many."""
        count = 0
        while self.come(count % WORKERS, address) is not None:
            count += 1
        return count


@given(MOST)
def test_one_address_leaves_a_quarter_of_the_places_to_others(most: int) -> None:
    crowd = Crowd(most)
    assert crowd.fill("flood") == most - most // SCARCE
    assert sum(crowd.come(0, f"other {k}") is not None for k in range(most)) == most // SCARCE
    assert crowd.come(0, "one more") is None


@given(MOST, st.lists(st.integers(0, 5), max_size=200))
def test_addresses_share_the_last_places_fairly(most: int, comers: list[int]) -> None:
    """Nobody above an equal share gets one of the last places; whoever is below it is turned away only where all are taken."""
    crowd = Crowd(most)
    for k, comer in enumerate(comers):
        held, count = Counter(address for _, address, _ in crowd.inside.values()), len(crowd.inside)
        entered = crowd.come(k % WORKERS, str(comer)) is not None
        share = most / max(len(held | {str(comer): 1}), 2)
        assert entered == (count < most and (most - count > most // SCARCE or held[str(comer)] < share))


@given(MOST, st.integers(1, 20))
def test_whoever_presents_has_a_place_however_full_it_is(most: int, presenters: int) -> None:
    crowd = Crowd(most)
    for k in range(most):
        crowd.come(0, str(k))
    assert all(crowd.come(k % WORKERS, "1", presents=True) is not None for k in range(presenters))
    assert crowd.come(0, "newcomer") is None


@given(MOST, st.lists(st.tuples(st.integers(0, 59), st.sampled_from(["broke", "dead worker", "silent"]), st.integers(0, 2)), max_size=30))
def test_a_tab_that_comes_back_has_its_place_though_others_wait(most: int, outages: list[tuple[int, str, int]]) -> None:
    """Whatever ended its connection, and also where the server has not noticed yet; and no place is counted twice."""
    crowd = Crowd(most)
    for k in range(most):
        crowd.come(k % WORKERS, str(k))
    for which, outage, worker in outages:
        key = list(crowd.inside)[which % most]
        old, _, place = crowd.inside[key]
        lost = {key: crowd.inside[key]}
        if outage == "broke":
            crowd.go(key, broke=True)
        elif outage == "dead worker":
            crowd.table.keep_for(old)
            lost = {key: held for key, held in crowd.inside.items() if held[0] == old}
        assert crowd.come(0, "newcomer") is None
        crowd.now += 1.0
        for each, (_, where, _) in lost.items():
            again = crowd.come(worker, where, crowd.table.key_of(crowd.table.ticket(each)))
            assert again is not None and again.key == each
        if outage == "silent":
            assert crowd.table.overtaken(old, place) and not crowd.table.overtaken(worker, crowd.inside[key][2])
            crowd.table.leave(old, place, False)
        assert len(crowd.inside) == most == len(set(crowd.table._taken()[:, 0]))


def test_a_place_is_kept_for_a_while_and_then_given_to_another() -> None:
    crowd = Crowd(1)
    place = crowd.come(0, "one")
    assert place is not None
    crowd.go(place.key, broke=True)
    crowd.now += HOLD_S - 1.0
    assert crowd.table.kept == 1 and crowd.come(1, "two") is None
    crowd.now += 2.0
    assert crowd.table.kept == 0 and crowd.come(1, "two") is not None
    assert crowd.come(2, "one", place.key) is not None, "one of the spare places"


@given(st.text(max_size=80))
def test_a_ticket_of_this_server_alone_has_a_key(words: str) -> None:
    table, other = PlaceTable(1, 3), PlaceTable(1, 3)
    key = table.draw_key()
    ticket = table.ticket(key)
    assert table.key_of(ticket) == key and other.key_of(ticket) == table.key_of(words) == table.key_of(ticket + "0") == 0
    assert table.key_of(f"{key ^ 1:014x}{ticket[14:]}") == 0
