"""Give the bank of lesson 17 to a device, or one of its observers alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, DeviceError, bank_routine
from observer_lab.engine.observers import FaultBank
from observer_lab.plants.platform.model import SENSOR_IDS
from observer_lab.text import text

from .diagnosis import ENERGY
from .observer_bank import COIL_IDS, DT, FAULT_PLACES, MEMBER_NAMES, guard
from .results import Study
from .runs import drawn

BANK_PERIOD = text("The bank is made for {dt:.6g} s; leave the period out.")


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The bank on the run with its fault; the page shows each member's statistic over its threshold. Raises DeviceError."""
    bank, start = guard().bank, drawn(int(outcome.design["seed"])).bank
    return _design(outcome, ts, bank, range(len(bank.members)), start, "fault bank")


def _member(place: int, outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The observer of the bank alone that leaves this sensor out, or that this coil's force does not reach: it sees every other fault.

    z⁺ = F z + G u + K y, ρ = W (N y − C z), and its alarm. `fault` is 0 while it is raised, else −1. Raises DeviceError.
    """
    bank = guard().bank
    first = sum(each.size for each in bank.members[:place])
    start = drawn(int(outcome.design["seed"])).bank[first:first + bank.members[place].size]
    kind = "unknown-input observer" if FAULT_PLACES[place] in COIL_IDS else "observer without one sensor"
    return _design(outcome, ts, FaultBank(bank.model, (bank.members[place],)), [place], start, kind)


PARTS: Mapping[str, Callable[[Outcome[Study], float | None], DeviceDesign]] = MappingProxyType(
    {place: partial(_member, k) for k, place in enumerate(FAULT_PLACES)})  # by what each observer ignores


def _design(outcome: Outcome[Study], ts: float | None, bank: FaultBank, members: range | list[int], start: np.ndarray,
            kind: str) -> DeviceDesign:
    if ts is not None and abs(ts - DT) > 1e-9 * DT:
        raise DeviceError(BANK_PERIOD.format(dt=DT))
    study = outcome.study
    test, record = study.test, study.record
    signature = bank.signature if len(members) > 1 else np.ones((1, 1))  # one observer alone tells no fault from another
    routine = bank_routine(bank.system, len(members), signature, test.threshold, test.window, test.statistic == ENERGY, start,
                           ([MEMBER_NAMES[k] for k in members], COIL_IDS, SENSOR_IDS), kind)
    page = study.verdict.values[:, list(members)] * test.threshold
    page = np.where(np.arange(len(page))[:, None] < test.window - 1, np.nan, page)
    return DeviceDesign(routine, record.y, record.asked, None, page, "statistic")
