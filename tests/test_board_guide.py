"""The guide "From the page to the board" is followed word for word, as far as no hardware is needed."""

import re
import subprocess
from pathlib import Path

import pytest

from observer_lab.cli import main
from observer_lab.live.lines import LineReader

GUIDE = (Path(__file__).parents[1] / "assets" / "board" / "README.md").read_text(encoding="utf-8")


def commands() -> list[list[str]]:
    """The calls of the program in the guide's blocks."""
    lines = "\n".join(re.findall(r"```sh\n(.*?)```", GUIDE, re.DOTALL)).splitlines()
    return [line.split(" && ")[0].split()[1:] for line in lines if line.startswith("observer-lab")]


@pytest.mark.slow
def test_guide_leads_from_the_page_to_code_and_to_a_live_plant(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rc.json").write_text(re.findall(r"```json\n(.*?)```", GUIDE, re.DOTALL)[0])
    export_c, export_arduino, serial, simulate = commands()
    assert main(export_c) == 0 and main(export_arduino) == 0
    made = subprocess.run(["make", "-C", "rc"], capture_output=True, text=True, check=True)
    assert "every bit as in the lab's Python" in made.stdout
    assert Path("rc-arduino/lab/lab.ino").is_file() and serial[:2] == simulate[:2] == ["live", "virtual-sensor"]
    capsys.readouterr()
    assert main([*simulate[:-1], "1"]) == 0
    assert re.search(r"lines [1-9]\d*; lost periods 0", capsys.readouterr().err)


def test_lines_of_the_guide_are_read() -> None:
    shown = re.findall(r"```\n(# t.*?)```", GUIDE, re.DOTALL)[0]
    reader = LineReader(("source",), ("measured",))
    assert len([*reader.feed(shown.encode())]) == 3 and reader.refused == {}
