"""Check source 001, observer notes: a 2×2 plant and the spring-damper with its slips."""

from __future__ import annotations

import numpy as np

from ..engine import Plant, Scenario, observability, observer_gain, simulate
from ..engine.structure import observability_gramian
from ..plants import spring_damper
from .record import Published

SOURCE = "001 observer notes"
EXAMPLE_PLANT = Plant(np.array([[1, 2], [3, 4]]), np.array([[0], [1]]), np.array([[1, 0]]))
SPRING = spring_damper.plant()
PRINTED_GAIN = np.array([[2.5], [-1.25]])
PRINTED_MATRIX = np.array([[-2.5, 1.0], [-0.25, -0.5]])


def gain() -> np.ndarray:
    """L (2×1) with both poles of the spring-damper's observer at −1."""
    return observer_gain(SPRING.A, SPRING.C, [-1, -1]).gain


def observer_matrix() -> np.ndarray:
    """A − LC with that gain."""
    return SPRING.A - gain() @ SPRING.C


def matching() -> tuple[float, float]:
    """Both conditions on (l1, l2) as the notes have them: l1 − 0.5 and 1 + 0.5 l1 + l2, at the right gain."""
    l1, l2 = gain().ravel()
    return float(l1 - 0.5), float(1 + 0.5 * l1 + l2)


def poles_of(matrix: np.ndarray) -> np.ndarray:
    """Real eigenvalues in ascending order."""
    return np.real(Plant(matrix, SPRING.B, SPRING.C).poles)


def rest_of_printed_observer() -> np.ndarray:
    """Where the printed observer settles while u = 1, run beside the plant for 120 s."""
    believed = Plant(PRINTED_MATRIX + PRINTED_GAIN @ SPRING.C, SPRING.B, SPRING.C)
    run = simulate(Scenario(SPRING, None, PRINTED_GAIN, model=believed, reference=[1.0], horizon=120.0, dt=0.05))
    return run.xhat[-1]


def rest_of_plant() -> np.ndarray:
    """Where the spring-damper settles while u = 1."""
    return simulate(Scenario(SPRING, None, gain(), reference=[1.0], horizon=120.0, dt=0.05)).x[-1]


def static_observer() -> np.ndarray:
    """What ẑ = (A − LC)ẑ + Bu + Ly gives without its dot, at u = y = 1 and with the right gain."""
    return np.linalg.solve(np.eye(2) - observer_matrix(), SPRING.B + gain()).ravel()


def complex_poles() -> tuple[float, float]:
    """With −1 ± 2j, which are not numbers below 0: their largest real part, and 1 if e has died out after 20 s."""
    L = observer_gain(SPRING.A, SPRING.C, [-1 + 2j, -1 - 2j]).gain
    run = simulate(Scenario(SPRING, None, L, x0=(1.0, 0.0), xhat0=(0.0, 0.0), horizon=20.0, dt=0.02))
    slowest = float(np.linalg.eigvals(SPRING.A - L @ SPRING.C).real.max())
    return slowest, float(np.linalg.norm(run.e[-1]) < 10 * np.exp(-20.0))


def gramian_test() -> tuple[float, float, float]:
    """Rows and columns of C e^{At}, which has no determinant, and whether ∫e^{Aᵀt}CᵀC e^{At}dt over 1 s is > 0."""
    least = np.linalg.eigvalsh(observability_gramian(EXAMPLE_PLANT, 1.0))[0]
    return float(EXAMPLE_PLANT.p), float(EXAMPLE_PLANT.n), float(least > 1e-6)


def error_as_difference() -> float:
    """How far x − x̂ leaves what ė = (A − LC)e says of it, from e(0) = (1, 0) over 5 s."""
    run = simulate(Scenario(SPRING, None, gain(), x0=(1.0, 0.0), xhat0=(0.0, 0.0), horizon=5.0))
    law = np.exp(-run.t)[:, None] * (run.e[0] + run.t[:, None] * ((observer_matrix() + np.eye(2)) @ run.e[0]))
    return float(np.abs(run.e - law).max())


RECORDS = (
    Published(SOURCE, "A = [1 2; 3 4], C = [1 0]: O", "1 0; 1 2", lambda: observability(EXAMPLE_PLANT).matrix),
    Published(SOURCE, "its rank", "2", lambda: observability(EXAMPLE_PLANT).rank),
    Published(SOURCE, "singular values of O", "", lambda: observability(EXAMPLE_PLANT).singular_values, "beyond",
              "2.2882, 0.8740"),
    Published(SOURCE, "eig A", "", lambda: np.real(EXAMPLE_PLANT.poles), "beyond", "-0.37228, 5.37228"),
    Published(SOURCE, "criterion for x(0): size of C e^{At}, Gramian > 0", "det(C e^{At}) is not 0", gramian_test,
              "slip", "1, 2, 1",
              note="C e^{At} is 1×2 and has no determinant; the Gramian ∫e^{Aᵀt}CᵀC e^{At}dt > 0 decides"),
    Published(SOURCE, "definition of e", "e is the derivative of x − x̂", error_as_difference, "slip", "0",
              tolerance=1e-9, note="e = x − x̂ itself obeys ė = (A − LC)e"),
    Published(SOURCE, "convergence with −1 ± 2j: largest real part, e dies out", "eigenvalues below 0", complex_poles,
              "slip", "-1, 1", note="their real parts must be below 0; complex numbers have no order"),
    Published(SOURCE, "spring-damper (1, 0.5, 1): A", "0 1; -1 -0.5", lambda: SPRING.A, tolerance=1e-12),
    Published(SOURCE, "matching at −1, −1: l1 − 0.5, 1 + 0.5 l1 + l2", "2, 1", matching, "slip", "1, 1", tolerance=1e-9,
              note="the first condition must read l1 + 0.5 = 2"),
    Published(SOURCE, "both poles at −1: L", "2.5, -1.25", gain, "slip", "1.5, -0.75", tolerance=1e-9,
              note="follows from the wrong condition; L = (3/2, −3/4)"),
    Published(SOURCE, "both poles at −1: A − LC", "-2.5 1; -0.25 -0.5", observer_matrix, "slip", "-1.5 1; -0.25 -0.5",
              tolerance=1e-9, note="the printed matrix mixes both gains"),
    Published(SOURCE, "poles of our A − LC", "-1, -1", lambda: poles_of(observer_matrix()), tolerance=1e-6,
              note="a double pole scatters by rounding"),
    Published(SOURCE, "poles of the printed A − LC", "-1, -1", lambda: poles_of(PRINTED_MATRIX), "slip",
              "-2.36603, -0.63397", note="the printed matrix misses its own target"),
    Published(SOURCE, "poles with the printed gain", "-1, -1", lambda: poles_of(SPRING.A - PRINTED_GAIN @ SPRING.C),
              "slip", "-2.61803, -0.38197", note="the printed gain misses its own target"),
    Published(SOURCE, "unit step: the plant settles at", "", rest_of_plant, "beyond", "1, 0"),
    Published(SOURCE, "unit step: the printed observer settles at", "1, 0", rest_of_printed_observer, "slip",
              "0.666667, -0.833333", note="printed matrix and printed gain are not an observer together: (2/3, −5/6)"),
    Published(SOURCE, "unit step: the observer equation as printed gives", "ẑ without its dot", static_observer, "slip",
              "0.625, 0.0625", tolerance=1e-9, note="without the dot it is no differential equation and misses (1, 0)"),
)
