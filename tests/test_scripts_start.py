"""Each script beside the tests finds what it imports, run as its first line says: from anywhere, with no folder told to Python."""

from __future__ import annotations

import subprocess
import sys

from sampling import some
from syntax import ROOT

STARTS = """# each in a process of its own, up to its first function; what is installed is loaded once
import ast, os, sys, traceback
import numpy, scipy.linalg, viser, playwright.sync_api, observer_lab.lessons
for path in sys.argv[1:]:
    child = os.fork()
    if child == 0:
        sys.path[0] = os.path.dirname(path)
        tree = ast.parse(open(path, encoding="utf-8").read(), path)
        kinds = ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef
        made = next((k for k, each in enumerate(tree.body) if isinstance(each, kinds)), None)
        tree.body = tree.body[:made]
        try:
            exec(compile(tree, path, "exec"), {"__name__": "__main__", "__file__": path})
        except BaseException as problem:
            print(path, type(problem).__name__, problem, flush=True)
        os._exit(0)
    os.waitpid(child, 0)
"""


def test_every_script_finds_what_it_imports() -> None:
    scripts = [path for path in sorted((ROOT / "tests").rglob("*.py")) if '__name__ == "__main__"' in path.read_text("utf-8")]
    assert len(scripts) > 40
    scripts = some("scripts find what they import", scripts, 3)
    done = subprocess.run([sys.executable, "-c", STARTS, *map(str, scripts)], cwd="/", capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and done.stdout == "", done.stdout + done.stderr
