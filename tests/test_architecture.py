"""The house keeps its promises: who may import whom, what is private stays private, nothing mutable is global."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

import pytest
from syntax import ROOT, Module, arrows, circles, imports, mutable_globals, name_of, parsed, private_uses, replaced_names, within

FOLDERS = {"app", "lessons", "tests", "assets", ".ci", ".github"}
ROOM = re.compile(r"│ (\S+) +│(?:──► (.+))?$")


def drawn(page: str) -> dict[str, tuple[str, ...]]:
    """Room → the rooms it may import, as the picture of the house in CONTRIBUTING.md has it, by full names."""
    picture = page.split("```")[1]
    house, _, engine = picture.partition("observer_lab.engine, its own rooms")
    return dict(_rooms(house, "observer_lab") + _rooms(engine, "observer_lab.engine"))


def _rooms(picture: str, parent: str) -> list[tuple[str, tuple[str, ...]]]:
    return [(f"{parent}.{name}", tuple(f"{parent}.{other}" for other in arrows))
            for name, arrows in map(_row, picture.splitlines()) if name]


def _row(line: str) -> tuple[str, tuple[str, ...]]:
    room = ROOM.match(line.strip())
    return (room[1], tuple((room[2] or "").split())) if room else ("", ())


PICTURE = drawn((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"))
# Layer → the layers it may import. A module belongs to the longest prefix of its name that is listed here.
MAY_IMPORT = {"observer_lab": ("observer_lab.cli",), **PICTURE, "observer_lab.engine": ("observer_lab.engine",)}
ENGINE_LIBRARIES = {"numpy", "scipy", "control"}
VISER = "observer_lab.page.viser_private"
PRIVATE = (f"{VISER}.viser_internals", f"{VISER}.adapter")  # the calls and the classes that may use private names of viser
PLOTTING = "observer_lab.engine.plotting"  # may load matplotlib where a plot is asked for
HORIZON = "observer_lab.engine.filters.smoothing.moving_horizon"  # may load a solver of quadratic programs where bounds act
COMPILER, COMPILE_CACHE = "numba", "observer_lab.engine.kernels.compile_cache"  # imported there alone, when kernels are compiled
TIME_OF_DAY = "observer_lab.cli.courses"  # gives a course the clock by which a hand-in is on time
READING = "observer_lab.engine.identification.reading"  # loads a library of the extra `records` for a file that needs it
WHEN_CALLED = MappingProxyType({
    f"{READING}.parquet_tables": "pyarrow", f"{READING}.mdf_tables": "asammdf", f"{READING}.mcap_tables": "mcap",
    f"{READING}.ros_messages": "mcap_ros2",
    COMPILE_CACHE: COMPILER, PLOTTING: "matplotlib", HORIZON: "daqp"})
ROOMS = ("lesson", "knobs", "study", "figures", "tasks")  # of every lesson, beside job and own where there are such
MOST_FILES, LONGEST_FIRST_LINE = 20, 100
LONGEST, LONGEST_LESSON = 300, 12  # lines of a module, and of the one that assembles a lesson
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
            if layer == "observer_lab.lessons" and not lesson_may(module, name):
                out.append(name)
        elif not any(within(target, allowed) for allowed in MAY_IMPORT[layer]):
            out.append(name)
    return out


def lesson_may(module: str, name: str) -> bool:
    """A lesson knows itself and the toolkit; only the table of contents knows the lessons."""
    own = ".".join(module.split(".")[:3])
    homes = (own, "observer_lab.lessons.toolkit")
    return module == "observer_lab.lessons" or any(within(name, home) for home in homes)


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
    assert violations((m, forbidden_imports(m.source, m.name, m.package)) for m in modules("observer_lab")) == []


def test_no_modules_import_each_other_in_a_circle() -> None:
    assert circles(arrows(modules("observer_lab"))) == []


def wing_of(name: str) -> str:
    """The sub-folder of a room that a module belongs to; a module that stands in the room itself is a wing of its own."""
    return ".".join(name.split(".")[:3])


def test_no_wings_of_a_room_import_each_other_in_a_circle() -> None:
    graph: dict[str, set[str]] = {}
    for module, targets in arrows(m for m in modules("observer_lab") if not m.package).items():
        graph.setdefault(wing_of(module), set()).update(wing_of(target) for target in targets)
    assert any(name == "observer_lab.page.stage" for name in graph)
    assert circles({name: targets - {name} for name, targets in graph.items()}) == []


def test_no_folder_is_too_full_to_be_seen_at_once() -> None:
    """At most MOST_FILES files of one level; the catalogues of a language and the lessons are lists by nature."""
    counted = Counter(path.parent.relative_to(ROOT).as_posix() for path in tracked())
    assert {folder: n for folder, n in counted.items() if folder.startswith("app") and "locale" not in folder and n > MOST_FILES} == {}


def test_every_module_says_in_one_line_what_it_does() -> None:
    assert violations((m, [(ast.get_docstring(m.tree) or "no docstring").splitlines()[0]]) for m in modules("observer_lab")
                      if not 0 < len((ast.get_docstring(m.tree) or "").partition("\n")[0]) <= LONGEST_FIRST_LINE) == []


def test_no_module_is_too_long_to_be_read_at_once() -> None:
    lengths = [(m, len(m.source.splitlines())) for m in modules("observer_lab")]
    assert violations((m, [f"{n} lines"]) for m, n in lengths if n > LONGEST) == []
    assert violations((m, [f"{n} lines"]) for m, n in lengths
                      if re.fullmatch(r"observer_lab\.lessons\.\w+\.lesson", m.name) and n > LONGEST_LESSON) == []


def test_every_lesson_has_the_standard_rooms() -> None:
    names = {m.name for m in modules("observer_lab.lessons")}
    homes = {name.removesuffix(".lesson") for name in names if re.fullmatch(r"observer_lab\.lessons\.\w+\.lesson", name)}
    assert [f"{home}.{room}" for home in sorted(homes) for room in ROOMS if f"{home}.{room}" not in names] == []


def test_every_arrow_of_the_picture_points_down() -> None:
    rooms = list(PICTURE)
    assert [(room, other) for room, arrows in PICTURE.items() for other in arrows
            if other not in rooms or rooms.index(other) <= rooms.index(room)] == []


def test_the_picture_has_no_arrow_that_no_import_needs() -> None:
    needed = {(layer_of(m.name), layer_of(name)) for m in modules("observer_lab") for name in m.imports()}
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
    allowed = ENGINE_LIBRARIES | set(sys.stdlib_module_names) | {"observer_lab"}
    assert violations((m, {name.split(".")[0] for name in m.imports()} - allowed - {WHEN_CALLED.get(m.name, "")})
                      for m in modules("observer_lab.engine")) == []


def test_the_compiler_of_kernels_is_not_loaded_with_the_engine() -> None:
    assert not [node for m in modules("observer_lab.engine.kernels") for node in m.tree.body
                if isinstance(node, (ast.Import, ast.ImportFrom)) and COMPILER in ast.unparse(node)]


@pytest.mark.parametrize("library, home", [("viser", "observer_lab.page"), ("matplotlib", "observer_lab.export")])
def test_a_library_of_one_room_is_imported_there_alone(library: str, home: str) -> None:
    elsewhere = (m for m in modules("observer_lab") if not within(m.name, home) and m.name != PLOTTING)
    assert violations((m, (name for name in m.imports() if within(name, library))) for m in elsewhere) == []


def test_matplotlib_is_loaded_by_a_plot_and_not_with_the_engine() -> None:
    plotting = next(modules(PLOTTING))
    early = [node for node in plotting.tree.body if isinstance(node, (ast.Import, ast.ImportFrom)) and "matplotlib" in ast.unparse(node)]
    assert early == [] and any(within(name, "matplotlib") for name in plotting.imports())


def test_private_names_of_viser_are_touched_in_quirks_alone() -> None:
    assert violations((m, private_uses(m.source)) for m in modules("observer_lab.page") if m.name not in PRIVATE) == []


def test_nothing_is_replaced_while_it_runs() -> None:
    """No stand-in of a test library in the program, no assignment to what another library's module or class holds."""
    assert violations((m, replaced_names(m.source)) for m in modules("observer_lab")) == []


def test_every_script_that_is_called_by_name_is_there_and_each_that_is_there_is_called() -> None:
    """A file that is named as another one was, or anew, would break each page, and only where a browser looks."""
    called = {node.args[place].value for m in modules("observer_lab.page") for node in m.nodes if isinstance(node, ast.Call)
              for name, place in (("script_call", 0), ("run_script", 1)) if ast.unparse(node.func).split(".")[-1] == name
              and len(node.args) > place and isinstance(node.args[place], ast.Constant)}
    once = [ast.literal_eval(node.value) for m in modules("observer_lab.page.screen.page_setup") for node in m.tree.body
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "PAGE_SCRIPTS"]
    there = {path.stem for path in (ROOT / "app" / "page" / "web").glob("*/*.js")}
    assert {name for name in called if isinstance(name, str)}.union(*once, {"apart"}) == there  # "apart" holds another


def test_no_star_imports() -> None:
    assert violations((m, (f"line {node.lineno}" for node in m.nodes if isinstance(node, ast.ImportFrom)
                           and any(a.name == "*" for a in node.names))) for m in every_module()) == []


def test_nothing_waits_or_ends_by_a_clock_that_can_be_set() -> None:
    """Whoever sets the clock of a machine moves no deadline of the program: the log and a course's hand-ins alone tell the time of day."""
    clock = re.compile(r"\b(time\.time\b|datetime\.(now|utcnow|today)\()")
    assert violations((m, clock.findall(m.source)) for m in modules("observer_lab") if m.name != TIME_OF_DAY) == []
    assert len(clock.findall(next(modules(TIME_OF_DAY)).source)) == 1


def test_no_mutable_globals() -> None:
    """Wrap a table in MappingProxyType, a sequence in a tuple, a set in a frozenset."""
    assert violations((m, [*mutable_globals(m.source), *(f"line {n.lineno}: global" for n in m.nodes
                                                         if isinstance(n, ast.Global))])
                                                         for m in modules("observer_lab")) == []


def test_any_is_said_in_lessons_and_the_tab_only_with_the_reason_beside_it() -> None:
    """A comment that names `Any` says why no type can stand there."""
    assert violations((m, [name for name in m.imports() if name == "typing.Any" and not re.search(r"# .*`Any`", m.source)])
                      for m in modules("observer_lab.lessons", "observer_lab.session")) == []


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
    ("observer_lab.engine.systems.plant", "from ...text import Text"),
    ("observer_lab.engine.systems.plant", "import observer_lab.plants"),
    ("observer_lab.engine.systems.plant", "from ..design.optimal import lqr"),
    ("observer_lab.text.message", "from ..engine import Plant"),
    ("observer_lab.plants.chip", "from ..course.figures.records import Curve"),
    ("observer_lab.course.figures.records", "from ...session.state.tab_memory import write_memory"),
    ("observer_lab.session.session", "def f():\n    from ..page.screen.screen import Screen"),
    ("observer_lab.export.image", "from ..session.session import Session"),
    ("observer_lab.session.session", "from observer_lab.lessons import LESSONS"),
    ("observer_lab.lessons.duality.lesson", "from ..separation.lesson import MODEL"),
    ("observer_lab.lessons.duality.lesson", "from observer_lab.session.session import Session"),
    ("observer_lab.lessons.toolkit.gains", "from ..separation import lesson"),
    ("observer_lab.course.figures.records", "import importlib\nimportlib.import_module('observer_lab.session.session')"),
)
GOOD = (
    ("observer_lab.engine.systems.plant", "from .errors import EngineError\nimport numpy as np"),
    ("observer_lab.plants.chip", "from ..engine import Plant\nfrom ..text import Text"),
    ("observer_lab.lessons.duality.lesson", "from ..toolkit.gains import gains\nfrom observer_lab.engine import place"),
    ("observer_lab.page.screen.server", "from ...session.session import Session\nfrom ..viser_private import viser_internals"),
    ("observer_lab.cli", "from observer_lab.lessons import LESSONS\nfrom observer_lab.page.screen.server import LabServer"),
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


def test_the_rule_on_replacing_sees_a_breach() -> None:
    replaced = ("from unittest import mock", "import unittest.mock", "import viser\nviser.add = f",
                "from viser import infra\ninfra.a.b = 1",
                "from viser import infra\ndef f():\n    infra._consume = 1", "import numpy as np\nsetattr(np, 'x', 1)",
                "def f(x):\n    x.__class__ = int", "from viser import A\nA.b: int = 1", "from a import A\ndel A.b")
    assert [source for source in replaced if not replaced_names(source)] == []
    assert not replaced_names("import numpy as np\nfrom a import A\nx = A()\nx.b = 1\nclass B:\n    def f(self):\n        self.np = np.pi")


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
