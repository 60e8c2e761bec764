"""What a person gets who installs the lab: the wheel and its data, in an environment that holds nothing else."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tomllib
import urllib.request
import zipfile
from concurrent.futures import ThreadPoolExecutor
from email import message_from_bytes
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from sampling import some, whole
from served import Served
from syntax import PACKAGES

from observer_lab.lessons import OPENING

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PYTHONS = [version.rpartition(" ")[2] for version in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", version)]
OTHERS = [version for version in PYTHONS if version != f"{sys.version_info.major}.{sys.version_info.minor}"]
WHERE = """
import observer_lab
from observer_lab import lessons
print(observer_lab.__path__[0], lessons.__path__[0])
"""
LAUNCHED = """
from importlib.metadata import entry_points
from pathlib import Path
(entry,) = entry_points(group="jupyter_serverproxy_servers", name="observer-lab")
print(Path(entry.load()()["launcher_entry"]["icon_path"]).read_text())
"""
pytestmark = pytest.mark.slow  # minutes: everything is installed anew


def told(*words: str | Path, cwd: Path) -> str:
    """What a command prints that ends well, far from the repository and from what its environment says to Python."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "VIRTUAL_ENV"))}
    done = subprocess.run(list(map(str, words)), cwd=cwd, env=environment, capture_output=True, text=True, timeout=900,
                          check=False)
    assert done.returncode == 0, f"{words}: {done.stdout[-2000:]} {done.stderr[-4000:]}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy: building leaves its traces beside the sources."""
    place = tmp_path_factory.mktemp("wheel")
    source = place / "source"
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=ROOT, capture_output=True,
                            text=True, check=True)
    for name in filter(None, listed.stdout.split("\0")):
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, source / name)
    told(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", place, source, cwd=place)
    return next(place.glob("*.whl"))


def needed(wheel: Path) -> set[str]:
    """The distributions that a wheel needs, and those that these need, by the names that pip gives them; without extras."""
    with zipfile.ZipFile(wheel) as packed:
        (metadata,) = (name for name in packed.namelist() if name.endswith(".dist-info/METADATA"))
        left = message_from_bytes(packed.read(metadata)).get_all("Requires-Dist") or []
    found = set[str]()
    while left:
        need = Requirement(left.pop())
        if (need.marker is None or need.marker.evaluate({"extra": ""})) and canonicalize_name(need.name) not in found:
            found.add(canonicalize_name(need.name))
            left += distribution(need.name).requires or ()
    return found


def link(name: str, place: Path) -> None:
    """Show a distribution of this environment in another one's packages, its folders and modules alone."""
    found = distribution(name)
    tops = {file.parts[0] for file in found.files or () if file.parts[0] not in ("..", "__pycache__") and not file.is_absolute()}
    assert tops, f"{name} names no files"
    for top in tops:
        if not (place / top).exists():
            (place / top).symlink_to(Path(str(found.locate_file(top))))


@pytest.fixture(scope="module")
def bin(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The commands of an environment that holds only the wheel and what it needs: by `--whole` pip installs all of it.

    To unpack what it needs takes a minute; the suite links it from the environment in which it runs.
    """
    place = tmp_path_factory.mktemp("environment")
    told(sys.executable, "-m", "venv", "--without-pip", place / "venv", cwd=place)
    python = place / "venv" / "bin" / "python"
    told(sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-compile", *(() if whole() else ("--no-deps",)), wheel,
         cwd=place)
    if not whole():
        packages = Path(told(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=place).strip())
        for name in needed(wheel):
            link(name, packages)
    return place / "venv" / "bin"


def test_the_wheel_holds_our_packages_with_their_data_and_nothing_else(wheel: Path) -> None:
    names = [Path(name) for name in zipfile.ZipFile(wheel).namelist()]
    assert {name.parts[0] for name in names if not name.parts[0].endswith(".dist-info")} == {"observer_lab"}, "one import name"
    ours = {Path(*package) / path.relative_to(ROOT / folder) for folder, package in PACKAGES.items() for path in (ROOT / folder).rglob("*")
            if path.is_file() and "__pycache__" not in path.parts}
    assert ours <= set(names), f"not in the wheel: {sorted(map(str, ours - set(names)))}"


def test_every_command_runs_where_nothing_but_the_wheel_is_installed(bin: Path, tmp_path: Path) -> None:
    lab = bin / "observer-lab"
    where = told(bin / "python", "-c", WHERE, cwd=tmp_path)
    assert all(Path(path).is_relative_to(bin.parent) for path in where.split())
    assert f". {OPENING}: " in told(lab, "list", cwd=tmp_path)
    record = json.loads(told(lab, "run", "duality", "--json", "--plant", "motor", "--figure", "page.png", "--csv",
                             "data.csv", cwd=tmp_path))
    assert record["lesson"] == "duality" and (tmp_path / "page.png").stat().st_size > 5000
    assert (tmp_path / "data.csv").read_text(encoding="utf-8").startswith("# Observer Lab, state ")
    assert "agrees" in told(lab, "verify", cwd=tmp_path)
    assert "<svg" in told(bin / "python", "-c", LAUNCHED, cwd=tmp_path), "what a JupyterHub finds"


def test_the_page_is_served_where_nothing_but_the_wheel_is_installed(bin: Path, tmp_path: Path) -> None:
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    with Served([bin / "observer-lab", "serve", "--port", "0"], cwd=tmp_path, stdout=subprocess.PIPE, text=True,
                env=environment) as server:
        try:
            assert server.stdout is not None
            address = server.stdout.readline().strip()
            with urllib.request.urlopen(address, timeout=60) as page:
                assert page.status == 200 and b"observer lab" in page.read().lower()
            assert f"Observer Lab {PROJECT['version']}: 0 of 200 tabs" in told(bin / "observer-lab", "status", address, cwd=tmp_path)
        finally:
            server.send_signal(signal.SIGTERM)
            assert server.wait(60) == 0


def test_what_the_lab_needs_exists_for_every_python_it_names(tmp_path: Path) -> None:
    """Resolved only, from wheels alone: a machine has one Python."""
    def missing(version: str) -> set[str]:
        report = tmp_path / f"{version}.json"
        told(sys.executable, "-m", "pip", "install", "--quiet", "--dry-run", "--ignore-installed", "--target",
             tmp_path / f"nowhere-{version}", "--only-binary=:all:", "--python-version", version, "--report", report,
             *PROJECT["dependencies"], cwd=tmp_path)
        found = {entry["metadata"]["name"].lower() for entry in json.loads(report.read_text(encoding="utf-8"))["install"]}
        return {re.split(r"[<>=!~ \[]", need)[0].lower() for need in PROJECT["dependencies"]} - found
    others = some("every python", OTHERS, 3)
    with ThreadPoolExecutor() as pool:  # each waits for the index most of its time
        assert dict(zip(others, pool.map(missing, others), strict=True)) == {version: set() for version in others}


@pytest.mark.parametrize("command", [
    ("-m", "observer_lab", "list"),
    ("-m", "observer_lab", "export", "separation", "--to", "engine-notebook", "-o", "n.ipynb")])
def test_files_named_like_our_folders_break_nothing(bin: Path, tmp_path: Path, command: tuple[str, ...]) -> None:
    """A person may keep files app.py and lessons.py where the lab is started."""
    for name in ("app.py", "lessons.py"):
        (tmp_path / name).write_text("raise SystemExit('this is the file of the person')\n")
    told(bin / "python", *command, cwd=tmp_path)
    told(bin / "observer-lab", "list", cwd=tmp_path)
    if (tmp_path / "n.ipynb").exists():
        cells = json.loads((tmp_path / "n.ipynb").read_text("utf-8"))["cells"]
        told(bin / "python", "-c", "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"), cwd=tmp_path)
