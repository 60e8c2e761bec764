"""What a person gives never ends in a traceback, and what is printed fits any encoding and any full disk."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from laws import each
from refusals import fault

from observer_lab.cli.commands import status
from observer_lab.cli.entry import main

HERE = Path(__file__).resolve().parents[1]


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_odd_plants_and_knobs_are_one_sentence(part: int, tmp_path: Path) -> None:
    """Eight of the law's command lines; `python tests/refusals.py 500` tries more."""
    assert not [said for seed in range(8 * part, 8 * part + 8) if (said := fault(seed, tmp_path))]


@each(("words", "says"), [
    (["run", "robust-observer", "--set", "pole=0.5"], "left half plane"),
    (["run", "separation", "--set", "none=1"], "has no knob none"),
    (["export", "duality", "--to", "json", "--plant", "none.json"], "cannot be read"),
])
def test_errors_of_lessons_are_one_sentence_and_status_2(words: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1 and "Traceback" not in said


@pytest.mark.slow
def test_informative_checks_are_no_failures(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "bilinear-observer", "--json"]) == 0
    checks = json.loads(capsys.readouterr().out)["checks"]
    assert [check for check in checks if check["informative"] and not check["holds"]]


SAID = """
import sys
from observer_lab.cli import main
for words in (["list"], ["teach", "separation", "--lang", "zh"], ["list", "--json"]):
    assert main(words) == 0
    sys.stdout.flush()
    sys.stdout.buffer.write(b"\\0")
"""  # in one process: to start it costs more than all three


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["cp1252", "gbk", "cp437", "latin-1", "ascii"])
def test_output_fits_any_encoding(encoding: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = subprocess.run([sys.executable, "-c", SAID], cwd=HERE, capture_output=True, check=False, timeout=300,
                           env={**os.environ, "PYTHONIOENCODING": encoding})
    assert found.returncode == 0 and not found.stderr
    *told, exact, end = found.stdout.split(b"\0")
    assert len(told) == 2 and all(told) and not end
    assert main(["list", "--json"]) == 0
    assert json.loads(exact.decode(encoding)) == json.loads(capsys.readouterr().out)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the device that is always full is one of Linux")
def test_a_full_disk_is_one_sentence() -> None:
    with open("/dev/full", "wb") as full:
        found = subprocess.run([sys.executable, "-m", "observer_lab", "list"], cwd=HERE, stdout=full, stderr=subprocess.PIPE, check=False,
                               timeout=300)
    assert found.returncode == 2 and found.stderr.count(b"\n") == 1 and b"Traceback" not in found.stderr


@each(("url", "through"), [("http://127.0.0.1:8080", False), ("http://localhost:8080", False), ("http://[::1]:8080", False),
                           ("http://127.9.0.1", False), ("http://lab.example", True), ("http://192.0.2.1:8080", True)])
def test_status_asks_this_machine_without_a_proxy(url: str, through: bool) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("http_proxy", "http://192.0.2.9:3128")
        patch.delenv("no_proxy", raising=False)
        handlers = status._opener(url).handlers  # type: ignore[attr-defined]
    assert any(getattr(handler, "proxies", None) for handler in handlers) == through
