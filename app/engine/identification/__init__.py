"""Make a filter from a record: read it, fit plant and noises to one part, judge by the other."""

from ..systems.gates.room_gates import with_gates
from .bias import sensor_bias
from .identified import FilteredRecord, FittedFilter, RecordFit, SensorBias, filter_record, fit_noise, identify
from .known_plant import filter_plant
from .reading.files import Column, RecordPreview, load_record, preview_record, read_record
from .records import Record
from .regular import Trend, detrend, resample, split_record, trend_of
from .smoother import Smoothed
from .subspace import Subspace, subspace

__all__ = [
    "Column",
    "FilteredRecord",
    "FittedFilter",
    "Record",
    "RecordFit",
    "RecordPreview",
    "SensorBias",
    "Smoothed",
    "Subspace",
    "Trend",
    "detrend",
    "filter_plant",
    "filter_record",
    "fit_noise",
    "identify",
    "load_record",
    "preview_record",
    "read_record",
    "resample",
    "sensor_bias",
    "split_record",
    "subspace",
    "trend_of",
]

with_gates(globals())
