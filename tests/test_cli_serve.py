"""The command line as a process: what it loads, how it serves, tells, logs and ends."""

import errno
import io
import json
import logging
import os
import re
import signal
import socket
import subprocess
import sys
import time
import tomllib
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace

import pytest
from client import WireTab, eventually
from commands import refused
from sampling import whole
from served import Served
from websockets.exceptions import InvalidStatus

from observer_lab.classroom.room_store import RoomStore
from observer_lab.cli import jupyter
from observer_lab.cli.commands import serve
from observer_lab.cli.entry import main
from observer_lab.cli.lecture_room import audience_address, own_address, room_told
from observer_lab.cli.logs import RotatingFile
from observer_lab.page.access.addresses import is_reachable, url
from observer_lab.page.access.tokens import VARIABLE

ROOT = Path(__file__).parents[1]

QUIET = """
import os, sys
import observer_lab.cli
assert "numpy" not in sys.modules, "numpy came before its threads were settled"
assert observer_lab.cli.main(["list"]) == 0
assert "observer_lab.lessons" in sys.modules and "scipy.stats" not in sys.modules, "a quarter of the start, for what is seldom asked"
assert observer_lab.cli.main(["run", "separation", "--json"]) in (0, 1)
assert observer_lab.cli.main(["verify"]) == 0
assert os.environ["OMP_NUM_THREADS"] == os.environ["OPENBLAS_NUM_THREADS"] == "1"
heavy = {"viser", "matplotlib", "control"} & set(sys.modules)
assert not heavy, heavy
assert observer_lab.cli.main(["run", "separation", "--figure", sys.argv[1]]) in (0, 1)
assert "matplotlib.pyplot" not in sys.modules
"""


def plain_environment() -> dict[str, str]:
    return {key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")}


@pytest.mark.slow
def test_commands_without_a_browser_load_neither_viser_nor_matplotlib_and_one_thread(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", QUIET, str(tmp_path / "page.png")], cwd=ROOT, env=plain_environment(),
                          capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_serve_prints_the_address_it_really_took_and_ends_when_interrupted() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with Served([sys.executable, "-m", "observer_lab", "--port", str(port), "--token", "auto"], cwd=ROOT,
                    env=plain_environment(), stdout=subprocess.PIPE, text=True) as server:
            try:
                assert server.stdout is not None
                url = next(line.strip() for line in server.stdout if line.startswith("http://"))
                assert f":{port}/" not in url and "/?token=" in url
                with browser().open(url, timeout=20) as page:
                    assert page.status == 200 and b"<html" in page.read().lower() and "token" not in page.url
            finally:
                server.send_signal(signal.SIGINT)
                assert server.wait(30) == 0


def browser() -> urllib.request.OpenerDirector:
    """What follows a redirect with the cookie that it came with, as a browser does."""
    return urllib.request.build_opener(urllib.request.HTTPCookieProcessor())


@contextmanager
def started(*words: str, **surroundings: str) -> Iterator[tuple[Served, str]]:
    """`serve` in a process of its own and the address that it prints; ended by SIGTERM, and well."""
    with Served([sys.executable, "-m", "observer_lab", *words], cwd=ROOT, env=plain_environment() | surroundings,
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            yield server, server.stdout.readline().strip()
        finally:
            server.send_signal(signal.SIGTERM)
            server.told = server.communicate(timeout=30)
        assert server.returncode == 0


@pytest.mark.slow
def test_two_servers_on_one_data_folder_are_refused_and_one_that_was_killed_leaves_it_free(tmp_path: Path) -> None:
    options = ("serve", "--port", "0", "--data-dir", str(tmp_path), "--workers", "2")
    with started(*options) as (first, _):
        second = subprocess.run([sys.executable, "-m", "observer_lab", *options], cwd=ROOT, env=plain_environment(), capture_output=True,
                                text=True, timeout=60)
        assert second.returncode == 2 and "is in use by another server" in second.stderr and second.stderr.count("\n") == 1
        assert first.poll() is None
    with Served([sys.executable, "-m", "observer_lab", *options], cwd=ROOT, env=plain_environment(), stdout=subprocess.PIPE,
                text=True) as one:
        assert one.stdout is not None and one.stdout.readline().startswith("http")
        one.kill()
        one.wait(30)
        with started(*options) as (_, url):
            assert url.startswith("http")


@pytest.mark.slow
def test_a_server_without_a_terminal_goes_on_when_it_is_hung_up() -> None:
    with started("serve", "--port", "0", "--workers", "2") as (server, url):
        workers = Path(f"/proc/{server.pid}/task/{server.pid}/children").read_text().split()
        for process in (server.pid, *map(int, workers)):
            os.kill(process, signal.SIGHUP)
        with WireTab(url) as tab:
            tab.until(tab.mark, "a page after the signal")
        assert Path(f"/proc/{server.pid}/task/{server.pid}/children").read_text().split() == workers


def test_the_last_port_when_taken_is_refused_and_does_not_hang(capsys) -> None:
    with socket.socket() as taken:
        try:
            taken.bind(("127.0.0.1", 65535))
            taken.listen()
        except OSError:
            pass  # somebody else has it: as good
        assert "in use" in refused(capsys, "serve", "--port", "65535")


def test_a_token_that_is_soon_guessed_and_workers_where_there_can_be_none_are_refused(capsys, monkeypatch) -> None:
    assert "8 to 200 letters" in refused(capsys, "serve", "--port", "0", "--token", "guess")
    monkeypatch.setattr(sys, "platform", "darwin")
    assert "leave out --workers" in refused(capsys, "serve", "--port", "0", "--workers", "2")


def test_a_lecture_that_cannot_be_given_is_refused_before_anything_is_served(capsys, tmp_path: Path) -> None:
    (bad := tmp_path / "talk.toml").write_text('title = "a"\n[[stops]]\nlesson = "duality"\nscene = "no"\n', encoding="utf-8")
    assert "duality has no scene no" in refused(capsys, "serve", "--port", "0", "--lecture", str(bad))
    assert "cannot be read" in refused(capsys, "serve", "--port", "0", "--lecture", str(tmp_path / "nowhere.toml"))
    good = str(ROOT / "assets" / "lectures" / "demo-10.toml")
    assert "names its own lessons" in refused(capsys, "serve", "--port", "0", "--lecture", good, "--lesson", "kalman")


@pytest.mark.slow
def test_an_address_that_others_reach_says_what_that_means() -> None:
    with started("--host", "0.0.0.0", "--public", "--port", "0") as (server, url):
        assert re.fullmatch(r"http://localhost:\d+", url)
        assert server.stderr is not None
        told = server.stderr.readline() + server.stderr.readline()
        assert "0.0.0.0 can be reached by other machines" in told and "without a password" in told
        with urllib.request.urlopen(url.replace("localhost", "127.0.0.1"), timeout=20) as page:
            assert page.status == 200


@pytest.mark.slow
def test_status_tells_of_a_server_as_jupyter_launches_it_and_is_status_1_where_there_is_none(capsys, monkeypatch) -> None:
    """jupyter-server-proxy fills in a port that was free, and shows the server's own token in a header."""
    group = "jupyter_serverproxy_servers"
    (entry,) = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["entry-points"][group].values()
    launched = EntryPoint("observer-lab", entry, group).load()()
    assert "svg" in jupyter.ICON.read_text("utf-8") and launched["launcher_entry"]["icon_path"] == str(jupyter.ICON)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    python, apart, *words = (word.format(port=port) for word in launched["command"])
    assert (python, apart, *words[:3]) == (sys.executable, "-P", "-m", "observer_lab", "serve")
    word = launched["environment"][VARIABLE]
    assert launched["request_headers_override"] == {"Authorization": f"Bearer {word}"}
    with started(*words[2:], "--max-sessions", "7", **launched["environment"]) as (_, url):
        assert url == f"http://127.0.0.1:{port}", "a service prints into a log"
        assert main(["status", f"{url}/?token={word}"]) == 0
        assert re.fullmatch(r"Observer Lab \S+: 0 of 7 tabs open, up \d+ s\n", capsys.readouterr().out)
        assert main(["status", url]) == 1
        assert "asks for its access token" in capsys.readouterr().err
        monkeypatch.setenv(VARIABLE, word)
        assert main(["status", url + "/", "--json"]) == 0
        health = json.loads(capsys.readouterr().out)
        assert health["status"] == "ok" and health["tabs"] == 0 and health["most_tabs"] == 7
        assert "in use" in refused(capsys, *words[2:])
    assert main(["status", url]) == 1
    out, err = capsys.readouterr()
    assert out == "" and len(err.splitlines()) == 1 and word not in err
    assert err.startswith(f"observer-lab: no Observer Lab answers at {url} (")


def workers_of(url: str, word: str) -> list[dict[str, int]]:
    """What /health says of each worker."""
    question = urllib.request.Request(f"{url}/health", headers={"Authorization": f"Bearer {word}"})
    with urllib.request.urlopen(question, timeout=20) as answer:
        health = json.loads(answer.read())
    assert health["tabs"] == sum(worker["tabs"] for worker in health["workers"]) <= health["most_tabs"] == 2
    return health["workers"]


@pytest.mark.slow
def test_two_workers_share_the_tabs_and_a_tab_whose_worker_dies_goes_on_at_the_other() -> None:
    """One address, printed once; figures and places are those of both; the word of the token reaches no log."""
    word, knob = "the-word-of-this-test", "stiffness error in the model [%]"
    with started("--port", "0", "--workers", "2", "--max-sessions", "2", "--view", "lab", "--lesson", "separation", "--log-json", **{
            VARIABLE: word, "OBSERVER_LAB_KERNELS": "off"}) as (server, url):
        processes = [int(child) for child in Path(f"/proc/{server.pid}/task/{server.pid}/children").read_text().split()]
        first = WireTab(url, word=word)
        first.update(knob, value=7.0)
        first.settle()
        (home,) = (k for k, worker in enumerate(workers_of(url, word)) if worker["tabs"])
        os.kill(processes[home], signal.SIGKILL)
        assert first.closed() is not None
        again = WireTab(url, word=word, kept=first.kept, path=f"/?place={first.ticket}")
        again.until(lambda: again.has(knob) and again.value(knob) == 7.0, "what the browser kept")
        eventually(lambda: workers_of(url, word)[home]["starts"] == 2 and workers_of(url, word)[home]["stands"], "the next worker")
        assert [worker["tabs"] for worker in workers_of(url, word)] == [int(k != home) for k in range(2)]
        other = WireTab(url, word=word)
        eventually(lambda: sum(worker["tabs"] for worker in workers_of(url, word)) == 2, "the second tab")
        with pytest.raises(InvalidStatus) as full:
            WireTab(url, word=word)
        assert full.value.response.status_code == 503
        server.send_signal(signal.SIGTERM)
        for tab in (again, other):
            tab.until(lambda tab=tab: any("stopped" in note for note in tab.notes), "the last word")
            tab.close()
    printed, told = server.told
    assert "http" not in printed and word not in told + url
    said = [(line.get("worker", 0), line["what"]) for line in map(json.loads, told.splitlines())]
    assert (0, f"serving {url}") in said and {(1, "stopped"), (2, "stopped")} < set(said)
    assert any(worker == 0 and f"worker {home + 1} has ended" in what for worker, what in said)


@pytest.mark.slow
def test_a_worker_that_answers_lives_and_one_that_is_stopped_is_replaced() -> None:
    """An idle worker and a busy one outlive two time limits, five by `--whole`; where one does not answer, its tab goes on at the other."""
    limit, word, knob = 5, "the-word-of-this-test", "stiffness error in the model [%]"
    with started("--port", "0", "--workers", "2", "--max-sessions", "2", "--view", "lab", "--lesson", "separation",
                 "--worker-timeout", str(limit), **{
            VARIABLE: word, "OBSERVER_LAB_KERNELS": "off"}) as (server, url):
        processes = [int(child) for child in Path(f"/proc/{server.pid}/task/{server.pid}/children").read_text().split()]
        busy = WireTab(url, word=word)
        busy.settle()
        (work,) = (k for k, worker in enumerate(workers_of(url, word)) if worker["tabs"])
        idle = WireTab(url, word=word)
        idle.update(knob, value=7.0)
        idle.settle()
        assert [worker["tabs"] for worker in workers_of(url, word)] == [1, 1]
        end, moves = time.monotonic() + (5 if whole() else 2) * limit, 0
        while time.monotonic() < end:
            busy.update(knob, value=float(moves % 10))
            busy.answered()
            idle.pass_time(0.01)
            moves += 1
        assert moves and [worker["starts"] for worker in workers_of(url, word)] == [1, 1], "a worker that answers was replaced"
        os.kill(processes[1 - work], signal.SIGSTOP)
        eventually(lambda: starts(url, word)[1 - work] == 2, "the worker in the place of the stopped one")
        assert idle.closed() is not None
        again = WireTab(url, word=word, kept=idle.kept, path=f"/?place={idle.ticket}")
        again.until(lambda: again.has(knob) and again.value(knob) == 7.0, "what the browser kept")
        busy.answered()
        assert starts(url, word)[work] == 1
        again.close()
        busy.close()


def starts(url: str, word: str) -> list[int]:
    """How many processes each worker has had; asked of any that answers, as one of them may be stopped."""
    question = urllib.request.Request(f"{url}/health", headers={"Authorization": f"Bearer {word}"})
    with suppress(OSError), urllib.request.urlopen(question, timeout=1) as answer:
        return [worker["starts"] for worker in json.loads(answer.read())["workers"]]
    return [0, 0]


@pytest.mark.slow
def test_the_log_is_lines_of_json_on_stderr_and_in_the_data_folder(tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    with started("--port", "0", "--log-json", "--data-dir", str(kept)) as (server, url):
        pass
    written = (kept / "observer-lab.log").read_text(encoding="utf-8")
    assert server.told[1] == written
    records = [json.loads(line) for line in written.splitlines()]
    assert [record["what"] for record in records] == [f"serving {url}", "stopped"]
    assert all(set(record) == {"time", "level", "where", "what"} and record["level"] == "info" for record in records)


def test_a_full_disk_costs_the_log_and_one_sentence_until_there_is_room_again(capsys, tmp_path: Path,
                                                                              monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(io.StringIO):
        def flush(self) -> None:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    log = RotatingFile(tmp_path / "log", encoding="utf-8")
    room = log.stream
    for k in range(8):
        log.stream = room if k % 4 == 3 else Full()
        log.emit(logging.LogRecord("lab", logging.WARNING, "", 0, f"event{k}", (), None))
    with monkeypatch.context() as worse:  # stderr is a file on that disk as well
        worse.setattr(sys, "stderr", Full())
        log.stream = Full()
        log.emit(logging.LogRecord("lab", logging.WARNING, "", 0, "event", (), None))
    log.stream = room
    log.close()
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 2 and all("cannot be written (no space left on device); the server goes on" in line for line in told)
    assert (tmp_path / "log").read_text().split() == ["event3", "event7"]


def test_an_ipv6_address_is_printed_in_brackets() -> None:
    assert url("::1", 8080) == "http://[::1]:8080" and url("127.0.0.1", 1) == "http://127.0.0.1:1"


def test_ctrl_c_while_starting_prints_no_traceback() -> None:
    with Served([sys.executable, "-X", "importtime", "-m", "observer_lab", "--port", "0"], cwd=ROOT,
                env=plain_environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        assert server.stderr is not None
        for line in server.stderr:
            if line.endswith(" numpy\n"):  # from here on the command has begun, and seconds of loading lie ahead
                break
        server.send_signal(signal.SIGINT)
        rest = server.stderr.read()
        assert server.wait(30) in (0, 128 + signal.SIGINT)
    assert "Traceback" not in rest


def test_an_interrupt_while_a_server_prepares_is_remembered_and_ends_it_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """A library that is being loaded may take one for an error of its own: the server then went on for ever. One that comes while
    Python compiles a text, as dataclasses do, became the status of the process, though it was caught."""
    heard: list[str] = []

    class Server:
        def prepare(self) -> None:
            signal.raise_signal(signal.SIGINT)
            heard.append("prepared")

        def wait(self, ended: Callable[[], bool], period: float) -> None:
            heard.append("ended" if ended() else "goes on")
            signal.raise_signal(signal.SIGTERM)  # while all stands nothing is interrupted: Python may print it, and go on
            heard.append("calm")

        def stop(self) -> None:
            heard.append("stopped")

    def begins(_: object, end: serve.Ending) -> None:
        serve._run(Server(), lambda: None, lambda _: None, end)  # type: ignore[arg-type]
    monkeypatch.setattr(serve, "_serve", begins)
    assert serve.serve(SimpleNamespace(data_dir=None)) == 0  # type: ignore[arg-type]
    assert heard == ["prepared", "ended", "calm", "stopped"]


@pytest.mark.slow
def test_serve_room_prints_both_links_and_says_that_no_phone_reaches_loopback(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "observer_lab", "--port", "0", "--room", "--data-dir", str(tmp_path), "--workers", "2"]
    with Served(command, cwd=ROOT, env=plain_environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        told = [server.stdout.readline().rstrip()]
        while not told[-1].startswith("This server listens on this computer alone"):
            told.append(server.stdout.readline().rstrip())
        links = dict(line.split(": ", 1) for line in told if ": http" in line)
        word = links["Presenter's link (keep it secret)"].partition("?present=")[2]
        assert word == RoomStore(tmp_path).secret and links["Audience"] == told[0] + "/" and len(told) > 12, "the code has its lines"
        with WireTab(told[0]) as follower, WireTab(told[0], word=word) as presenter:
            presenter.settle()
            follower.until(lambda: any('<section class="ol-card"' in str(w["props"].get("content")) for w in follower.widgets.values()),
                           "the lecture, from whichever worker")
        server.send_signal(signal.SIGTERM)
        logged = server.communicate(timeout=60)[1]
    assert word not in logged


@pytest.mark.parametrize("at, reachable", [("https://lab.example.org/course", True), ("http://192.168.1.7:8080", True),
                                           ("http://127.0.0.1:8080", False), ("http://localhost", False)])
def test_the_audience_gets_the_address_that_was_given(at: str, reachable: bool) -> None:
    address = audience_address("127.0.0.1", 8080, at)
    assert address == at + "/" and is_reachable(address) is reachable
    assert ("no phone" in room_told("http://x/?present=word", address, True)) is not reachable
    assert "--data-dir" in room_told("http://x/?present=word", address, False)


def test_a_room_on_all_addresses_names_one_that_others_reach() -> None:
    host = audience_address("0.0.0.0", 8080, None)
    assert host == f"http://{own_address('localhost')}:8080/"
    assert audience_address("127.0.0.1", 8080, None) == "http://127.0.0.1:8080/"


def test_an_address_for_a_room_without_a_room_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--room" in refused(capsys, "serve", "--at", "http://lab.example.org/")
    assert "is not an address" in refused(capsys, "serve", "--room", "--at", "lab.example.org")
