"""Read transfer functions as files give them: num and den, or zeros, poles and gain."""

from __future__ import annotations

import numpy as np

from ..systems.errors import EngineError
from ..systems.fractions import Fraction, zeros_and_poles
from .found import Found
from .input_gate import Entry, Unread, number, scalar

__all__ = ["fractions"]

_MOST_CHANNELS = 16
_INVERSE, _OF_SAMPLES, _OF_TIME = frozenset(("z^-1", "q^-1", "z^{-1}")), frozenset(("z", "q")), frozenset(("s", "p"))
Grid = list[list[np.ndarray]]


def fractions(found: Found, period: float) -> list[list[Fraction]] | None:
    """The p×m matrix of fractions, None where the file has none. Raises EngineError where a part is missing or does not fit."""
    variable = _variable(found, period) if found.keys("variable") and (found.keys("denominator") or found.keys("poles")) else ""
    if found.keys("numerator") or found.keys("denominator"):
        num, den = (_grid(found, what) for what in ("numerator", "denominator"))
        return _paired(num, den, variable in _INVERSE)
    if not found.keys("poles"):
        return None
    zeros, poles = (_roots(found.take(what, None), next(iter(found.keys(what)), what)) for what in ("zeros", "poles"))
    if not found.keys("gain"):
        raise EngineError("The file gives zeros or poles without their gain; add the key gain.")
    return [[zeros_and_poles(zeros, poles, scalar(_only(found.take("gain", None)), found.keys("gain")[0]))]]


def _variable(found: Found, period: float) -> str:
    key = found.keys("variable")[0]
    word = found.take("variable", "")
    name = word.strip() if isinstance(word, str) else ""
    if name not in _INVERSE | _OF_SAMPLES | _OF_TIME:
        raise EngineError("{key} must be s, z or z^-1.", key=key)
    if (name in _OF_TIME) == bool(period):
        raise EngineError("{key} is {name}, which does not fit the sampling period {period:g} s; correct one of the two.", key=key,
                          name=name, period=period)
    return name


def _only(value: Entry) -> Entry:
    """The member of a list of one, within lists of one."""
    while isinstance(value, list) and len(value) == 1:
        value = value[0]
    return value


def _grid(found: Found, what: str) -> tuple[Grid, str]:
    """Coefficients by output and input, and their name in the file. Raises EngineError."""
    keys = found.keys(what)
    if not keys:
        raise EngineError("A transfer function needs its numerator and its denominator; give both num and den.")
    value, key = found.take(what, None), keys[0]
    if isinstance(value, np.ndarray) or not isinstance(value, list):
        return _of_rows(_coefficients(value, key)), key
    if not any(isinstance(part, list | np.ndarray) for part in value):
        return [[_coefficients(value, key)[0]]], key
    if all(isinstance(row, list) and row and all(isinstance(part, list | np.ndarray) for part in row) for row in value):
        grid = [[_coefficients(part, key)[0] for part in row] for row in value]
    else:
        grid = [[_coefficients(row, key)[0]] for row in value]
    if len({len(row) for row in grid}) != 1 or len(grid) > _MOST_CHANNELS or len(grid[0]) > _MOST_CHANNELS:
        raise EngineError("{key} must have a list of coefficients for each output and input, 16 at most.", key=key)
    return grid, key


def _coefficients(value: Entry, key: str) -> np.ndarray:
    """Rows of coefficients r×k. Raises EngineError."""
    if isinstance(value, Unread):
        raise EngineError("{key} must be a full real matrix; it is {found}.", key=key, found=value.what)
    if isinstance(value, np.ndarray) and not np.iscomplexobj(value):
        return value.reshape(1, -1) if 1 in value.shape else value
    if isinstance(value, int | float) and not isinstance(value, bool):
        return np.array([[number(value, key)]])
    if isinstance(value, list) and value:
        return np.array([[number(entry, key) for entry in value]])
    raise EngineError("{key} must hold the coefficients of polynomials, highest power first.", key=key)


def _of_rows(rows: np.ndarray) -> Grid:
    return [[row] for row in rows]


def _paired(num: tuple[Grid, str], den: tuple[Grid, str], inverse: bool) -> list[list[Fraction]]:
    over, under = num[0], den[0]
    if len(under) == len(under[0]) == 1:
        under = [[under[0][0]] * len(row) for row in over]
    if [len(row) for row in over] != [len(row) for row in under]:
        raise EngineError("{num} and {den} must have the same number of outputs and inputs, or one denominator for all.",
                          num=num[1], den=den[1])
    return [[_of_equal_length(*pair) if inverse else pair for pair in zip(*rows, strict=True)] for rows in zip(over, under, strict=True)]


def _of_equal_length(num: np.ndarray, den: np.ndarray) -> Fraction:
    """Coefficients of powers of z⁻¹ as those of powers of z."""
    length = max(len(num), len(den))
    return np.pad(num, (0, length - len(num))), np.pad(den, (0, length - len(den)))


def _roots(value: Entry, key: str) -> np.ndarray:
    """Zeros or poles (k,), complex: numbers, [re, im] or a matrix of one row or column. Raises EngineError."""
    if isinstance(value, list) and len(value) == 1 and isinstance(value[0], list) and not value[0]:
        value = []  # a cell array with nothing in it
    elif isinstance(value, list) and len(value) == 1 and isinstance(value[0], list) and isinstance(value[0][0], list | np.ndarray):
        value = value[0][0]
    if value is None:
        return np.zeros(0, dtype=complex)
    if isinstance(value, np.ndarray):
        if value.size and 1 not in value.shape:
            raise EngineError("{what} must be one row of numbers; it is {rows}×{columns}.", what=key, rows=value.shape[0],
                              columns=value.shape[1])
        return value.ravel().astype(complex)
    given = value if isinstance(value, list) else [value]
    return np.array([_complex(entry, key) for entry in given], dtype=complex)


def _complex(entry: Entry, key: str) -> complex:
    if isinstance(entry, list) and len(entry) == 2:
        return complex(number(entry[0], key), number(entry[1], key))
    if isinstance(entry, str) and len(entry) < 60:
        try:
            return complex(entry.replace(" ", "").replace("i", "j").replace("−", "-"))
        except ValueError as problem:
            raise EngineError("{key} holds {entry}, which is no number.", key=key, entry=entry[:40]) from problem
    return complex(number(entry, key))
