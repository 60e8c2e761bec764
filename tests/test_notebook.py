"""A lesson in a notebook: the kernel serves it to that notebook alone, and stores no word."""

from __future__ import annotations

import http.client
import json
import os
import subprocess
import sys
from urllib.parse import urlsplit

import pytest
from client import WireTab
from served import Served

from observer_lab.lessons import LESSONS
from observer_lab.notebook import Lab
from observer_lab.session.state.token import read_token

ORIGIN = "http://localhost:8888"
SCRIPT = """
from observer_lab.notebook import Lab
print(Lab("kalman").address_for("http://localhost:8888"), flush=True)
input()
"""


def asked(address: str, cookie: str = "") -> http.client.HTTPResponse:
    """The answer to a plain request."""
    place = urlsplit(address)
    connection = http.client.HTTPConnection("127.0.0.1", place.port, timeout=20)
    connection.request("GET", f"{place.path}?{place.query}", headers={"Host": place.netloc, **({"Cookie": cookie} if cookie else {})})
    return connection.getresponse()


@pytest.mark.slow
def test_the_page_answers_to_its_word_and_stands_in_that_notebook_alone() -> None:
    lab = Lab("kalman")
    address = lab.address_for(ORIGIN)
    place = urlsplit(address)
    assert place.hostname == "localhost", "the same site as the notebook"
    state = read_token(place.fragment, LESSONS)
    assert (state.design.lesson, state.mode) == ("kalman", "guide")
    first = asked(address)
    cookie = (first.getheader("Set-Cookie") or "").partition(";")[0]
    assert first.status == 303 and "token" not in (first.getheader("Location") or "")
    assert asked(address.partition("?")[0]).status == 401
    page = asked(address.partition("?")[0], cookie)
    policy = page.getheader("Content-Security-Policy") or ""
    assert page.status == 200 and policy.endswith(f"frame-ancestors {ORIGIN}") and page.getheader("X-Frame-Options") is None
    with WireTab(f"http://{place.netloc}", origin=f"http://{place.netloc}", cookies=cookie) as tab:
        tab.settle()
    assert Lab("separation", "stage").address_for(ORIGIN).partition("/?")[0] == address.partition("/?")[0]
    other = Lab("kalman").address_for("http://localhost:9999")
    assert urlsplit(other).port != place.port, "another notebook has a server of its own"


def test_the_views_and_another_lab() -> None:
    address = Lab("kalman", "stage", address="https://lab.example.org/").address_for(ORIGIN)
    assert address.startswith("https://lab.example.org/?view=stage#") and read_token(address, LESSONS).mode == "lab"
    assert Lab("kalman", "lab", address="https://lab.example.org/?a=b").address_for(ORIGIN).startswith("https://lab.example.org/?a=b#")


@pytest.mark.slow
def test_the_page_asks_for_the_address_and_what_is_stored_holds_no_word(monkeypatch: pytest.MonkeyPatch) -> None:
    lab = Lab("kalman", width="800px", height=480)
    sent: list[dict[str, str]] = []
    monkeypatch.setattr(lab, "send", lambda content, buffers=None: sent.append(content))
    lab._handle_custom_msg({"origin": ORIGIN}, [])
    assert sent == [{"address": lab.address_for(ORIGIN)}]
    word = urlsplit(sent[0]["address"]).query.removeprefix("token=")
    kept = json.dumps({name: value for name, value in lab.get_state().items() if isinstance(value, (str, int, float))})
    assert len(word) >= 32 and word not in kept and "kalman" not in word
    assert (lab.width, lab.height, lab.title) == ("800px", 480, LESSONS["kalman"].words["en"].title)


@pytest.mark.parametrize("content", [{"origin": "https://evil.example/ 'unsafe-inline'"}, {"origin": "*"}, {"origin": "null"}, {}, None, 5,
                                     {"origin": "http://localhost:8888; script-src *"}], ids=range(7))
def test_what_is_no_origin_gets_one_sentence_and_no_server(content: object, monkeypatch: pytest.MonkeyPatch) -> None:
    lab = Lab("kalman")
    sent: list[dict[str, str]] = []
    monkeypatch.setattr(lab, "send", lambda told, buffers=None: sent.append(told))
    lab._handle_custom_msg(content, [])
    assert [set(told) for told in sent] == [{"problem"}] and "is not the origin of a notebook" in sent[0]["problem"]


@pytest.mark.parametrize(("options", "words"), [
    ({"lesson": "none"}, "There is no lesson none"), ({"view": "phone"}, "There is no view phone; use guide, lab, stage."),
    ({"width": "wide"}, "'wide' is not a width"), ({"width": "1px;position:fixed"}, "is not a width"),
    ({"height": 5}, "200 to 4000 pixels"), ({"address": "javascript:alert(1)"}, "is not an address"),
    ({"language": "xx"}, "There is no language xx"),
], ids=range(7))
def test_what_cannot_be_shown_is_said_in_one_sentence(options: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Lab(**{"lesson": "kalman", **options})


@pytest.mark.slow
def test_the_server_ends_with_the_kernel() -> None:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with Served([sys.executable, "-c", SCRIPT], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment) as kernel:
        assert kernel.stdin is not None and kernel.stdout is not None
        address = kernel.stdout.readline().strip()
        assert asked(address).status == 303
        kernel.stdin.write("\n")
        kernel.stdin.flush()
        assert kernel.wait(60) == 0
    with pytest.raises(ConnectionRefusedError):
        asked(address)


def test_code_of_a_design_is_written_from_a_notebook(tmp_path) -> None:
    from observer_lab.notebook import write_device

    assert "lab.c" in write_device("noise", str(tmp_path / "code"), w=0.5)
    assert "with w 0.5" in (tmp_path / "code" / "README.md").read_text()
    with pytest.raises(ValueError, match="There is no kind pascal"):
        write_device("noise", str(tmp_path), "pascal")
