"""What a design leads to: the eight steps, and the plant under any input beside three forms of one observer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.engine import BilinearPlant, simulate_bilinear
from app.engine.observers import BilinearForm, BilinearObserver, BilinearRun
from app.lesson.claims import claim
from app.lesson.lesson import Board, Check, Design, Outcome, Stage
from app.plants.bilinear import PLANT, PRINTED_FORM, PRINTED_L, X0
from app.plants.body import Body
from app.plants.model import Window
from app.text import Text, text

from ..toolkit.boards import listed
from ..toolkit.figures import settle_time
from .formulas import formulas_of
from .page import pole_of, words
from .problems import COMPUTED, PAPER, PRINTED, PROBLEMS, ROUNDED, nearest_gain

HORIZON, DT = 2.0, 0.005
HOLD = 0.1  # s for which a random input is held
PLAIN, EXACT, FILTERED = "plain", "exact", "filtered"
FORMS = (PLAIN, EXACT, FILTERED)
KICK = (0.0, 0.0, 0.0, 0.0, 2.0, 0.0)


@dataclass(frozen=True, eq=False)
class Watch:
    """One run: t, u (n_t,), x (n_t, 6), g (n_t,), estimates and errors ε = ĝ − g (n_t, 3) in the order of FORMS.

    law (n_t,): ε of the chosen form at its start, or after the kick, times e^{pole t}. fed (n_t, 2): L ẏ, true and as
    the differentiator gives it. `whole`: the run was not cut off because it diverged.
    """

    t: np.ndarray
    u: np.ndarray
    x: np.ndarray
    g: np.ndarray
    estimates: np.ndarray
    errors: np.ndarray
    law: np.ndarray
    fed: np.ndarray
    whole: bool


@dataclass(frozen=True, eq=False)
class Study:
    """The eight steps for the problem and the pole, and the run."""

    observer: BilinearObserver
    run: Watch


def signal(design: Design) -> Callable[[np.ndarray], np.ndarray]:
    """u(t) as the student chose it."""
    kind, size, omega = design["input"], design["amplitude"], design["omega"]
    if kind == "sine":
        return lambda t: size * np.sin(omega * t)
    if kind == "step":
        return lambda t: np.full(np.shape(t), size)
    if kind == "square":
        return lambda t: np.where(np.floor(t * omega / np.pi + 1e-9) % 2 == 0, size, -size)
    if kind == "sweep":
        return lambda t: size * np.cos(omega * t**2)
    if kind == "random":
        values = random_values(design)
        return lambda t: values[np.minimum(t / HOLD + 1e-9, len(values) - 1).astype(int)]
    if kind == "hand" and design["hand"]:
        times, drawn = np.array(design["hand"]).T
        held = np.concatenate([[0.0], drawn])
        return lambda t: held[np.searchsorted(times, t + 1e-9, side="right")]
    return lambda t: np.zeros(np.shape(t))


def random_values(design: Design) -> np.ndarray:
    """What a random input holds, one value after the other."""
    return np.random.default_rng(int(design["seed"])).uniform(-design["amplitude"], design["amplitude"], round(HORIZON / HOLD) + 1)


def joined(plain: BilinearForm, exact: BilinearForm, tau: float) -> BilinearForm:
    """One form with the states (χ, μ̂, μ̂ of the differentiator, d): ḋ = (L y − d)/τ stands for L ẏ in the third."""
    A = np.diag([plain.A[0, 0], exact.A[0, 0], exact.A[0, 0], -1 / tau])
    A[2, 3] = -1 / tau
    L, none, still = exact.R, np.zeros_like(exact.R), np.zeros((1, 1))
    G_z = np.zeros((3, 4))
    G_z[[0, 1, 2], [0, 1, 2]] = plain.G_z[0, 0], exact.G_z[0, 0], exact.G_z[0, 0]
    return BilinearForm(A, np.vstack([plain.Y, exact.Y, exact.Y + L / tau, L / tau]),
                        np.vstack([plain.B, exact.B, exact.B, still]), np.vstack([plain.U, exact.U, exact.U, none]),
                        np.vstack([none, L, none, none]), np.vstack([plain.G_y, exact.G_y, exact.G_y]), G_z)


def watch(plant: BilinearPlant, K: np.ndarray, plain: BilinearForm, exact: BilinearForm, design: Design) -> Watch:
    """Run all forms from χ(0), μ̂(0) = χ(0) + L y(0). A kick moves x, and through ẏ the exact form, never χ."""
    tau, u = design["tau"], signal(design)
    form, rows = joined(plain, exact, tau), np.repeat(K, 3, axis=0)
    x0, start = np.array(X0), (exact.R @ plant.C @ X0).item()
    z0 = np.array([design["chi0"], design["chi0"] + start, design["chi0"] + start, start])
    at = int(design["kick"] / DT + 1e-9) if design["kick"] >= 0 else None

    def run(x: np.ndarray, z: np.ndarray, begin: int, end: int) -> BilinearRun:
        return simulate_bilinear(plant, form, rows, lambda t: u(t + begin * DT), x, z, horizon=(end - begin) * DT,
                                 dt=DT)

    last = round(HORIZON / DT)
    pieces = [run(x0, z0, 0, last)] if at is None else _kicked(plant, form, run, x0, z0, min(at, last - 1), last)
    return _watch(plant, exact, tau, form_index(design), plain.A[0, 0], pieces, last)


def form_index(design: Design) -> int:
    """Which of the three estimates the ghost shows."""
    return FORMS.index(design["form"])


def _kicked(plant: BilinearPlant, form: BilinearForm, run: Callable[..., BilinearRun], x0: np.ndarray, z0: np.ndarray,
            at: int, last: int) -> list[BilinearRun]:
    jump = np.array(KICK)
    leap = form.R @ plant.C @ jump
    if at == 0:
        return [run(x0 + jump, z0 + leap, 0, last)]
    before = run(x0, z0, 0, at)
    if before.diverged_at is not None:
        return [before]
    return [before, run(before.x[-1] + jump, before.z[-1] + leap, at, last)]


def _watch(plant: BilinearPlant, exact: BilinearForm, tau: float, chosen: int, pole: float, pieces: list[BilinearRun],
           last: int) -> Watch:
    def whole(name: str) -> np.ndarray:  # the sample at the kick is the one just after it
        parts = [getattr(p, name) for p in pieces]
        return np.concatenate([*(p[:-1] for p in parts[:-1]), parts[-1]])

    x, u, z, errors = whole("x"), whole("u"), whole("z"), whole("error")
    t = DT * np.arange(len(x))
    laws = [p.error[0, chosen] * np.exp(pole * p.t) for p in pieces]
    law = np.concatenate([*(part[:-1] for part in laws[:-1]), laws[-1]])
    rate = x @ plant.A.T + u[:, None] * (x @ plant.F.T + plant.B[:, 0])
    L = exact.R[0]
    fed = np.column_stack([rate @ plant.C.T @ L, (x @ plant.C.T @ L - z[:, 3]) / tau])
    return Watch(t, u, x, whole("g")[:, 0], whole("estimate"), errors, law, fed, len(x) == last + 1)


FORM_NAMES = (text("without ẏ"), text("with the true ẏ"), text("with a "
                                                                                                     "differentiator"))
OBSERVER_WINDOW, PLANT_WINDOW = Window(-60.0, 20.0, 20.0), Window(-30.0, 10.0, 12.0)
PLANT_POLES = np.sort_complex(np.linalg.eigvals(PLANT.A))
PLANT_POLES.setflags(write=False)


def compute(design: Design) -> Outcome[Study]:
    """The eight steps for the problem and the pole, and one run of all three forms under the chosen input."""
    problem = PROBLEMS[design["problem"]]
    paper = problem.id == PAPER
    observer = problem.observer(design["pole"][0].real) if paper else problem.solved
    L = _gain(design, observer)
    exact, plain = observer.forms(L)
    if paper and design["gain"] == ROUNDED:
        plain = PRINTED_FORM
    run = watch(problem.plant, problem.K, plain, exact, design)
    pole = PRINTED_FORM.A.item() if plain is PRINTED_FORM else pole_of(observer, L)
    metrics = _metrics(design, observer, run, pole)
    return Outcome(design, {"L": L}, {"observer": np.array([complex(pole)]), "plant": PLANT_POLES}, metrics,
                   _checks(observer, metrics), None, _boards(design, observer, pole), _stage(problem.body, design, run),
                   formulas_of(observer, L, plain, int(design["step"])), _live(design, observer, metrics), Study(observer, run))


def _gain(design: Design, observer: BilinearObserver) -> np.ndarray:
    """L (1×m) of the run: computed, of the paper, with L₄ typed, or of least squares where none meets (20)."""
    if observer.L is None:
        return nearest_gain(observer)
    if design["problem"] != PAPER or design["gain"] in (COMPUTED, ROUNDED):
        return observer.L
    if design["gain"] == PRINTED:
        return PRINTED_L
    typed = observer.L.copy()
    typed[0, 3] = design["l4"]
    return typed


def _metrics(design: Design, observer: BilinearObserver, run: Watch, pole: float) -> dict[str, float]:
    size = np.abs(run.errors[:, form_index(design)])
    scale = max(float(np.max(np.abs(run.law))), 1e-3)
    n, settled = len(run.t), settle_time(run.t, size)
    found = {"pole": pole, "case": float(observer.case), "defect": observer.defect_size,
             "law_gap": float(np.max(np.abs(run.errors[:, form_index(design)] - run.law))) / scale,
             "first_error": float(run.errors[0, form_index(design)]),
             "late_error": float(np.max(size[-max(n // 10, 1):])), "half_error": float(np.max(size[n // 2:])),
             "plain_half": float(np.max(np.abs(run.errors[n // 2:, 0]))),
             "late_g": float(np.max(np.abs(run.g[-max(n // 10, 1):]))),
             "settled_after": 2 * HORIZON if settled is None else settled}
    if observer.pi is not None:
        found |= {"A*": observer.A_star.item(), "B*": observer.B_star.item(), "pi": observer.pi.item()}
    return found


def _checks(o: BilinearObserver, metrics: dict[str, float]) -> tuple[Check, ...]:
    gap = metrics["law_gap"]
    return (
        Check("case1", text("case 1: (21) fails, no L"), o.case == 1, o.defect_size),
        Check("case2", text("case 2: one L only"), o.case == 2, float(o.canonical_Q.rank)),
        Check("case3", text("case 3: a family of L"), o.case == 3, float(len(o.canonical_Q.zero_left))),
        Check("controllable", text("(A*, B*) controllable: any pole"), bool(o.controllable),
              float(np.max(np.abs(o.B_star), initial=0.0))),
        Check("stable", text("the pole in use is on the left"), metrics["pole"] < 0, metrics["pole"]),
        Check("law", text("ε follows its pole under this u"), gap <= 1e-6, gap),
    )


def _boards(design: Design, o: BilinearObserver, pole: float) -> tuple[Board, Board]:
    paper = design["problem"] == PAPER
    seen = listed(np.array([complex(pole)]))
    title = (text("observer pole  A* − B*π") if o.case == 3
             else text("observer pole  (V₂ − LV₁)AT₂"))
    return (
        Board("plant", text("the plant's poles at u = 0  eig(A)"), listed(PLANT_POLES),
              side="left", re_low=PLANT_WINDOW.re_low, re_high=PLANT_WINDOW.re_high, im_high=PLANT_WINDOW.im_high),
        Board("observer", title, seen if paper else (), "pole" if paper else None, fixed=() if paper or o.case == 1 else seen,
              role="estimate", side="right", re_low=OBSERVER_WINDOW.re_low, re_high=OBSERVER_WINDOW.re_high,
              im_high=OBSERVER_WINDOW.im_high,
              also=(("gain", COMPUTED),) if paper else ()),
    )


def _stage(body: Body, design: Design, run: Watch) -> Stage:
    true = np.column_stack([run.x, run.g])
    return Stage(body, run.t, true, np.column_stack([run.x, run.estimates[:, form_index(design)]]), run.u[:, None])


def _live(design: Design, o: BilinearObserver, m: dict[str, float]) -> Text:
    pole, late = words(np.array([m["pole"]]), 2), f"{m['late_error']:.1e}"
    if o.case == 1:
        return text("Case 1: no L frees ε from u and x. The nearest one leaves ε at {late} when the run ends.",
                    late=late)
    if m["pole"] >= 0:
        return text("The observer's pole is {pole}: ε grows and reaches {late}.", pole=pole, late=late)
    return claim(text("Case {case}: one state watches g, and ε dies out as e^({pole}t) under this u.", case=o.case, pole=pole),
                 m["law_gap"], below=1e-6, otherwise=text(
                     "The pole is {pole}, but something still drives ε: it ends at {late}.", pole=pole, late=late))
