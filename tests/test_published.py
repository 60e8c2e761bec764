"""Published values: every verdict holds, slips are told apart from agreement, and the judge itself can say no."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from laws import holds_for_all
from scipy.signal import place_poles

from observer_lab.published import Published, records, table, verify_all, verify_one
from observer_lab.published.classics import gain_limit
from observer_lab.published.notes import SPRING, gain, rest_of_printed_observer
from observer_lab.published.record import half_a_digit, numbers

RECORDS = records()


def called(published: Published) -> str:
    return f"{published.source}: {published.item}"


def against(published: Published) -> str:
    """What our value is compared with."""
    return published.printed if published.kind == "agrees" and numbers(published.printed) else published.right


@pytest.mark.slow
def test_every_verdict_on_a_published_value_holds() -> None:
    def law(published: Published) -> None:
        result = verify_one(published)
        assert result.holds, f"expected {published.kind}, ours {result.ours}"
        assert result.verdict == published.kind
    holds_for_all(RECORDS, law, called)


def test_a_record_compares_something_and_says_why_it_calls_a_slip() -> None:
    def law(published: Published) -> None:
        assert numbers(against(published))
        assert published.kind != "slip" or published.note
    holds_for_all(RECORDS, law, called)


def test_ours_moved_by_one_printed_digit_is_refused() -> None:
    def law(published: Published) -> None:
        step = 2.1 * half_a_digit(numbers(against(published))[0])
        moved = replace(published, ours=lambda: np.asarray(published.ours(), dtype=float).ravel() + step)
        assert not verify_one(moved).holds
    holds_for_all([p for p in RECORDS if p.tolerance is None and p.relative is None], law, called)


def test_every_source_and_every_slip_of_the_spring_damper_is_covered() -> None:
    assert {p.source for p in RECORDS} == {"000 tutorial", "001 observer notes", "002 robust observer",
                                           "003 platform report",
                                           "004 bilinear functional observer", "Doyle 1978", "MATLAB kalman",
                                           "Chen & Patton 1999", "χ² table",
                                           "scalar plant, lossy measurements", "Sinopoli et al. 2004",
                                           "EKF/UKF toolbox 2011", "Julier 2000", "maxon RE 40, 148867"}
    slips = {p.printed for p in RECORDS if p.source.startswith("001") and p.kind == "slip"}
    assert {"2, 1", "2.5, -1.25", "-2.5 1; -0.25 -0.5", "1, 0"} <= slips
    assert len({(p.source, p.item) for p in RECORDS}) == len(RECORDS)


def test_a_slip_that_our_engine_repeats_is_no_slip() -> None:
    repeated = Published("s", "i", "2.5", lambda: 2.5, "slip", "2.5", note="n")
    assert not verify_one(repeated).holds


def test_a_missing_value_or_a_wrong_count_differs() -> None:
    assert not verify_one(Published("s", "i", "1, 2", lambda: 1.0)).holds
    assert not verify_one(Published("s", "i", "1.0", lambda: float("nan"))).holds
    assert verify_one(Published("s", "i", "1.0", lambda: float("nan"))).record()["ours"] == [None]


def test_printed_digits_set_the_tolerance() -> None:
    assert numbers("572.7565, −0.0001; 4e-4 2.5E1".replace("E", "e")) == ("572.7565", "-0.0001", "4e-4", "2.5e1")
    assert numbers("near 1–2 Hz") == ()
    assert half_a_digit("0.0539") == pytest.approx(5e-5)
    assert half_a_digit("1.771e-4") == pytest.approx(5e-8)
    assert half_a_digit("2") == 1e-9


def test_the_gain_that_scipy_refuses_to_find_is_exact() -> None:
    with pytest.raises(ValueError):
        place_poles(SPRING.A.T, SPRING.C.T, [-1, -1])
    assert np.abs(gain().ravel() - (1.5, -0.75)).max() < 1e-12


def test_rest_of_the_printed_observer_by_hand() -> None:
    # 0 = F z + (0, 1) u + (2.5, −1.25) y with u = y = 1, F as printed, in exact arithmetic.
    F = mpmath.matrix([["-2.5", "1"], ["-0.25", "-0.5"]])
    z = mpmath.lu_solve(F, mpmath.matrix(["-2.5", "0.25"]))
    assert np.abs(rest_of_printed_observer() - [float(z[0]), float(z[1])]).max() < 1e-9
    assert (float(z[0]), float(z[1])) == pytest.approx((2 / 3, -5 / 6))


@pytest.mark.parametrize(("q", "sigma"), [(1, 1), (5, 12), (60, 60), (1000, 200)])
def test_doyle_the_gain_margin_vanishes_as_the_formula_says(q: float, sigma: float) -> None:
    f, d = (2 + float(mpmath.sqrt(4 + value)) for value in (q, sigma))
    assert gain_limit(q, sigma) == pytest.approx(1 + 1 / (d * f), abs=1e-9)


def test_the_table_names_every_slip_and_counts_what_differs() -> None:
    wrong = Published("s", "an item", "1.0", lambda: 3.0)
    text = table(verify_all([*RECORDS[:12], wrong]))
    for published in RECORDS[:12]:
        assert published.item in text
        assert published.kind != "slip" or published.note in text
    assert "DIFFERS" in text and "1 not as expected" in text
