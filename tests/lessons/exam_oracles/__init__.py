"""The answer of every exam from the numbers that it gives, by code that shares nothing with the lessons."""

from . import beyond, estimation, first_lessons, platform

ORACLES = first_lessons.ORACLES | estimation.ORACLES | platform.ORACLES | beyond.ORACLES
