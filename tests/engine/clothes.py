"""The arguments of each public call in other clothes: sparse, single precision, read-only, a table of pandas, … and what came of it.

Right is the answer to the plain array, or a sentence (EngineError); wrong is any other answer, exception or warning, and an argument
that the call has changed. Numbers at the end of the range of doubles and masked arrays belong here too.

    python tests/engine/clothes.py [part of a name]
"""

from __future__ import annotations

import contextlib
import copy
import inspect
import io
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).resolve().parents[2]), str(Path(__file__).resolve().parent)]

from nonsense import watched
from public_calls import calls, the_call

from observer_lab.engine import EngineError

with contextlib.suppress(ImportError):
    import pandas

SAME = 1e-12  # of the largest number of an answer
PLAIN = {"channels", "lag", "lead", "believed", "dt", "mean", "covariance", "points"}  # pairs, periods, and arrays that stay what they are
SINGLE = {"filters.joseph", "filters.short_form"}  # stay in the precision given: rounding is their subject


def _frozen(valid: np.ndarray) -> np.ndarray:
    copied = valid.copy()
    copied.setflags(write=False)
    return copied


def _objects(valid: np.ndarray) -> np.ndarray:
    return valid.astype(object)


def _spread(valid: np.ndarray) -> np.ndarray:
    """Every second entry of a larger array, in Fortran's order."""
    large = np.zeros([2 * size for size in valid.shape], order="F")
    large[tuple(slice(None, None, 2) for _ in valid.shape)] = valid
    return large[tuple(slice(None, None, 2) for _ in valid.shape)]


def _old_matrix(valid: np.ndarray) -> object:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)  # of NumPy's matrix, which some still bring
        return np.asmatrix(valid)


def _table(valid: np.ndarray) -> object:
    return pandas.DataFrame(valid, columns=[f"c{k}" for k in range(valid.shape[1])]) if valid.ndim == 2 else pandas.Series(valid)


CLOTHES: dict[str, tuple[range, Callable[[np.ndarray], object]]] = {  # in how many dimensions, and what is put on
    "read-only": (range(1, 5), _frozen), "every second entry": (range(1, 5), _spread), "list": (range(5), np.ndarray.tolist),
    "imaginary parts of zero": (range(5), lambda v: v.astype(complex)), "objects": (range(1, 5), _objects),
    "masked nowhere": (range(1, 5), np.ma.masked_array), "single precision": (range(5), np.float32),
    "sparse": (range(2, 3), scipy.sparse.csr_matrix), "sparse array": (range(1, 3), scipy.sparse.coo_array),
    "numpy matrix": (range(2, 3), _old_matrix), **({"pandas": (range(1, 3), _table)} if "pandas" in globals() else {}),
}


def worn(valid: object) -> Iterator[tuple[str, object, object]]:
    """The clothes, what is in them, and the plain array that it stands for."""
    if isinstance(valid, bool | range | str | bytes | int | None):
        return
    try:
        plain = np.asarray(valid)
    except ValueError:
        return
    if plain.dtype.kind not in "fiu":
        return
    whole = plain.dtype.kind in "iu"
    plain = plain.astype(float)
    for name, (dimensions, put_on) in CLOTHES.items():
        if plain.ndim in dimensions and not (whole and name == "objects"):
            single = plain.astype(np.float32).astype(float)
            yield name, put_on(plain), single if name == "single precision" else plain


def asked(name: str, argument: str, value: object) -> object:
    """The answer of a call to one argument, everything else as in its example; an EngineError as its sentence."""
    given = {key: copy.deepcopy(kept) if isinstance(kept, np.random.Generator | io.IOBase) else kept
             for key, kept in calls()[name].items() if key != "self"}
    given[argument] = value
    try:
        found = the_call(name)(**given)
        return list(found)[-1:] if inspect.isgenerator(found) else found
    except EngineError as sentence:
        return str(sentence)


def numbers(found: object) -> Iterator[np.ndarray | str]:
    """All numbers and texts of an answer, those within its records too."""
    if isinstance(found, np.ndarray | np.number | int | float | complex):
        found = np.asarray(found)
        yield found.astype(float) if found.dtype.kind in "biu" else found
    elif isinstance(found, str):
        yield found
    elif isinstance(found, tuple | list):
        for part in found:
            yield from numbers(part)
    elif isinstance(found, dict):
        yield from numbers(list(found.values()))
    elif is_dataclass(found):
        yield from numbers([getattr(found, f.name) for f in fields(found)])


def differ(one: object, other: object) -> str:
    """What parts two answers, "" where nothing does."""
    first, second = list(numbers(one)), list(numbers(other))
    if len(first) != len(second):
        return f"{len(first)} and {len(second)} parts"
    for a, b in zip(first, second, strict=True):
        if isinstance(a, str) or isinstance(b, str):
            if not (isinstance(a, str) and isinstance(b, str) and a == b):
                return f"{a} and {b}"
        elif a.shape != b.shape:
            return f"shapes {a.shape} and {b.shape}"
        elif a.dtype.kind not in "fc":
            continue
        elif not np.array_equal(np.isfinite(a), np.isfinite(b)):
            return "finite and not"
        else:
            size = np.abs(np.where(np.isfinite(a), a, 0)).max(initial=0.0)
            with np.errstate(invalid="ignore"):
                gap = np.abs(np.where(np.isfinite(a), a - b, 0)).max(initial=0.0)
            if gap > SAME * size:
                return f"{gap / size if size else np.inf:.1e} apart"
    return ""


def findings(cases: list[tuple[str, str]]) -> Iterator[tuple[str, str, str, str]]:
    """(call, argument, clothes, what went wrong) of everything wrong in these (call, argument)."""
    with watched() as again, warnings.catch_warnings():
        warnings.simplefilter("error")
        for name, argument in cases:
            known: dict[bytes, object] = {}
            for clothes, value, plain in worn(calls()[name][argument]):
                if clothes == "single precision" and name in SINGLE:
                    continue
                again()
                before = copy.deepcopy(value)
                try:
                    if plain.tobytes() not in known:
                        known[plain.tobytes()] = asked(name, argument, plain)
                    found, wanted = asked(name, argument, value), known[plain.tobytes()]
                except Exception as problem:
                    yield name, argument, clothes, f"{type(problem).__name__}: {problem}"[:120]
                    continue
                if isinstance(found, str) and not isinstance(wanted, str) and (argument in PLAIN or not np.size(plain)):
                    continue
                if gap := differ(wanted, found):
                    yield name, argument, clothes, gap
                if differ(_plain(before), _plain(value)):
                    yield name, argument, clothes, "the argument was changed"


def _plain(value: Any) -> np.ndarray:
    return np.asarray(value.toarray() if scipy.sparse.issparse(value) else value, dtype=complex)


def cases() -> list[tuple[str, str]]:
    """Every (call, argument)."""
    return [(name, argument) for name, arguments in calls().items() for argument in arguments if argument != "self"]


def main(part: str = "") -> None:
    """Print every finding, then how many there are."""
    count: Counter[str] = Counter()
    chosen = [case for case in cases() if part in ".".join(case)]
    for name, argument, clothes, said in findings(chosen):
        print(f"{name}({argument}, {clothes}): {said}", flush=True)
        count[clothes] += 1
    print(f"{sum(count.values())} findings of {sum(1 for a, b in chosen for _ in worn(calls()[a][b]))} calls: {dict(count)}")


if __name__ == "__main__":
    main(*sys.argv[1:2])
