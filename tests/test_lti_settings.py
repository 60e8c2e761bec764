"""The file of platforms: what is in it is read, what is wrong is one sentence that says where."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from lti_platform import LearningBrowser, LearningPlatform, key_set, page_of, pem
from served import Served

from observer_lab.cli import main
from observer_lab.page.lti.keys import ToolKeys
from observer_lab.page.lti.settings import LtiFileError, is_web_address, read_settings

FILE = """
address = "https://lab.example.edu/labs/"
key-file = "lab.pem"

[[platforms]]
issuer = "https://moodle.example.edu"
client-id = "one"
login = "https://moodle.example.edu/mod/lti/auth.php"
token = "https://moodle.example.edu/mod/lti/token.php"
key-set = "https://moodle.example.edu/mod/lti/certs.php"
deployments = ["1", "2"]

[[platforms]]
issuer = "https://canvas.instructure.com"
client-id = "two"
login = "https://canvas.example.edu/api/lti/authorize_redirect"
token = "https://canvas.example.edu/login/oauth2/token"
key-set-file = "canvas.json"
deployments = ["3"]
audience = "https://canvas.example.edu"
"""
FILES = {"lab.pem": pem("lab"), "canvas.json": json.dumps(key_set())}


def test_what_a_file_says_is_read_and_the_rest_is_unknown() -> None:
    settings = read_settings(FILE, FILES.__getitem__)
    one, two = settings.platforms
    assert settings.platform("https://moodle.example.edu", None) is one and settings.platform("https://moodle.example.edu", "one") is one
    assert settings.platform("https://moodle.example.edu", "two") is None and settings.platform("https://evil.example", None) is None
    assert one.audience == one.token and two.audience == "https://canvas.example.edu" and two.keys == key_set()
    assert pem("lab").splitlines()[1] not in repr(settings)


@pytest.mark.parametrize(("old", "new", "words"), [
    ('client-id = "one"', "", "platform 1, client-id must be a text of 1 to 255 characters"),
    ('deployments = ["3"]', "", 'platform 2, deployments must be a list of texts, as in ["1"]'),
    ('deployments = ["3"]', "deployments = [3]", 'platform 2, deployments must be a list of texts, as in ["1"]'),
    ("https://moodle.example.edu/mod/lti/token.php", "http://moodle.example.edu/token",
     "platform 1, token must be an address that begins with https://, or one of this machine"),
    ("https://lab.example.edu/labs/", "lab.example.edu", "address must be an address that begins with https://, or one of this machine"),
    ('key-set-file = "canvas.json"', "", "platform 2, key-set or key-set-file must be given, one of the two"),
    ("canvas.json", "lab.pem", 'platform 2, key-set-file must hold a key set, {"keys": [...]}'),
    ('audience = "', 'audiense = "', "platform 2, audiense is no key of this file; use issuer, client-id, login, token, key-set, "
                                     "key-set-file, deployments, audience"),
    ("[[platforms]]", "[[platform]]", "platform is no key of this file; use address, key-file, platforms"),
    ('"https://canvas.instructure.com"\nclient-id = "two"', '"https://moodle.example.edu"\nclient-id = "one"',
     "platforms names the same issuer and client-id twice"),
], ids=["no client", "no deployments", "a number", "in the clear", "no scheme", "no keys", "keys that are none", "misspelt", "no platforms",
        "twice"])
def test_a_wrong_file_is_one_sentence_that_says_where(old: str, new: str, words: str) -> None:
    assert old in FILE
    with pytest.raises(LtiFileError) as refused:
        read_settings(FILE.replace(old, new), FILES.__getitem__)
    assert str(refused.value) == words


@pytest.mark.parametrize("address", ["", "https://", "http://lms.example/", "ftp://lms.example/", "https://a b/", "https://a/'", 'https://a/"',
                                     "https://a/;script-src *", "https://a/\n", "https://[::1", "javascript:alert(1)", 5, None,
                                     "https://a/" + "x" * 500])
def test_what_is_no_address_over_tls_is_none(address: object) -> None:
    assert not is_web_address(address)


@pytest.mark.parametrize("address", ["https://lms.example/a?b=c&d=e", "http://localhost:80/a", "http://127.0.0.1:5/", "https://[2001:db8::1]/x"])
def test_addresses_over_tls_and_of_this_machine_are_taken(address: str) -> None:
    assert is_web_address(address)


def test_a_key_must_be_long_and_of_rsa() -> None:
    from cryptography.hazmat.primitives.asymmetric import ec, rsa
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

    def written(key: rsa.RSAPrivateKey | ec.EllipticCurvePrivateKey) -> str:
        return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()).decode()
    for words in ("", "no key", written(rsa.generate_private_key(65537, 1024)), written(ec.generate_private_key(ec.SECP256R1()))):
        with pytest.raises(ValueError, match="it holds no "):
            ToolKeys(words)
    keys = ToolKeys(pem("lab"))
    sealed = keys.seal({"user": "somebody"})
    assert keys.opened(sealed, 60) == {"user": "somebody"} and "somebody" not in sealed
    assert ToolKeys(pem("other")).opened(sealed, 60) is None and keys.opened(sealed[:-4] + "AAAA", 60) is None


def test_serve_says_in_one_sentence_what_is_wrong_with_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "platforms.toml"
    for words, said in (("nonsense", "cannot be used: it is not valid TOML"), (FILE, "cannot be read")):
        file.write_text(words, encoding="utf-8")
        assert main(["serve", "--lti", str(file)]) == 2
        error = capsys.readouterr().err
        assert said in error and len(error.strip().splitlines()) == 1
    (tmp_path / "lab.pem").write_text("no key", encoding="utf-8")
    (tmp_path / "canvas.json").write_text(FILES["canvas.json"], encoding="utf-8")
    assert main(["serve", "--port", "0", "--lti", str(file)]) == 2 and "openssl genrsa" in capsys.readouterr().err
    assert main(["serve", "--room", "--lti", str(file)]) == 2 and "without --room" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_served_lab_asks_for_a_word_and_a_launch_brings_it(tmp_path: Path, workers: str) -> None:
    """The command itself; with two workers each may get one half of a launch."""
    platform = LearningPlatform()
    (tmp_path / "lab.pem").write_text(pem("lab"), encoding="utf-8")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    lab = f"http://127.0.0.1:{port}"
    (tmp_path / "platforms.toml").write_text(platform.toml(lab), encoding="utf-8")
    command = [sys.executable, "-m", "observer_lab", "serve", "--port", str(port), "--exact-port", "--workers", workers, "--lti",
               "platforms.toml", "--data-dir", "kept"]
    environment = {key: value for key, value in os.environ.items() if key != "OBSERVER_LAB_TOKEN"}
    with Served(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        try:
            assert server.stdout is not None
            assert "?token=" in next(line for line in server.stdout if line.startswith("http://"))
            platform.trust(lab)
            for _ in range(4):
                browser = LearningBrowser(lab)
                assert browser.ask("/").status == 401
                answer = platform.launch(browser, "kalman")
                assert answer.status == 303, answer.text
                assert browser.ask("/" + page_of(browser, answer).removeprefix(f"{lab}/")).status == 200
        finally:
            server.send_signal(signal.SIGINT)
            assert server.wait(30) == 0
            platform.close()
    assert (tmp_path / "kept" / "course.sqlite").is_file()
