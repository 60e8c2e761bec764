"""The house keeps its promises: who may import whom, what is private stays private, nothing mutable is global."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path

import pytest
from syntax import ROOT, Module, arrows, circles, imports, mutable_globals, name_of, parsed, private_uses, within

FOLDERS = {"app", "lessons", "tests", "assets", ".ci"}
ROOM = re.compile(r"│ (\S+) +│(?:──► (.+))?$")


def drawn(page: str) -> dict[str, tuple[str, ...]]:
    """Room → the rooms it may import, as the picture of the house in CONTRIBUTING.md has it; rooms of the engine by
    full name."""
    picture = page.split("```")[1]
    house, _, engine = picture.partition("app.engine, its own rooms")
    found = [(name, arrows) for name, arrows in map(_row, house.splitlines()) if name]
    inner = [(f"app.engine.{name}", tuple(f"app.engine.{other}" for other in arrows))
             for name, arrows in map(_row, engine.splitlines()) if name]
    return dict(found + inner)


def _row(line: str) -> tuple[str, tuple[str, ...]]:
    room = ROOM.match(line.strip())
    return (room[1], tuple((room[2] or "").split())) if room else ("", ())


PICTURE = drawn((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"))
# Layer → the layers it may import. A module belongs to the longest prefix of its name that is listed here.
MAY_IMPORT = {"app": (), **PICTURE, "app.engine": ("app.engine",)}
ENGINE_LIBRARIES = {"numpy", "scipy", "control"}
COMPILER, SHELF = "numba", "app.engine.kernels.shelf"  # imported there alone, when kernels are compiled
ROOMS = ("lesson", "knobs", "study", "figures", "tasks")  # of every lesson, beside job and own where there are such
LONGEST, LONGEST_LESSON = 300, 80  # lines of a module, and of the one that assembles a lesson
# --- reading -------------------------------------------------------------------------------------------------------
def layer_of(name: str) -> str | None:
    """The layer of a module, None if it is not ours."""
    return max((layer for layer in MAY_IMPORT if within(name, layer)), key=len, default=None)


def forbidden_imports(source: str, module: str, package: bool = False) -> list[str]:
    """Imports of ours that the rule does not allow to `module`."""
    layer = layer_of(module)
    assert layer is not None, f"{module} belongs to no layer: add it to the rule"
    out = []
    for name in imports(parsed(source), module, package):
        target = layer_of(name)
        if target is None:
            continue
        if target == layer:
            if layer == "lessons" and not lesson_may(module, name):
                out.append(name)
        elif not any(within(target, allowed) for allowed in MAY_IMPORT[layer]):
            out.append(name)
    return out


def lesson_may(module: str, name: str) -> bool:
    """A lesson knows itself, the toolkit and its place in the course; only the table of contents knows the lessons."""
    own = ".".join(module.split(".")[:2])
    return module == "lessons" or within(name, own) or within(name, "lessons.toolkit") or within(name, "lessons.course")


def tracked() -> list[Path]:
    """The files that git carries and that are there."""
    names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True,
                           check=True).stdout.decode().split("\0")
    return [ROOT / name for name in names if name and (ROOT / name).is_file()]


@lru_cache(maxsize=1)
def every_module() -> tuple[Module, ...]:
    """All Python of app, lessons and tests."""
    paths = sorted(p for folder in ("app", "lessons", "tests") for p in (ROOT / folder).rglob("*.py"))
    return tuple(Module(p, name_of(p), p.read_text(encoding="utf-8")) for p in paths)


def modules(*prefixes: str) -> Iterator[Module]:
    """Those below one of the prefixes."""
    return (m for m in every_module() if any(within(m.name, prefix) for prefix in prefixes))


def violations(found: Iterable[tuple[Module, Iterable[object]]]) -> list[str]:
    """One line for each thing found: where, and what."""
    return [f"{module.path.relative_to(ROOT)}: {thing}" for module, things in found for thing in things]


# --- the rules -----------------------------------------------------------------------------------------------------
def test_there_is_something_to_judge() -> None:
    assert all(any(modules(layer)) for layer in MAY_IMPORT) and any(modules("tests"))


def test_imports_run_one_way_through_the_house() -> None:
    assert violations((m, forbidden_imports(m.source, m.name, m.package)) for m in modules("app", "lessons")) == []


def test_no_modules_import_each_other_in_a_circle() -> None:
    assert circles(arrows(modules("app", "lessons"))) == []


def test_no_module_is_too_long_to_be_read_at_once() -> None:
    lengths = [(m, len(m.source.splitlines())) for m in modules("app", "lessons")]
    assert violations((m, [f"{n} lines"]) for m, n in lengths if n > LONGEST) == []
    assert violations((m, [f"{n} lines"]) for m, n in lengths
                      if re.fullmatch(r"lessons\.\w+\.lesson", m.name) and n > LONGEST_LESSON) == []


def test_every_lesson_has_the_standard_rooms() -> None:
    names = {m.name for m in modules("lessons")}
    homes = {name.removesuffix(".lesson") for name in names if re.fullmatch(r"lessons\.\w+\.lesson", name)}
    assert [f"{home}.{room}" for home in sorted(homes) for room in ROOMS if f"{home}.{room}" not in names] == []


def test_every_arrow_of_the_picture_points_down() -> None:
    rooms = list(PICTURE)
    assert [(room, other) for room, arrows in PICTURE.items() for other in arrows
            if other not in rooms or rooms.index(other) <= rooms.index(room)] == []


def test_the_picture_has_no_arrow_that_no_import_needs() -> None:
    needed = {(layer_of(m.name), layer_of(name)) for m in modules("app", "lessons") for name in m.imports()}
    idle = [f"{room} ──► {other}" for room, arrows in PICTURE.items() for other in arrows
            if not any(layer == room and target is not None and within(target, other) for layer, target in needed)]
    assert not idle, f"rub out of the picture in CONTRIBUTING.md: {idle}"


def test_the_table_of_folders_names_every_room() -> None:
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = set(re.findall(r"^\| `(\S+)` \|", page, re.MULTILINE))
    there = {path.parent.relative_to(ROOT).as_posix() for path in tracked()}
    rooms = {folder if not folder.startswith("app/") else "/".join(folder.split("/")[:2]) for folder in there}
    assert named == {room if room.startswith("app/") else room.split("/")[0] for room in rooms} - {"app", "."}


def test_the_engine_stands_on_numpy_scipy_and_control_alone() -> None:
    allowed = ENGINE_LIBRARIES | set(sys.stdlib_module_names) | {"app"}
    assert violations((m, {name.split(".")[0] for name in m.imports()} - allowed - ({COMPILER} if m.name == SHELF else set()))
                      for m in modules("app.engine")) == []


def test_the_compiler_of_kernels_is_not_loaded_with_the_engine() -> None:
    assert not [node for m in modules("app.engine.kernels") for node in m.tree.body
                if isinstance(node, (ast.Import, ast.ImportFrom)) and COMPILER in ast.unparse(node)]


@pytest.mark.parametrize("library, home", [("viser", "app.view"), ("matplotlib", "app.export")])
def test_a_library_of_one_room_is_imported_there_alone(library: str, home: str) -> None:
    elsewhere = (m for m in modules("app", "lessons") if not within(m.name, home))
    assert violations((m, (name for name in m.imports() if within(name, library))) for m in elsewhere) == []


def test_private_names_of_viser_are_touched_in_quirks_alone() -> None:
    assert violations((m, private_uses(m.source)) for m in modules("app.view") if m.name != "app.view.quirks") == []


def test_every_script_that_is_called_by_name_is_there_and_each_that_is_there_is_called() -> None:
    """A file that is named as another one was, or anew, would break each page, and only where a browser looks."""
    called = {node.args[place].value for m in modules("app.view") for node in m.nodes if isinstance(node, ast.Call)
              for name, place in (("call", 0), ("run", 1)) if ast.unparse(node.func).split(".")[-1] == name
              and len(node.args) > place and isinstance(node.args[place], ast.Constant)}
    once = [ast.literal_eval(node.value) for m in modules("app.view.manners") for node in m.tree.body
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "ONCE"]
    there = {path.stem for path in (ROOT / "app" / "view" / "page").glob("*.js")}
    assert {name for name in called if isinstance(name, str)}.union(*once, {"apart"}) == there  # "apart" holds another


def test_no_star_imports() -> None:
    assert violations((m, (f"line {node.lineno}" for node in m.nodes if isinstance(node, ast.ImportFrom)
                           and any(a.name == "*" for a in node.names))) for m in every_module()) == []


def test_nothing_waits_or_ends_by_a_clock_that_can_be_set() -> None:
    """Whoever sets the clock of a machine moves no deadline: the log alone tells the time of day."""
    clock = re.compile(r"\b(time\.time\(|datetime\.(now|utcnow|today)\()")
    assert violations((m, clock.findall(m.source)) for m in modules("app", "lessons")) == []


def test_no_mutable_globals() -> None:
    """Wrap a table in MappingProxyType, a sequence in a tuple, a set in a frozenset."""
    assert violations((m, [*mutable_globals(m.source), *(f"line {n.lineno}: global" for n in m.nodes
                                                         if isinstance(n, ast.Global))])
                                                         for m in modules("app", "lessons")) == []


def test_any_is_said_in_lessons_and_the_tab_only_with_the_reason_beside_it() -> None:
    """A comment that names `Any` says why no type can stand there."""
    assert violations((m, [name for name in m.imports() if name == "typing.Any" and not re.search(r"# .*`Any`", m.source)])
                      for m in modules("lessons", "app.tab")) == []


def test_top_level_folders_are_those_agreed_and_no_others() -> None:
    there = {p.relative_to(ROOT).parts[0] for p in tracked() if len(p.relative_to(ROOT).parts) > 1}
    assert there == FOLDERS


MACHINE = re.compile(r"(?<![\w.}])/" + "(?:" + "|".join(["root", "work", "home", "Users", "tmp" + "/bash"]) + r")/\w"
                     + r"|\b[A-Z]:\\\\?" + "Users")


def test_no_tracked_file_names_a_path_of_some_machine() -> None:
    found = []
    for path in tracked():
        for number, line in enumerate(path.read_bytes().decode("utf-8", "ignore").splitlines(), 1):
            if MACHINE.search(line):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}")
    assert not found, found


# --- the rules catch what they are for -----------------------------------------------------------------------------
BREACHES = (
    ("app.engine.systems.plant", "from ...text import Text"),
    ("app.engine.systems.plant", "import app.plants"),
    ("app.engine.systems.plant", "from ..design.optimal import lqr"),
    ("app.text.message", "from ..engine import Plant"),
    ("app.plants.chip", "from ..lesson.figures import Curve"),
    ("app.lesson.figures", "from ..tab.state import write_tab"),
    ("app.tab.session", "def f():\n    from ..view.screen import Screen"),
    ("app.export.image", "from ..tab.session import Session"),
    ("app.tab.session", "from lessons import LESSONS"),
    ("lessons.duality.lesson", "from ..separation.lesson import MODEL"),
    ("lessons.duality.lesson", "from app.tab.session import Session"),
    ("lessons.toolkit.gains", "from ..separation import lesson"),
    ("app.lesson.figures", "import importlib\nimportlib.import_module('app.tab.session')"),
)
GOOD = (
    ("app.engine.systems.plant", "from .errors import EngineError\nimport numpy as np"),
    ("app.plants.chip", "from ..engine import Plant\nfrom ..text import Text"),
    ("lessons.duality.lesson", "from ..toolkit.gains import gains\nfrom . import proofs\nfrom app.engine import place"),
    ("app.view.server", "from ..tab.session import Session\nfrom . import quirks"),
    ("app.cli", "from lessons import LESSONS\nfrom app.view.server import LabServer"),
)


def test_the_import_rule_sees_a_breach_and_lets_good_imports_pass() -> None:
    assert [case for case in BREACHES if not forbidden_imports(case[1], case[0])] == []
    assert [case for case in GOOD if forbidden_imports(case[1], case[0])] == []


def test_the_rule_on_circles_sees_one_of_any_length() -> None:
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": {"e"}, "e": set()}) == [["a", "b", "c"]]
    assert circles({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == [] == circles({})
    sources = {"lessons.x": "", "lessons.x.lesson": "def f():\n    from .own import g",
               "lessons.x.own": "from .lesson import f"}
    found = circles(arrows(Module(ROOT / "x.py", name, source) for name, source in sources.items()))
    assert found == [["lessons.x.lesson", "lessons.x.own"]]


def test_the_privacy_rule_sees_a_breach() -> None:
    private = ("client._websock_connection", "self._server._websock_server", "from viser import _messages",
               "import viser._messages as m", "from viser._messages import GuiUpdateMessage",
               "getattr(handle, '_impl')")
    assert [source for source in private if not private_uses(source)] == []
    assert not private_uses("class A:\n    def f(self):\n        return self._server.__class__, hasattr(self, '_live')")


def test_the_rule_on_globals_sees_a_breach() -> None:
    mutable = ("A = {}", "A: dict = {'a': 1}", "a = [1]", "A = {1, 2}", "A = dict(a=1)", "A = [x for x in b]",
               "if b:\n    A = []", "try:\n    pass\nexcept Exception:\n    A = {}", "A = ({}, 1)",
               "A = collections.deque()")
    assert [source for source in mutable if not mutable_globals(source)] == []
    assert not mutable_globals("__all__ = ['a']\nA = MappingProxyType({'a': 1})\nB = (1, 2)\n"
                               "C = frozenset({1})\ndef f():\n    x = []\nclass D:\n    y = {}")


def test_the_path_rule_sees_a_breach() -> None:
    assert MACHINE.search("open('" + "/".join(["", "home", "someone", "x.txt"]) + "')")
    assert MACHINE.search("/".join(["", "root", "x"]))
    assert not MACHINE.search("https://example.org/home/page and f'{root}/glass'")
