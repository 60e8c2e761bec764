"""Every kind of nonsense for each argument of each public call, and what came of it.

Right is a sentence (EngineError and its kin), or an answer where the value makes sense there after all. Wrong is any other
exception, a warning, an answer to what has no meaning anywhere, memory beyond `MOST_BYTES`, a call that does not end.

    python tests/engine/nonsense.py [part of a name]
"""

from __future__ import annotations

import contextlib
import inspect
import io
import itertools
import os
import resource
import signal
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import scipy.sparse

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).resolve().parents[2]), str(Path(__file__).resolve().parent)]

from public_calls import calls, the_call

from observer_lab.engine import EngineError, Plant

MOST_BYTES = 1 << 30  # beyond what the process has when it begins
WATCHDOG = 60  # s: a call that has not ended by then never will
MISSING = {  # records in which NaN, or a masked entry, says that a measurement did not arrive
    "y", "innovations", "value", "residual", "known"}
ASTRAY = {"mean", "covariance", "points", "filters.errors_squared e", "filters.errors_squared P"}  # of many runs, some of which went astray
COLUMNS = {f"identification.preview_record {words}" for words in ("inputs", "outputs", "missing")}  # no such column: it says so beside
COMPLEX = {"poles", "a", "b", "to", "pole", "before", "after", "zeros", "response", "z", "desired"}


def _entry(value: object) -> Callable[[np.ndarray], object]:
    def spoilt(valid: np.ndarray) -> object:
        array = np.array(valid, dtype=complex if isinstance(value, complex) else float)
        array.reshape(-1)[:1] = value
        return array
    return spoilt


def _masked(valid: np.ndarray) -> object:
    where = np.zeros(valid.shape, dtype=bool)
    where.reshape(-1)[0] = True
    return np.ma.masked_array(np.array(valid, dtype=float), mask=where)


NEVER: dict[str, object] = {  # has no meaning as a number, a matrix, a record of anything
    "text": "nonsense", "bytes": b"nonsense", "object": object(), "array of text": np.array(["a"]),
    "array of dates": np.array(["2020-01-01"], dtype="M8[D]"), "NaN": np.nan, "array of None": np.array([None]),
    "ragged list": [[1, 2], [3]], "set": {1, 2}, "no text": "", "NaN in a sparse matrix": scipy.sparse.csr_matrix([[np.nan, 0], [0, 1]]),
}
MAYBE: dict[str, object] = {  # makes sense here and there
    "None": None, "True": True, "empty list": [], "empty dict": {}, "function": lambda *given: None, "1e400": 10**400,
    "1e12": 10**12, "1e7": 10**7, "1e300": 1e300, "1e-300": 1e-300, "1e9": 1e9, "-1": -1, "0": 0, "half": 0.5, "infinity": np.inf,
    "-infinity": -np.inf,
    "imaginary": 1j, "list of imaginary": [[1, 1j]], "three dimensions": np.zeros((2, 2, 2)), "empty": np.zeros((0, 0)),
    "vector": np.ones(7),
    "plant without states": Plant(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0))),
    "plant": Plant(np.eye(3) * 1.5, np.ones((3, 2)), np.ones((2, 3)), dt=0.5),
    "wide": np.ones((2, 5)), "large numbers": np.full((2, 2), 1e200), "column": np.ones((4, 1)), "range": range(3),
    "zero": np.zeros((2, 2)), "no columns": np.zeros((2, 0)), "no rows": np.zeros((0, 2)), "no entries": np.zeros(0),
    "sparse without entries": scipy.sparse.csr_matrix((0, 0)), "large sparse": scipy.sparse.csr_array((10**5, 10**5)),
    "1e308": 1e308, "largest numbers": np.full((2, 2), 1e308), "largest difference": np.array([[1e308, -1e308], [1e-308, 1e308]]),
    "least": 5e-324, "beyond single precision": np.full((2, 2), np.inf, dtype=np.float32),
}
SPOILT: dict[str, tuple[bool, Callable[[np.ndarray], object]]] = {  # what is right but for one thing; whether an answer is wrong
    "a NaN in it": (True, _entry(np.nan)), "an infinity in it": (True, _entry(np.inf)), "an imaginary part in it": (True, _entry(1j)),
    "a masked entry": (True, _masked), "one row more": (False, lambda v: np.concatenate([v, v[:1]])),
    "one dimension more": (False, lambda v: v[None]), "negative": (False, lambda v: -v), "as text": (True, lambda v: v.astype(str)),
    "tiny": (False, lambda v: v * 1e-200), "huge": (False, lambda v: v * 1e200), "largest": (False, lambda v: np.sign(v) * 1e308),
    "1e308 in it": (False, _entry(1e308)), "-1e308 in it": (False, _entry(-1e308)), "5e-324 in it": (False, _entry(5e-324)),
    "asymmetric": (False, lambda v: v + np.triu(np.ones_like(v), 1) if v.ndim == 2 else v * 2),
}


def kinds(valid: object) -> Iterator[tuple[str, bool, object]]:
    """Kind, whether an answer to it is wrong, and the nonsense, for an argument of which `valid` is right."""
    for kind, value in NEVER.items():
        fits = isinstance(value, str | bytes) and isinstance(valid, str | bytes | Path | io.BytesIO)
        yield kind, not fits, value
    for kind, value in MAYBE.items():
        yield kind, False, value
    array = _numbers(valid)
    if array is not None:
        for kind, (never, spoil) in SPOILT.items():
            if array.size and (array.ndim or kind in ("an imaginary part in it", "one dimension more")):
                yield kind, never, spoil(array)


def _numbers(valid: object) -> np.ndarray | None:
    try:
        array = np.asarray(valid)
    except ValueError:
        return None
    return array.astype(float) if array.dtype.kind in "fiub" and not isinstance(valid, bool | range) else None


def feed(name: str, argument: str, nonsense: object) -> str:
    """What a call says to one argument of nonsense: "" for an answer, "refused", or what went wrong."""
    given = {key: value for key, value in calls()[name].items() if key != "self"}
    given[argument] = nonsense
    try:
        with warnings.catch_warnings(), np.errstate(over="warn", invalid="warn", divide="warn", under="ignore"):
            warnings.simplefilter("error")
            found = the_call(name)(**given)
            if inspect.isgenerator(found):
                for _ in itertools.islice(found, 3):
                    pass
    except EngineError as sentence:
        return "refused" if str(sentence) else "an empty sentence"
    except _Endless:
        return "does not end"
    except Exception as problem:
        return f"{type(problem).__name__}: {problem}"[:110]
    return ""


class _Endless(BaseException):
    pass


@contextlib.contextmanager
def watched(seconds: int = WATCHDOG) -> Iterator[Callable[[], None]]:
    """Bounds memory and gives a function that starts the watchdog anew; files that a call writes go to a folder of their own."""
    def bark(*_: object) -> None:
        raise _Endless
    before, place = resource.getrlimit(resource.RLIMIT_AS), os.getcwd()
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    old = signal.signal(signal.SIGALRM, bark)
    with tempfile.TemporaryDirectory() as folder:
        try:
            os.chdir(folder)
            resource.setrlimit(resource.RLIMIT_AS, (used + MOST_BYTES, before[1]))
            yield lambda: signal.alarm(seconds) and None
        finally:
            signal.alarm(0)
            signal.signal(signal.SIGALRM, old)
            resource.setrlimit(resource.RLIMIT_AS, before)
            os.chdir(place)


def findings(cases: list[tuple[str, str]]) -> Iterator[tuple[str, str, str, str]]:
    """(call, argument, kind, what went wrong) of everything wrong in these (call, argument)."""
    with watched() as again:
        for name, argument in cases:
            valid = calls()[name][argument]
            for kind, never, nonsense in kinds(valid):
                again()
                said = feed(name, argument, nonsense)
                if said == "" and never and not _sensible(name, argument, kind):
                    yield name, argument, kind, "answered"
                elif said not in ("", "refused"):
                    yield name, argument, kind, said


def _sensible(name: str, argument: str, kind: str) -> bool:
    if kind == "NaN in a sparse matrix":
        kind = "a NaN in it"
    return ((argument in MISSING and kind in ("a NaN in it", "a masked entry", "NaN"))
            or (argument in COMPLEX and kind == "an imaginary part in it")
            or (argument in ("u_max", "omega", "lower", "upper") and kind == "an infinity in it")
            or (bool({argument, f"{name} {argument}"} & ASTRAY) and kind in ("a NaN in it", "an infinity in it", "a masked entry"))
            or ((argument.endswith("_names") or argument == "notes" or f"{name} {argument}" in COLUMNS) and kind == "array of text"))


def cases() -> list[tuple[str, str]]:
    """Every (call, argument)."""
    return [(name, argument) for name, arguments in calls().items() for argument in arguments if argument != "self"]


def main(part: str = "") -> None:
    """Print every finding, then how many there are of each kind."""
    count: Counter[str] = Counter()
    out = os.fdopen(os.dup(sys.stdout.fileno()), "w")  # whoever opens file number 1 also closes it
    chosen = [case for case in cases() if part in ".".join(case)]
    for name, argument, kind, said in findings(chosen):
        print(f"{name}({argument}={kind}): {said}", file=out, flush=True)
        count[said.split(":")[0]] += 1
    fed = sum(1 for name, argument in chosen for _ in kinds(calls()[name][argument]))
    print(f"{sum(count.values())} findings of {fed} calls, {len(chosen)} arguments: {dict(count.most_common())}", file=out)


if __name__ == "__main__":
    main(*sys.argv[1:2])
