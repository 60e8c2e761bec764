"""A server that is killed in the middle of a vote: soon back, with every vote that it had acknowledged."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from client import WireTab
from redis_server import free_port
from served import Served

from observer_lab.classroom.kept_room import Place, open_room

ROOT = Path(__file__).parents[2]
BACK_S = 10.0  # s of a quiet machine, or of the processor on one that others use, until votes are taken again
VOTES, ENOUGH = 100, 20  # votes that are sent, and acknowledgements after which the server is killed
TICK = os.sysconf("SC_CLK_TCK")


@contextmanager
def serving(place: Place, port: int) -> Iterator[tuple[Served, str]]:
    kept = ("--data-dir", str(place)) if isinstance(place, Path) else ("--room-store", place)
    command = [sys.executable, "-m", "observer_lab", "serve", "--port", str(port), "--exact-port", "--room", *kept]
    env = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with Served(command, cwd=ROOT, env=env, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        assert server.stdout is not None
        yield server, server.stdout.readline().strip()
        server.kill()


class Voter:
    """A follower's connection that votes with ballots of its own."""

    def __init__(self, tab: WireTab, vote: int) -> None:
        self.tab, self._vote = tab, vote
        tab.until(lambda: any("// room.js" in m.get("source", "") for m in tab.messages), "the follower's page")
        found = re.search(r'"hand": "([^"]+)"', next(m["source"] for m in tab.messages if "// room.js" in m.get("source", "")))
        assert found is not None
        self._hand = found[1]

    def say(self, ballot: int) -> None:
        self.tab.send("GuiUpdateMessage", uuid=self._hand, updates={"value": f"vote:{self._vote}:{ballot % 3}:ballot{ballot:04d}"})

    @property
    def acknowledged(self) -> int:
        return sum("is counted" in note for note in self.tab.notes)


def processor_seconds(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICK


def test_a_server_that_is_killed_while_a_class_votes_is_soon_back_and_has_every_vote_that_it_acknowledged(place: Place) -> None:
    port = free_port()
    with serving(place, port) as (server, address):
        store = open_room(place)
        store.open_vote("separation", "predict", 3)
        vote = store.votes()[-1].number
        voter = Voter(WireTab(address), vote)
        for ballot in range(VOTES):
            voter.say(ballot)
        voter.tab.until(lambda: voter.acknowledged >= ENOUGH, "the first votes")
        acknowledged = voter.acknowledged
        server.kill()
        server.wait(30)
    begun = time.monotonic()
    with serving(place, port) as (server, again):
        assert again == address, "the pages find it where it was"
        kept = store.votes()[-1]
        assert kept.open and acknowledged <= kept.total <= VOTES
        with WireTab(again) as tab:
            voter = Voter(tab, vote)
            voter.say(VOTES)
            tab.until(lambda: voter.acknowledged == 1, "a vote that is counted again")
            assert min(time.monotonic() - begun, processor_seconds(server.pid)) <= BACK_S
        assert store.votes()[-1].total == kept.total + 1
    store.close()
