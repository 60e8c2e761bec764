"""The examples of the robust observer paper as functional observers."""

from observer_lab.engine import functional_observer
from observer_lab.plants.duan import EXAMPLE_1, EXAMPLE_2

ONE, TWO = EXAMPLE_1.plant, EXAMPLE_2.plant


def one(s, **more):
    """Example 1 in the sign of the source."""
    return functional_observer(ONE, EXAMPLE_1.K_printed, 1, poles=[s], wrong=EXAMPLE_1.wrong, **more)


def two(s1, s2, **more):
    return functional_observer(TWO, EXAMPLE_2.K_printed, 2, poles=[s1, s2], wrong=EXAMPLE_2.wrong, **more)
