"""The API pages of the engine: built by the command that CONTRIBUTING names, without a warning, with every public name."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import observer_lab.engine as engine

ROOT = Path(__file__).resolve().parents[2]
COMMAND = ".ci/api-pages"


@pytest.mark.slow
def test_the_api_pages_have_every_name_and_cause_no_warning(tmp_path: Path) -> None:
    assert f"bash {COMMAND}" in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    built = subprocess.run(["bash", ROOT / COMMAND, tmp_path], env=environment, capture_output=True, text=True, check=False)
    assert built.returncode == 0 and "Warn" not in built.stderr, built.stderr[-2000:]
    page = (tmp_path / "observer_lab" / "engine.html").read_text(encoding="utf-8")
    assert [name for name in engine.__all__ if f'id="{name}"' not in page] == []
    rooms = [name for name in engine._ROOMS if not (tmp_path / "observer_lab" / "engine" / f"{name}.html").is_file()]
    assert rooms == [], "a room without a page: add it to .ci/api-pages"
