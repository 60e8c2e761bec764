"""Integrate a nonlinear plant over one sampling step by Runge–Kutta, with its derivative."""

from __future__ import annotations

import numpy as np

from .gates.argument_checks import FUNCTION, NAME, SECONDS, count, optional, passed
from .gates.map_roles import CLOCK_ROWS
from .jacobian import Map, slopes
from .plant import Plant
from .records import record

__all__ = ["Flow", "NonlinearPlant"]


@record()
class Flow:
    """x[k+1] = f(x[k], u[k]): ẋ = rhs(x, u) over `step` seconds with u held, in `parts` equal steps of order four.

    States are columns: rhs maps x (n, N), u (m, N) or (m, 1) to ẋ (n, N); `slope`, if given, to ∂ẋ/∂x (N, n, n). A flow
    is itself such a map, fit for the filters as f. Kutta (1901). Raises EngineError for a step that is not positive.
    """

    rhs: Map
    step: float
    parts: int = 1
    slope: Map | None = None

    def __post_init__(self) -> None:
        passed(self, rhs=FUNCTION, step=SECONDS, parts=count(1, 100_000), slope=optional(FUNCTION))

    def __call__(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The states one step later, (n, N)."""
        h, rhs = self.step / self.parts, self.rhs
        for _ in range(self.parts):
            k1 = rhs(x, u)
            k2 = rhs(x + h / 2 * k1, u)
            k3 = rhs(x + h / 2 * k2, u)
            k4 = rhs(x + h * k3, u)
            x = x + h / 6 * (k1 + 2 * (k2 + k3) + k4)
        return x

    def expand(self, x: np.ndarray, u: np.ndarray, *, lead: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """The states one step later (n, N) and ∂f/∂x (N, n, n): the exact derivative of the discrete map, not of the flow.

        Only the first `lead` columns are differentiated if that is given; u is then (m, N) or (m, 1) as ever.
        """
        lead = x.shape[1] if lead is None else lead
        held = u if u.shape[1] == 1 else u[:, :lead]
        if self.slope is None:
            return self(x, u), slopes(self, x[:, :lead], held)[1]
        h, rhs, slope = self.step / self.parts, self.rhs, self.slope
        Phi: np.ndarray | None = None
        for _ in range(self.parts):
            k1 = rhs(x, u)
            second = x + h / 2 * k1
            k2 = rhs(second, u)
            third = x + h / 2 * k2
            k3 = rhs(third, u)
            fourth = x + h * k3
            d1 = slope(x[:, :lead], held)
            J = slope(second[:, :lead], held)
            d2 = J + J @ (h / 2 * d1)
            J = slope(third[:, :lead], held)
            d3 = J + J @ (h / 2 * d2)
            J = slope(fourth[:, :lead], held)
            part = h / 6 * (d1 + 2 * (d2 + d3) + J + J @ (h * d3))
            Phi = np.eye(len(x)) + part if Phi is None else Phi + part @ Phi
            x = x + h / 6 * (k1 + 2 * (k2 + k3) + rhs(fourth, u))
        assert Phi is not None
        return x, Phi


@record()
class FlowInTime:
    """A flow over steps of any length: u has two more rows, t and the step dt in s; parts are as long as the flow's own, or shorter."""

    flow: Flow

    def _over(self, step: float) -> Flow | None:
        parts = int(np.ceil(self.flow.parts * step / self.flow.step - 1e-9))
        return Flow(self.flow.rhs, step, max(parts, 1), self.flow.slope) if step > 0 else None

    def __call__(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The states dt later; as they are where dt = 0."""
        flow = self._over(float(u[-1, 0]))
        return x if flow is None else flow(x, u[:-CLOCK_ROWS])

    def expand(self, x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The states dt later (n, N) and ∂f/∂x (N, n, n)."""
        flow = self._over(float(u[-1, 0]))
        if flow is None:
            return x, np.repeat(np.eye(len(x))[None], x.shape[1], axis=0)
        return flow.expand(x, u[:-CLOCK_ROWS])


@record()
class NonlinearPlant:
    """ẋ = rhs(x, u), y = output(x, u) of columns, with the slopes ∂ẋ/∂x (N, n, n) and ∂y/∂x (N, p, n) by hand.

    n states, m inputs, p outputs. Every function takes x (n, N) and u (m, N) or (m, 1), and complex states pass.

    >>> still = NonlinearPlant(1, 0, 1, lambda x, u: -x, lambda x, u: -np.ones((x.shape[1], 1, 1)),
    ...                        lambda x, u: x, lambda x, u: np.ones((x.shape[1], 1, 1)))
    >>> still.flow(0.1)(np.ones((1, 1)), np.zeros((0, 1))).round(6)
    array([[0.904838]])
    """

    n: int
    m: int
    p: int
    rhs: Map
    slope: Map
    output: Map
    output_slope: Map
    name: str = ""

    def __post_init__(self) -> None:
        passed(self, n=count(), m=count(), p=count(), rhs=FUNCTION, slope=FUNCTION, output=FUNCTION, output_slope=FUNCTION, name=NAME)

    def flow(self, step: float, *, parts: int = 1) -> Flow:
        """The plant over one sampling step in s."""
        return Flow(self.rhs, step, parts, self.slope)

    def observe(self, x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """y (p, N) and its slopes (N, p, n)."""
        return self.output(x, u), self.output_slope(x, u)

    def linear(self, x: object, u: object) -> Plant:
        """A, B, C, D of the expansion about a state (n,) and an input (m,); B and D by a complex step."""
        at, push = (np.asarray(v, dtype=float).reshape(-1, 1) for v in (x, u))
        B, D = (slopes(lambda v, _, f=f: f(at + 0 * v[:1], v), push, at)[1][0] if self.m else np.zeros((rows, 0))
                for f, rows in ((self.rhs, self.n), (self.output, self.p)))
        return Plant(self.slope(at, push)[0], B, self.output_slope(at, push)[0], D, name=self.name)
