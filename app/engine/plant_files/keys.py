"""Say what each key of a plant's file means: used, harmless, or not supported."""

from __future__ import annotations

import re
from types import MappingProxyType

__all__ = ["HARMLESS", "MATRICES", "MEANINGS", "NOT_SUPPORTED", "RATES", "meaning", "plain"]

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


def plain(key: str) -> str:
    """A key without its case, dashes, underscores and blanks: sampling_period and SamplingPeriod are one."""
    return _OF_FREE_CASE.sub("", key).lower()


def meaning(key: str, matrices: bool) -> str:
    """What a key means, "" where that is not known. Beside `matrices` A, B, C a z, p or k is not a zero, a pole or a gain."""
    found = MEANINGS.get(plain(key), "")
    return "" if matrices and found in _ONLY_WITHOUT_A else found
