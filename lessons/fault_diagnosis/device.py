"""Give the bank of lesson 17 to a device, with its window, threshold and signature."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, DeviceError, bank_routine
from observer_lab.plants.platform.model import SENSOR_IDS
from observer_lab.text import text

from .diagnosis import ENERGY
from .observer_bank import COIL_IDS, DT, MEMBER_NAMES, guard
from .results import Study
from .runs import drawn

BANK_PERIOD = text("The bank is made for {dt:.6g} s; leave the period out.")


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The bank on the run with its fault; the page shows each member's statistic over its threshold. Raises DeviceError."""
    if ts is not None and abs(ts - DT) > 1e-9 * DT:
        raise DeviceError(BANK_PERIOD.format(dt=DT))
    study, bank = outcome.study, guard().bank
    test, record = study.test, study.record
    start = drawn(int(outcome.design["seed"])).bank
    routine = bank_routine(bank.system, len(bank.members), bank.signature, test.threshold, test.window, test.statistic == ENERGY, start,
                           (MEMBER_NAMES, COIL_IDS, SENSOR_IDS))
    page = study.verdict.values * test.threshold
    page = np.where(np.arange(len(page))[:, None] < test.window - 1, np.nan, page)
    return DeviceDesign(routine, record.y, record.asked, None, page, "statistic")
