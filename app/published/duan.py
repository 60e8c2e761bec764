"""Check source 002, robust Luenberger observer: examples, optimum in each norm, slips.

The source has u = +K x; its K, N and M are compared in its own sign.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from ..engine import EngineError, functional_observer, rlo, simulate_functional
from ..engine.observers import FunctionalObserver, Region, RobustObserver, existence, perturbed_loop, vertices, worst_error_gain
from ..engine.structure import coprime_factors
from ..plants.duan import EXAMPLE_1, EXAMPLE_2, outer_input
from ..plants.two_carts import CARTS, directions
from .record import Published

SOURCE = "002 robust observer"
BEST_POLE = -5 / 3
PAIR = (-4.0, -3.0)  # the source does not print the s1, s2 of its figure 2
LAMBDA = np.array([[2.0, 1.0], [0.5, -1.0]])  # Λ of remark 3


def first(s: float, norm: Any = 2) -> FunctionalObserver:
    """Example 1 with its pole at s, in the source's sign."""
    return functional_observer(EXAMPLE_1.plant, EXAMPLE_1.K_printed, 1, poles=[s], wrong=EXAMPLE_1.wrong, norm=norm)


def second(W: Any = None, poles: tuple[float, float] = PAIR) -> FunctionalObserver:
    """Example 2 in the source's sign."""
    return functional_observer(EXAMPLE_2.plant, EXAMPLE_2.K_printed, 2, poles=poles, W=W, wrong=EXAMPLE_2.wrong)


def house(example: Any, poles: Any, W: Any = None) -> FunctionalObserver:
    """The observer in our sign, which the loops need."""
    return functional_observer(example.plant, example.K, len(poles), poles=poles, W=W, wrong=example.wrong)


def matrices(o: FunctionalObserver) -> np.ndarray:
    """F, T, L, N, M in one row."""
    return np.concatenate([m.ravel() for m in (o.F, o.T, o.L, o.N, o.M)])


def factors() -> np.ndarray:
    """H(s) and L(s) of example 1: coefficients in ascending powers."""
    f = coprime_factors(EXAMPLE_1.plant)
    return np.concatenate([f.H[:, :, 0].ravel(), f.L.ravel()])


def closed_poles(example: Any) -> tuple[float, ...]:
    """eig(A + BK) as real parts, then the imaginary parts that are positive."""
    values = np.linalg.eigvals(example.plant.A + example.plant.B @ example.K_printed)
    return (*np.sort(values.real), *values.imag[values.imag > 1e-9])


@lru_cache(maxsize=8)
def best(example: int, norm: Any) -> RobustObserver:
    """RLO: example 1 with Re s ≤ −0.004 (the default region), example 2 with Re s ≤ −2."""
    if example == 1:
        return rlo(EXAMPLE_1.plant, EXAMPLE_1.K, wrong=EXAMPLE_1.wrong, norm=norm)
    return rlo(EXAMPLE_2.plant, EXAMPLE_2.K, wrong=EXAMPLE_2.wrong, norm=norm, region=Region(-20, -2),
               worst_condition=1e6)


def optimum_1(norm: Any) -> tuple[float, float]:
    """s and J where RLO finds the least J."""
    found = best(1, norm)
    return float(found.observer.poles[0].real), found.value


def falls_then_rises() -> tuple[float, float]:
    """1 if J falls strictly up to −5/3, and 1 if it rises strictly after."""
    left, right = ([first(s).J for s in np.linspace(*ends, 40)] for ends in ((-12, BEST_POLE), (BEST_POLE, -0.01)))
    return float(np.all(np.diff(left) < 0)), float(np.all(np.diff(right) > 0))


def starts() -> tuple[float, ...]:
    """e_u(0): s = −5/3 on the model, s = −5 on the model and on the true plant."""
    E = EXAMPLE_1
    values = []
    for s, dA, dC in ((BEST_POLE, None, None), (-5.0, None, None), (-5.0, E.dA, E.dC)):
        run = simulate_functional(house(E, [s]), outer_input, x0=E.x0, z0=E.z0, horizon=0.1, dA=dA, dC=dC)
        values.append(float(run.e_u[0, 0]))
    return tuple(values)


def amplitude(s: float) -> float:
    """Steady amplitude of e_u on the true plant of figure 1 under v = −4 sin(5t + π/2)."""
    loop = perturbed_loop(house(EXAMPLE_1, [s]), dA=EXAMPLE_1.dA, dB=None, dC=EXAMPLE_1.dC)
    return float(4 * np.abs(loop.C @ np.linalg.solve(5j * np.eye(loop.n) - loop.A, loop.B))[0, 0])


def true_loop_poles(s: float) -> tuple[float, ...]:
    """Poles of the loop with the true plant of figure 1: the pair's Re and Im, then the real one."""
    poles = perturbed_loop(house(EXAMPLE_1, [s]), dA=EXAMPLE_1.dA, dB=None, dC=EXAMPLE_1.dC).poles
    pair, real = next(p for p in poles if p.imag > 0), next(p for p in poles if abs(p.imag) < 1e-9)
    return float(pair.real), float(pair.imag), float(real.real)


def worst(s: float) -> float:
    """Largest ‖v → e_u‖_∞ over the eight sign patterns of the δ of figure 1."""
    return worst_error_gain(house(EXAMPLE_1, [s]), vertices(EXAMPLE_1.wrong, EXAMPLE_1.delta_A, EXAMPLE_1.delta_C))


def printed_2(W: np.ndarray) -> float:
    """Largest distance of our F, T, L, N, M from the printed formulas of example 2, relative."""
    (s1, s2), back = PAIR, np.linalg.inv(W)
    k0, k1, k2, a0, a1, a2 = -4.0, -4.0, -1.0, 0.0, 2.0, 3.0
    T = W @ np.array([[s * s + a2 * s + a1, s + a2, 1] for s in PAIR])
    L = W @ np.array([[-(s**3 + a2 * s * s + a1 * s + a0)] for s in PAIR])
    N = np.array([[k2 * (s2 + a2) - k1, k1 - k2 * (s1 + a2)]]) / (s2 - s1) @ back
    M = k0 - k1 * (s1 + s2 + a2) + k2 * ((s1 + a2) * (s2 + a2) - a1)
    source = np.concatenate([v.ravel() for v in (W @ np.diag(PAIR) @ back, T, L, N, np.array([M]))])
    return float(np.abs(matrices(second(W)) - source).max() / np.abs(source).max())


def equal_poles() -> float:
    """1 if s1 = s2 is refused."""
    try:
        second(poles=(-3.0, -3.0))
    except EngineError:
        return 1.0
    return 0.0


def felt_change() -> tuple[float, float]:
    """How far W moves the poles of the true loop, and e_u on the model when z(0) goes along as W z(0)."""
    E = EXAMPLE_2
    assert E.turn is not None
    plain, turned = house(E, PAIR), house(E, PAIR, E.turn)
    loops = [perturbed_loop(o, dA=E.dA, dB=None, dC=E.dC).poles for o in (plain, turned)]
    runs = [simulate_functional(o, outer_input, x0=E.x0, z0=z0)
            for o, z0 in ((plain, np.array(E.z0)), (turned, E.turn @ np.array(E.z0)))]
    return float(np.abs(loops[0] - loops[1]).max()), float(np.abs(runs[0].e_u - runs[1].e_u).max())


def change_by_start() -> float:
    """e_u(0) for W = I less e_u(0) for the W of figure 2, both from the printed z(0), with our s1, s2."""
    E = EXAMPLE_2
    values = [simulate_functional(house(E, PAIR, W), outer_input, x0=E.x0, z0=E.z0, horizon=0.1).e_u[0, 0]
              for W in (None, E.turn)]
    return float(values[0] - values[1])


def remark_3(F: np.ndarray, T: np.ndarray, L: np.ndarray, N: np.ndarray, M: np.ndarray) -> float:
    """How far five matrices miss T A − F T = L C and K = N T + M C of example 2, the larger."""
    p, K = EXAMPLE_2.plant, EXAMPLE_2.K_printed
    return float(max(np.abs(T @ p.A - F @ T - L @ p.C).max(), np.abs(K - N @ T - M @ p.C).max()))


def right_remark_3() -> float:
    """(ΛFΛ⁻¹, ΛT, ΛL, NΛ⁻¹, M)."""
    o, back = second(), np.linalg.inv(LAMBDA)
    return remark_3(LAMBDA @ o.F @ back, LAMBDA @ o.T, LAMBDA @ o.L, o.N @ back, o.M)


def free_columns() -> int:
    """Columns of M′: dependences among the rows of [T; C]."""
    rows = np.vstack([second().T, EXAMPLE_2.plant.C])
    return int(len(rows) - np.linalg.matrix_rank(rows))


def stable_poles_needed() -> int:
    """Of how many poles of an observer of order 2 the unstable value +1 is refused."""
    refused = 0
    for i in range(2):
        poles = list(PAIR)
        poles[i] = 1.0
        try:
            second(poles=(poles[0], poles[1]))
        except EngineError:
            refused += 1
    return refused


def carts(*poles: complex) -> FunctionalObserver:
    """The observer of the two carts with these poles; L takes no reading of the tachometer."""
    return functional_observer(CARTS.plant, CARTS.K, len(poles), poles=poles, directions=directions(poles), wrong=CARTS.wrong)


def carts_at(re: float, im: float) -> FunctionalObserver:
    """The same with a complex pair."""
    return carts(complex(re, -im), complex(re, im))


def carts_miss() -> float:
    """How far the pair −0.5 ± 2j misses T A − F T = L C and K = N T + M C, relative, the larger."""
    o = carts_at(-0.5, 2.0)
    return max(o.dynamics_residual, o.output_residual)


def least_pair(tall: float) -> tuple[float, float, float]:
    """Re s, |Im s| and J of the best pair on a grid over −10 ≤ Re s ≤ −0.5 and |Im s| ≤ tall."""
    J, re, im = min((carts_at(re, im).J, re, im) for re in -np.geomspace(0.5, 10, 12) for im in np.linspace(tall / 8, tall, 8))
    return re, im, J


def order_of_carts() -> tuple[float, float]:
    """How far one state misses K, relative, at the left end −10 of the rectangle and at −11."""
    return tuple(existence(CARTS.plant, CARTS.K, [s]).missed for s in (-10.0, -11.0))  # type: ignore[return-value]


NORMS = ((1, "1"), (2, "2"), ("inf", "∞"))
FORMULAS = "F = s, T = [1 s], L = −s² − 4s − 3, N = −30, M = 50 + 30s"
BOX = {1: "11", 2: "9.828427", "inf": "9"}.items()
RECORDS = (
    Published(SOURCE, "example 1: H(s), L(s), ascending", "", factors, "beyond", "1, 0, 0, 1, 3, 4, 1", tolerance=1e-9),
    Published(SOURCE, "example 1: eig(A + BK), Re, Re, Im", "", lambda: closed_poles(EXAMPLE_1), "beyond", "-7, -7, 2",
              tolerance=1e-9),
    *(Published(SOURCE, f"example 1: F, T, L, N, M at s = {s:g}", FORMULAS, lambda s=s: matrices(first(s)), right=right,
                tolerance=1e-9)
      for s, right in ((-5.0, "-5, 1, -5, -8, -30, -100"), (-1.0, "-1, 1, -1, 0, -30, 20"),
                       (-10.0, "-10, 1, -10, -63, -30, -250"))),
    *(Published(SOURCE, f"example 1: optimum found by RLO, norm {name}: s", "s = −5/3", lambda n=norm: optimum_1(n)[0],
                right="-1.6666666667", tolerance=1e-6) for norm, name in NORMS),
    *(Published(SOURCE, f"example 1: J there, norm {name}", "", lambda n=norm: optimum_1(n)[1], "beyond",
                "4.2222222222", tolerance=1e-5, note="38/9") for norm, name in NORMS),
    *(Published(SOURCE, f"example 1: J at −1, −3, −5, −10, norm {name}", "",
                lambda n=norm: [first(s, n).J for s in (-1, -3, -5, -10)], "beyond", "22, 46, 118, 333")
      for norm, name in NORMS),
    Published(SOURCE, "example 1: J falls up to −5/3, rises after", "worse the farther left of −5/3", falls_then_rises,
              right="1, 1"),
    Published(SOURCE, "figure 1: e_u(0) at −5/3, at −5, at −5 perturbed", "", starts, "beyond", "-11, -111, -116"),
    Published(SOURCE, "figure 1: steady amplitude of e_u, perturbed, s = −5/3", "", lambda: amplitude(BEST_POLE), "beyond",
              "0.431366"),
    Published(SOURCE, "figure 1: steady amplitude of e_u, perturbed, s = −5", "", lambda: amplitude(-5.0), "beyond",
              "0.941342"),
    Published(SOURCE, "figure 1: poles of the perturbed loop, s = −5/3", "", lambda: true_loop_poles(BEST_POLE), "beyond",
              "-7.1676, 2.5373, -1.7315"),
    Published(SOURCE, "figure 1: poles of the perturbed loop, s = −5", "", lambda: true_loop_poles(-5.0), "beyond",
              "-3.2126, 2.7363, -17.9748"),
    Published(SOURCE, "worst |e_u/v| of the eight vertices at −1.3 and −5/3", "",
              lambda: (worst(-1.3), worst(BEST_POLE)), "beyond", "0.820, 0.874", note="−5/3 is good, not optimal"),
    Published(SOURCE, "example 2: eig A", "", lambda: np.real(EXAMPLE_2.plant.poles), "beyond", "-2, -1, 0",
              tolerance=1e-9),
    Published(SOURCE, "example 2: eig(A + BK), Re, Re, Re, Im", "", lambda: closed_poles(EXAMPLE_2), "beyond",
              "-2, -1, -1, 1", tolerance=1e-9),
    *(Published(SOURCE, f"example 2: F, T, L, N, M against the formulas, {name}", "formulas",
                lambda W=W: printed_2(np.asarray(W)), right="0", tolerance=1e-9) for name,
                W in (("W = I", np.eye(2)), ("W = [1 1.2; 0 1]", EXAMPLE_2.turn))),
    Published(SOURCE, "example 2: M = 1 + s1 + s2 − s1 s2 at −4, −3", "", lambda: second().M, "beyond", "-18",
              tolerance=1e-9),
    Published(SOURCE, "example 2: s1 = s2 is refused", "s1 and s2 differ", equal_poles, right="1"),
    *(Published(SOURCE, f"example 2: least J for Re s up to −2, norm {'∞' if norm == 'inf' else norm}", "",
                lambda n=norm: best(2, n).value, "beyond", right, tolerance=1e-3,
                note="the poles run together and N grows without bound; the norms differ") for norm, right in BOX),
    Published(SOURCE, "figure 2: W moves loop poles, and e_u from W z(0), by", "W can suppress perturbations",
              felt_change, "slip", "0, 0", tolerance=1e-8, note="W only changes the observer's coordinates"),
    Published(SOURCE, "figure 2: e_u(0) for W = I less that for its W, same z(0), s = −4, −3", "", change_by_start,
              "beyond", "10.512", tolerance=1e-9,
              note="N(I − W⁻¹)z(0) = 4 · 1.2 · 2.19: the figure's contrast comes from reusing z(0)"),
    Published(SOURCE, "example 2: size of LΔC", "2, 2", lambda: (second().L @ EXAMPLE_2.dC).shape, "slip", "2, 3",
              note="LΔC is 2×3; a column of zeros is missing in print"),
    Published(SOURCE, "remark 3: the transformed observer misses its conditions by", "(F, ΛF, ΛL, ΛNΛ⁻¹, M)",
              right_remark_3, "slip", "0", tolerance=1e-9, note="must read (ΛFΛ⁻¹, ΛT, ΛL, NΛ⁻¹, M)"),
    Published(SOURCE, "columns of M′, printed n + p − r*, in example 2", "2", free_columns, "slip", "0",
              note="M′ has m + p − r* columns"),
    Published(SOURCE, "C1: number of poles that must be stable at order 2", "Re s_i < 0 for i up to l",
              stable_poles_needed, "slip", "2", note="i runs over the p poles, not over the l perturbations"),
    Published(SOURCE, "two carts: pair −0.5 ± 2j misses both conditions by", "(2b), (2c)", carts_miss, right="0", tolerance=1e-9,
              note="two outputs and complex poles; the paper has no such example"),
    Published(SOURCE, "two carts: one state misses K at −10 and at −11 by", "", order_of_carts, "beyond", "0.00593, 0",
              note="the left end −10 of C′1 makes RLO raise the order to two"),
    Published(SOURCE, "two carts: best pair for Im s up to 1.5, and J", "C′1 bounds Re s and Im s", lambda: least_pair(1.5),
              right="-0.5, 1.5, 2.341230", tolerance=1e-6, note="it stands at both bounds"),
    Published(SOURCE, "two carts: best pair for Im s up to 4, and J", "C′1 bounds Re s and Im s", lambda: least_pair(4.0),
              right="-0.5, 2, 1.335646", tolerance=1e-6, note="the bound on Im s no longer counts"),
    Published(SOURCE, "two carts: M of the tachometer at −0.5 ± 1.5j, −0.5 ± 2j", "",
              lambda: [round(carts_at(-0.5, im).M[0, 1], 9) for im in (1.5, 2.0)], "beyond", "-1.5555556, 0", tolerance=1e-6),
)
