"""The variables of one file and which of them have been used, so that none is ignored in silence."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ..systems.errors import EngineError
from .input_gate import OBJECT, Entry, Unread, matrix, scalar, vector

__all__ = ["HARMLESS", "MATRICES", "MEANINGS", "NOT_SUPPORTED", "RATES", "Found", "meaning", "plain"]

_SECONDS = frozenset(("", "s", "sec", "second", "seconds"))
MATRICES = ("A", "B", "C", "D", "E")
_SPELLINGS = MappingProxyType({
    "period": ("ts", "dt", "samplingperiod", "samplingtime", "sampletime", "sampleperiod", "tsample", "tsampling", "samplinginterval",
               "sampleinterval"),
    "input_delay": ("inputdelay", "inputdelays"),
    "output_delay": ("outputdelay", "outputdelays"),
    "io_delay": ("iodelay", "iodelaymatrix", "delay", "deadtime", "timedelay", "transportdelay"),
    "numerator": ("num", "numerator"),
    "denominator": ("den", "denominator"),
    "zeros": ("zeros", "z"),
    "poles": ("poles", "p"),
    "gain": ("gain", "k"),
    "variable": ("variable",),
    "time_unit": ("timeunit", "timeunits"),
    "states": ("states", "statename", "statenames", "statelabels"),
    "inputs": ("inputs", "inputname", "inputnames", "inputlabels"),
    "outputs": ("outputs", "outputname", "outputnames", "outputlabels"),
    "state_units": ("stateunit", "stateunits"),
    "input_units": ("inputunit", "inputunits"),
    "output_units": ("outputunit", "outputunits"),
    "units": ("units",),
    "name": ("name",),
    "changes": ("changes",),
    "labels": ("labels",),
    "format": ("format",),
    "version": ("version",),
})
MEANINGS = MappingProxyType({spelling: what for what, spellings in _SPELLINGS.items() for spelling in spellings})
# What may stand in a file and says nothing about the plant's matrices.
HARMLESS = frozenset((
    "about", "author", "authors", "class", "comment", "comments", "copyright", "created", "date", "description", "displayformat", "doi",
    "inputgroup", "keywords", "license", "note", "notes", "outputgroup", "readme", "reference", "references", "samplinggrid", "scaled",
    "source", "statepath", "tags", "title", "url", "userdata", "$schema", "#", "//", "globals", "header"))
# What MATLAB's objects may hold beyond a plant that is linear, time-invariant and without delay inside.
NOT_SUPPORTED = frozenset(("internaldelay", "statedelay", "offsets"))
RATES = frozenset(("fs", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency", "fsample"))
_ONLY_WITHOUT_A = frozenset(("zeros", "poles", "gain"))
_OF_FREE_CASE = re.compile(r"[_\-\s]")


class Found:
    """Variables by name as a person wrote them. `workspace`: whether others may stand beside the plant, as in a .mat file."""

    def __init__(self, entries: Mapping[str, Entry], workspace: bool) -> None:
        self._entries, self._workspace = dict(entries), workspace
        self._used: set[str] = set()
        lower = [key.lower() for key in "ABC" if key not in entries and key.lower() in entries]
        matrices = "A" in entries or "a" in lower
        letters = MATRICES if lower else ()
        self._letters = {key: key if key in entries else key.lower() for key in MATRICES
                         if key in entries or (matrices and key in letters and key.lower() in entries)}
        self._meanings: dict[str, list[str]] = {}
        for key in entries:
            if key not in self._letters.values() and (what := meaning(key, matrices)):
                self._meanings.setdefault(what, []).append(key)

    # --- what is there ---------------------------------------------------------------------------------------------
    def has(self, letter: str) -> bool:
        """Whether there is a matrix of that letter, in upper or in lower case; null is none."""
        return letter in self._letters and self._entries[self._letters[letter]] is not None

    def holds(self, key: str) -> bool:
        """Whether there is a variable of exactly that name."""
        return self._entries.get(key) is not None

    def key(self, letter: str) -> str:
        """The letter of a matrix as the file writes it."""
        return self._letters.get(letter, letter)

    def rest(self) -> list[str]:
        """The names that nothing has used yet."""
        return [key for key in self._entries if key not in self._used]

    def use(self, key: str) -> Entry:
        """The value of exactly that name; it counts as used."""
        self._used.add(key)
        return self._entries[key]

    def matrix(self, letter: str, lying: bool = False) -> tuple[np.ndarray, str]:
        """The matrix of that letter, 0×0 where there is none, and its name in the file. Raises EngineError."""
        if letter not in self._letters:
            return np.zeros((0, 0)), letter
        key = self._letters[letter]
        return matrix(self.use(key), key, lying), key

    def keys(self, what: str) -> list[str]:
        """The names in the file of a thing with several spellings."""
        return [key for key in self._meanings.get(what, []) if self._entries[key] is not None]

    def fitting(self, what: str, *kinds: type) -> list[str]:
        """The same, without what is of another kind in a workspace, where a name may mean anything."""
        keys = self.keys(what)
        return [key for key in keys if isinstance(self._entries[key], kinds)] if self._workspace else keys

    def take(self, what: str, default: Entry) -> Entry:
        """The value of a thing that may stand once. Raises EngineError where it stands under two names."""
        self._used.update(self._meanings.get(what, []))
        keys = self.keys(what)
        if len(keys) > 1 and not all(_alike(self._entries[key], self._entries[keys[0]]) for key in keys):
            raise _twice(keys)
        return self._entries[keys[0]] if keys else default

    # --- time ------------------------------------------------------------------------------------------------------
    def period(self) -> float:
        """The sampling period in s, 0 where time is continuous. Raises EngineError where it is unclear or in another unit."""
        self._refuse_units_of_time()
        self._used.update(self._meanings.get("period", []))
        given: dict[str, float] = {}
        for key in self.keys("period"):
            value = self._entries[key]
            if (isinstance(value, list) and not value) or (isinstance(value, np.ndarray) and not value.size):
                continue
            given[key] = _period(scalar(value, key), key)
        if len(set(given.values())) > 1:
            raise _twice(list(given))
        self._refuse_rates(given)
        return next(iter(given.values()), 0.0)

    def _refuse_units_of_time(self) -> None:
        for key in self._meanings.get("time_unit", []):
            unit = self.use(key)
            if unit is not None and (not isinstance(unit, str) or unit.lower() not in _SECONDS):
                raise EngineError("{key} must be seconds; convert A, B and the sampling period to seconds.", key=key)

    def _refuse_rates(self, period: Mapping[str, float]) -> None:
        """A rate, or a bare h, may be meant as the period: it is named, unless the period that is given agrees."""
        for key, value in self._entries.items():
            if not (plain(key) in RATES or key == "h") or key in self._used or not _one_number(value):
                continue
            number = scalar(value, key)
            said = number if key == "h" else 1 / number if number else np.inf
            if any(abs(said - one) <= 1e-9 * abs(one) for one in period.values()):
                self._used.add(key)
            elif key == "h":
                raise EngineError("h may be a sampling period: call it Ts if it is one, and remove it if not.")
            else:
                raise EngineError("{key} is a sampling rate; give the sampling period in seconds as Ts instead.", key=key)

    def delays(self, m: int, p: int) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
        """Delays of the inputs (m,) and of the outputs (p,), empty where there are none, and their names. Raises EngineError."""
        names = [next(iter(self.keys(what)), what) for what in ("input_delay", "output_delay")]
        inputs, outputs = (vector(self.take(what, None), name) for what, name in zip(("input_delay", "output_delay"), names, strict=True))
        both = self.take("io_delay", None)
        if both is not None:
            key = self.keys("io_delay")[0]
            through = matrix(both, key)
            if through.size and np.any(through):
                if inputs.any() or outputs.any():
                    raise _twice([key, names[0] if inputs.any() else names[1]])
                return (*_by_channel(through, m, p, key), (key, key))
        return inputs, outputs, (names[0], names[1])

    # --- what is left ----------------------------------------------------------------------------------------------
    def refuse_the_rest(self) -> None:
        """Raises EngineError for what changes a plant and is not supported and, outside a workspace, for a key that is not known."""
        for key in self.rest():
            if plain(key) in NOT_SUPPORTED and not _nothing(self._entries[key]):
                raise EngineError("{key} is not supported: the lab takes plants without internal delays and offsets; remove it.",
                                  key=key[:40])
            if self._workspace or self._null(key) or plain(key) in HARMLESS | NOT_SUPPORTED or (key == "K" and self.has("A")):
                continue
            raise EngineError("The key {key} is not used here; remove it, or call it comment if it is one.", key=key[:40])

    def not_used(self) -> list[str]:
        """The names that stand in the file, mean something there, and are not used."""
        return [key for key in self.rest() if plain(key) not in HARMLESS | NOT_SUPPORTED and not self._null(key)
                and not (key == "K" and self.has("A"))]  # a gain beside A, B, C says nothing about the plant

    def _null(self, key: str) -> bool:
        """Whether a key that has a meaning here holds nothing at all."""
        return self._entries[key] is None and any(key in keys for keys in (*self._meanings.values(), self._letters.values()))

    def nothing(self) -> EngineError:
        """What to say where there is neither A nor a transfer function."""
        for name, value in self._entries.items():
            if isinstance(value, Unread) and value.what == OBJECT:
                return EngineError("{name} is an object of MATLAB's class {of}, which only MATLAB opens; save its matrices there: {line}.",
                                   name=name[:40], of=value.of[:40] or "?",
                                   line=f"[A,B,C,D]=ssdata({name[:40]}); Ts={name[:40]}.Ts; save('plant.mat','A','B','C','D','Ts','-v7')")
        if "y" in self._entries and ("t" in self._entries or "u" in self._entries):
            return EngineError("This file holds a record (t, u, y) and no plant; a record opens in lesson record with --data.")
        return EngineError("The file has no matrix {missing}; a plant needs A, B and C (D may be left out).", missing="A")


def _twice(keys: list[str]) -> EngineError:
    return EngineError("{one} and {other} say different things; keep one of the two.", one=keys[0], other=keys[1])


def _period(value: float, key: str) -> float:
    if value == -1 and plain(key) == "ts":  # as MATLAB writes it
        raise EngineError("{key} is −1, a sampling period that is not specified; give it in seconds, or 0 for a continuous plant.", key=key)
    if not np.isfinite(value) or value < 0:
        raise EngineError("{key} must be 0 (continuous time) or a positive sampling period in seconds.", key=key)
    return value


def _one_number(value: Entry) -> bool:
    return (isinstance(value, np.ndarray) and value.size == 1) or (isinstance(value, int | float) and not isinstance(value, bool))


def _alike(one: Entry, two: Entry) -> bool:
    return np.array_equal(one, two) if isinstance(one, np.ndarray) and isinstance(two, np.ndarray) else one == two


def _nothing(value: Entry) -> bool:
    """Whether a value is empty or zero, and so says nothing."""
    if isinstance(value, np.ndarray):
        return not np.any(value)
    if isinstance(value, list):
        return all(map(_nothing, value))
    return not value if isinstance(value, str | int | float | Mapping) or value is None else False


def _by_channel(through: np.ndarray, m: int, p: int, key: str) -> tuple[np.ndarray, np.ndarray]:
    """A p×m matrix of delays as delays of the inputs, or of the outputs. Raises EngineError where it is neither."""
    if through.size == 1:
        return np.full(m, through.item()), np.zeros(0)
    if through.shape == (p, m):
        if np.all(through == through[:1]):
            return through[0], np.zeros(0)
        if np.all(through == through[:, :1]):
            return np.zeros(0), through[:, 0]
    raise EngineError("{key} differs from channel to channel; give one delay for each input or each output, as InputDelay or OutputDelay.",
                      key=key)


def plain(key: str) -> str:
    """A key without its case, dashes, underscores and blanks: sampling_period and SamplingPeriod are one."""
    return _OF_FREE_CASE.sub("", key).lower()


def meaning(key: str, matrices: bool) -> str:
    """What a key means, "" where that is not known. Beside `matrices` A, B, C a z, p or k is not a zero, a pole or a gain."""
    found = MEANINGS.get(plain(key), "")
    return "" if matrices and found in _ONLY_WITHOUT_A else found
