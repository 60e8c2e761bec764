"""The gate by itself: which Host and which Origin may speak to a server, on loopback, in public and behind a proxy."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from laws import each

from observer_lab.page.access.access_policy import AccessPolicy, content_policy

LOCAL, PUBLIC = AccessPolicy.of("127.0.0.1", False), AccessPolicy.of("192.0.2.7", True)
PROXIED = AccessPolicy.of("127.0.0.1", False, ("lab.example", "lab.example:8443", "10.1.2.3"))


class Head(dict[str, list[str]]):
    """The head of a request, as a table."""

    def get_all(self, key: str) -> list[str]:
        return self.get(key, [])


def page(host: str) -> Head:
    return Head(Host=[host])


def socket_of(host: str, *origins: str) -> Head:
    return Head(Host=[host], Origin=list(origins), Upgrade=["websocket"])


def status(gate: AccessPolicy, head: Head) -> int:
    """What a request is answered with; 200 when it passes."""
    refusal = gate.refusal(head)
    return 200 if refusal is None else refusal.status


@each("host", ["127.0.0.1:8080", "127.0.0.1", "localhost:1", "LOCALHOST.:8080", "[::1]:8080", "127.9.9.9:80"])
def test_every_name_of_loopback_is_answered(host: str) -> None:
    assert status(LOCAL, page(host)) == status(LOCAL, socket_of(host)) == 200
    assert status(LOCAL, socket_of(host, f"http://{host}")) == 200


@each("host", ["evil.example", "evil.example:8080", "localhost.evil.example", "127.0.0.1.evil.example:8080",
               "192.0.2.7:8080", "0.0.0.0:8080", "[2001:db8::1]:8080", "lab.example"])
def test_a_name_that_was_made_to_point_here_is_refused(host: str) -> None:
    """DNS rebinding: the page of the other site calls us by that site's name."""
    assert status(LOCAL, page(host)) == status(LOCAL, socket_of(host, f"http://{host}")) == 403


@each("host", ["", "a b", "a/b", "a@127.0.0.1", "127.0.0.1:", "127.0.0.1:x", "[::1", "é.example", "a,b",
               "127.0.0.1\r\nX: 1", "127.0.0.1:8080 ", ":8080", "'none'; script-src *"])
def test_what_is_no_host_is_refused(host: str) -> None:
    for gate in (LOCAL, PUBLIC, PROXIED):
        assert status(gate, page(host)) in (400, 403)


@each("field", ["Host", "Origin", "Upgrade"])
def test_a_doubled_field_is_refused(field: str) -> None:
    head = socket_of("127.0.0.1:8080", "http://127.0.0.1:8080")
    assert status(LOCAL, head) == 200
    head[field] = head[field] * 2
    assert status(LOCAL, head) == 400


def test_a_request_without_a_host_is_refused() -> None:
    assert status(LOCAL, Head()) == 400


@each("origin", ["http://evil.example", "https://evil.example:8080", "http://127.0.0.1:1", "null", "",
                 "file://", "http://127.0.0.1", "http://localhost:8080", "ftp://127.0.0.1:8080",
                 "http://[::1", "http://127.0.0.1:8080@evil.example", "http://127.0.0.1:8080.evil.example"])
def test_a_page_of_another_site_is_refused(origin: str) -> None:
    """A sandboxed frame of any site has the origin "null"; another port of this machine is another site."""
    assert status(LOCAL, socket_of("127.0.0.1:8080", origin)) == 403


def test_the_origin_matters_for_connections_only() -> None:
    """A link from anywhere may open the page: it can read nothing of it."""
    assert status(LOCAL, Head(Host=["127.0.0.1:8080"], Origin=["http://evil.example"])) == 200


@each(("host", "origin"), [("lab.example", "https://lab.example"), ("lab.example:443", "https://lab.example"),
                           ("127.0.0.1:8080", "https://lab.example"), ("10.1.2.3", "http://10.1.2.3"),
                           ("localhost:8080", "https://LAB.example:8443")])
def test_a_proxy_that_was_named_may_keep_or_change_the_host(host: str, origin: str) -> None:
    assert status(PROXIED, socket_of(host, origin)) == 200
    assert status(PROXIED, socket_of(host, origin.lower().replace("lab", "lob").replace("10.1", "10.2"))) == 403


def test_a_public_server_answers_to_addresses_but_not_to_names_of_others() -> None:
    for host in ("192.0.2.7:8080", "198.51.100.1", "[2001:db8::1]:80", "localhost:8080"):
        assert status(PUBLIC, socket_of(host, f"http://{host}")) == 200
    assert status(PUBLIC, page("evil.example:8080")) == 403


@each("name", ["", "http://lab.example", "lab.example:", "a b", "*"])
def test_what_is_no_name_cannot_be_allowed(name: str) -> None:
    with pytest.raises(ValueError, match="name"):
        AccessPolicy.of("127.0.0.1", False, (name,))


PIECES = st.lists(st.sampled_from(["127.0.0.1", "localhost", "evil.example", "[::1]", ":8080", ":80", ".", "@", " ", "'", ";", "/"]),
                  max_size=4).map("".join)


@example("127.0.0.1", "127.0.0.1/")  # an origin has no path
@given(PIECES, PIECES)
def test_whatever_passes_comes_from_loopback_under_its_own_name(host: str, origin: str) -> None:
    """And the policy that the page is given then holds that name and no other word."""
    if status(LOCAL, socket_of(host, f"http://{origin}")) == 200:
        assert host.split(":8")[0].rstrip(".") in ("127.0.0.1", "localhost", "[::1]")
        assert origin.removesuffix(":80").rstrip(".") == host.removesuffix(":80").rstrip(".")
        assert not set(host) & set(" ;,'\"/@")
    assert f" ws://{host} " in content_policy(host)


@each(("gate", "came_by", "answer"), [
    (LOCAL, "http://127.0.0.1:8080", 200), (LOCAL, "https://lab.example", 421), (LOCAL, "null", 421),
    (PROXIED, "https://lab.example", 200), (PROXIED, "https://other.example", 421)])
def test_a_page_behind_a_proxy_that_rewrites_host_learns_whether_its_name_is_known(gate: AccessPolicy, came_by: str, answer: int) -> None:
    """The page asks by itself: a plain request has no Origin, and its Host is the proxy's."""
    head = Head({"Host": ["127.0.0.1:8080"], "Came-By": [came_by]})
    assert status(gate, head) == answer
    assert answer == 200 or "--allow-host" in gate.refusal(head).words  # type: ignore[union-attr]


PORTED = AccessPolicy.of("127.0.0.1", False, ("lab.example", "other.example:8443", "[2001:db8::1]:8443", "2001:db8::2"))


@each(("origin", "answer"), [
    ("https://lab.example", 200), ("http://lab.example", 200), ("https://lab.example:443", 200), ("http://lab.example:80", 200),
    ("https://lab.example:8443", 403), ("http://lab.example:8080", 403), ("http://lab.example:443", 403),
    ("https://other.example:8443", 200), ("https://other.example", 403), ("https://other.example:9443", 403),
    ("https://[2001:db8::1]:8443", 200), ("https://[2001:db8::1]", 403), ("https://[2001:db8::2]", 200)])
def test_a_given_name_passes_on_its_own_port_alone(origin: str, answer: int) -> None:
    """Another port of the same machine is another site: whoever may serve there is not us."""
    assert status(PORTED, socket_of("127.0.0.1:8080", origin)) == answer
    assert status(PORTED, page(origin.partition("//")[2])) == 200, "Host may have any port: no page sets it"
