"""Two faults at once: which pairs can be told apart, by exact arithmetic, and what the bank of pairs says of runs."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest

from observer_lab.engine.observers import needed_noncentrality
from observer_lab.lessons.fault_diagnosis.diagnosis import Rule
from observer_lab.lessons.fault_diagnosis.fault_pairs import (
    ALWAYS_ISOLABLE,
    NEVER_ISOLABLE,
    PAIRS,
    SETS,
    due,
    isolable,
    judge_pairs,
    pair_bank,
    pattern,
    rank_of,
    rivals,
)
from observer_lab.lessons.fault_diagnosis.lesson import LESSON
from observer_lab.lessons.fault_diagnosis.observer_bank import DT, FAULT_PLACES, SAMPLE_COUNT, guard, model
from observer_lab.lessons.fault_diagnosis.runs import KEEP_LOOP_OPEN, Case, Fault, drawn, quiet, simulate
from observer_lab.lessons.fault_diagnosis.sensitivity import least, least_beside

Z = 3  # a point at which directions are compared exactly: neither pole nor zero


def exact_rank(faults: tuple[int, ...]) -> int:
    """Rank of the fault directions, from that of Rosenbrock's pencil [A − zI, −B; C, I] in whole numbers, by Bareiss's elimination."""
    kf = model()
    p, n = kf.C.shape
    rows = [[Fraction(float(v)) - (Z if i == j else 0) for j, v in enumerate(row)] for i, row in enumerate(kf.A)]
    rows += [[Fraction(float(v)) for v in row] for row in kf.C]
    for f in faults:
        for i in range(n + p):
            rows[i].append(Fraction(int(i - n == f)) if f < p else Fraction(-float(kf.B[i, f - p])) if i < n else Fraction(0))
    scale = max(v.denominator for row in rows for v in row)  # powers of two
    M, rank, last = [[int(v * scale) for v in row] for row in rows], 0, 1
    for column in range(n + len(faults)):
        pivot = next((i for i in range(rank, n + p) if M[i][column]), None)
        if pivot is None:
            continue
        M[rank], M[pivot] = M[pivot], M[rank]
        head = M[rank]
        for i in range(rank + 1, n + p):
            M[i] = [(head[column] * a - M[i][column] * b) // last for a, b in zip(M[i], head, strict=True)]
        rank, last = rank + 1, head[column]
    return rank - n


def test_ranks_are_those_of_exact_arithmetic_and_so_is_what_can_be_told_apart() -> None:
    exact = {frozenset(s): exact_rank(s) for size in (1, 2, 3, 4) for s in combinations(range(7), size)}
    assert {s: rank_of(s) for s in exact} == exact
    five = {FAULT_PLACES.index(k) for k in ("VL", "VR", "u1", "u2", "u3")}  # none of them moves HL + HR
    assert {s for s in exact if exact[s] < len(s)} == {s for s in exact if len(s) == 4 and s < five}
    for p in PAIRS:
        assert set(rivals()[p]) == {q for q in PAIRS if q != p and exact[frozenset(p + q)] < len({*p, *q})}
        assert isolable(p) != NEVER_ISOLABLE and (isolable(p) == ALWAYS_ISOLABLE) == (not five.issuperset(p)), p


def test_each_set_of_faults_has_a_column_of_its_own_in_the_bank_of_pairs() -> None:
    assert pair_bank().dof == 2
    for faults, column in zip(SETS, pattern().T, strict=True):
        assert [bool(v) for v in column] == [not set(faults) <= set(pair) for pair in PAIRS], faults


def test_what_a_rival_can_imitate_and_another_pair_cannot() -> None:
    """Forces lost by u1 and u2 that leave HL alone read as lies of VL and VR; no lie of HL and HR reads so."""
    kf, z = model(), np.exp(0.7j)
    G = kf.C @ np.linalg.solve(z * np.eye(6) - kf.A, kf.B)
    y = G[:, :2] @ np.array([G[1, 1], -G[1, 0]])
    assert np.abs(y[[1, 3]]).max() < 1e-9 * np.abs(y[[0, 2]]).max()
    assert (4, 5) in rivals()[0, 2] and not rivals()[1, 3]


@pytest.mark.parametrize("one, other", [(Fault("HL", size=6.0), Fault("VR", size=10.0, at=7.0)),
                                        (Fault("VL", size=20.0, at=4.0), Fault("HR", size=6.0, at=4.0))], ids=["later", "together"])
def test_the_bank_of_pairs_names_both_where_seven_members_can_only_say_that_something_fails(one: Fault, other: Fault) -> None:
    case, wanted = Case(one.place, one.kind, one.size, one.at, loop=KEEP_LOOP_OPEN, also=other), None
    wanted = tuple(sorted(FAULT_PLACES.index(f.place) for f in case.faults))
    for seed in range(6):
        record = simulate(case, drawn(seed))
        found = judge_pairs(Rule(), record, seed)
        assert found.both is not None and found.both[1] == wanted, seed
        assert found.both[0] >= case.faults[-1].start and (found.alone is None or found.alone[1] == (FAULT_PLACES.index(one.place),))
        late = Rule().values(record.residuals)[case.faults[-1].start + 100:] > Rule().threshold
        assert late.all(axis=1).mean() > 0.9 or not late[:, FAULT_PLACES.index(one.place)].any()
    assert due(Rule(), quiet(case), wanted, case.faults[-1].start) is not None
    ignoring = pair_bank().run(quiet(case).y, quiet(case).asked, pair_bank().start(np.zeros(6)))[0][:, PAIRS.index(wanted)]
    assert np.abs(ignoring).max() < 1e-7 * guard().bank.dof * SAMPLE_COUNT


def test_a_second_fault_of_the_same_part_or_of_none_is_no_second_fault_and_order_is_that_of_time() -> None:
    for place, second in (("HL", "HL"), ("none", "VR"), ("HL", "none")):
        case = LESSON.compute(LESSON.apply(LESSON.start(), {"place": place, "place2": second})).study.case
        assert case.also is None
    swapped = LESSON.compute(LESSON.apply(LESSON.start(), {"place2": "u1", "at2": 2.0})).study.case
    assert [f.place for f in swapped.faults] == ["u1", "HL"] and swapped.place == "u1"


def test_two_lies_that_leave_the_sum_at_zero_accuse_a_healthy_coil_and_the_bank_of_pairs_nobody() -> None:
    """The numbers of the task: HR by −3 mm/s with HL; half a millimetre more or less will do, one will not, nor a tenth of a second."""
    task = next(t for t in LESSON.tasks if t.id == "framed")

    def tried(**values: float) -> bool:
        return task.check(LESSON.compute(LESSON.apply(LESSON.start(), {**task.solution, **values}))).solved
    assert [tried(bias2=b) for b in (-4.0, -3.5, -2.5, -2.0)] == [False, True, True, False]
    assert not tried(at2=4.1) and tried(bias=8.0, bias2=-8.0) and not tried(bias=2.5, bias2=-2.5)
    for seed in (1, 2, 3):
        shown = LESSON.compute(LESSON.apply(LESSON.start(), {**task.solution, "seed": seed}))
        verdict = judge_pairs(shown.study.test, shown.study.record, seed)
        assert shown.study.verdict.who == "u3" and "healthy" in shown.live("en") and verdict.both is None and verdict.alone is None
        quiet = {PAIRS[k] for k in np.flatnonzero((verdict.values[400:] < 1).mean(axis=0) > 0.9)}
        assert quiet == {(1, 3), *((i, 6) for i in range(6))}, seed


def test_the_least_faults_that_the_bank_of_pairs_sees_are_those_of_its_responses_and_company_never_helps() -> None:
    """Alone as the table of the seven says; beside another part never smaller but for the degrees of freedom of the noise."""
    test, tone = Rule(), 0.5
    values, seven = least_beside(test, tone), least(test, tone)
    assert np.diag(values) == pytest.approx([seven[:, i][np.isfinite(seven[:, i])].max() for i in range(7)])
    cheaper = np.sqrt(needed_noncentrality(2 * 25, 1e-3, 0.99) / test.needed)
    assert (values >= cheaper * np.diag(values)[:, None] * (1 - 1e-9)).all()
    unseen = {(FAULT_PLACES[i], FAULT_PLACES[j]) for i, j in np.argwhere(values > 1.0) if i < 4}
    assert unseen == {("VL", "VR"), ("VL", "u1"), ("VL", "u2"), ("VR", "VL"), ("VR", "u1"), ("VR", "u2"),
                      ("HL", "HR"), ("HL", "u3"), ("HR", "HL"), ("HR", "u3")}
    shown = LESSON.compute(LESSON.apply(LESSON.start(), {"place2": "VR"}))
    table = next(f for f in LESSON.figures(shown) if f.id == "least-pairs")
    assert "is seen beside" in table.caption("en") and "▶" in table.rows[1][3] and table.rows[1][4] == "∞" and "*" in table.rows[0][3]


def test_the_experiment_that_finds_a_weak_coil_beside_a_liar_is_not_that_which_finds_it_alone() -> None:
    """The numbers of the words; by the members' own residuals in the long run, half a newton is seen at 1.2 Hz and not at 1.4 Hz."""
    task = next(t for t in LESSON.tasks if t.id == "beside")

    def tried(**values: float | str) -> bool:
        return task.check(LESSON.compute(LESSON.apply(LESSON.start(), {**task.solution, **values}))).solved
    assert [tried(tone=f) for f in (1.15, 1.18, 1.22, 1.4, 1.46)] == [False, True, True, False, False]
    assert tried(window=85.0, rate=7.9e-6) and not tried(window=95.0) and not tried(rate=9.5e-6) and not tried(window=70.0, rate=6.3e-6)
    assert not tried(loss=60.0) and not tried(force=0.9) and not tried(place2="VR") and not tried(loop="blind")
    rule, u1, VL = Rule(window=90, rate=8.4e-6), FAULT_PLACES.index("u1"), FAULT_PLACES.index("VL")
    assert [least_beside(rule, f)[u1, k] for f in (1.2, 1.46) for k in (VL, u1)] == pytest.approx([0.47, 0.38, 0.84, 0.31], abs=0.005)
    first = least_beside(Rule(), 0.5)
    assert (first[u1, u1], first[u1, VL]) == pytest.approx((2.69, 16.3), abs=0.005) and round(first[u1, VL] / first[u1, u1]) == 6
    assert 1e3 * first[1, [1, VL]] == pytest.approx([2.72, 2.53], abs=0.005) and first[1, 3] > 1.0
    for tone, seen in ((1.2, True), (1.4, False)):
        u = np.zeros((3000, 3))
        u[:, 0] = 0.5 * np.sin(2 * np.pi * tone * DT * np.arange(len(u)))
        rho = pair_bank().run(np.zeros((len(u), 4)), u, pair_bank().start(np.zeros(6)))[0][1500:]
        weakest = min(float((rho[:, PAIRS.index((VL, k))] ** 2).sum(axis=1).mean()) * 90 for k in range(1, 7) if k != u1)
        assert (weakest >= needed_noncentrality(2 * 90, 8.4e-6, 0.99)) == seen, tone
