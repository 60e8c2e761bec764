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
from .drive import HORIZON, form_index, joined, noise_values, promised, signal
from .formulas import formulas_of
from .page import pole_of, words
from .problems import COMPUTED, PAPER, PRINTED, PROBLEMS, ROUNDED, nearest_gain

DT = 0.005
KICK = (0.0, 0.0, 0.0, 0.0, 2.0, 0.0)


@dataclass(frozen=True, eq=False)
class Watch:
    """One run: t, u (n_t,), x (n_t, 6), g (n_t,), estimates and errors ε = ĝ − g (n_t, 3) in the order of FORMS.

    heard (n_t, 3) is the part of the errors that the sensors' noise made.
    law (n_t,): ε of the chosen form at its start, or after the kick, times e^{pole t}. fed (n_t, 2): L ẏ, true and as
    the differentiator gives it. `whole`: the run was not cut off because it diverged.
    """

    t: np.ndarray
    u: np.ndarray
    x: np.ndarray
    g: np.ndarray
    estimates: np.ndarray
    errors: np.ndarray
    heard: np.ndarray
    law: np.ndarray
    fed: np.ndarray
    whole: bool


@dataclass(frozen=True, eq=False)
class Study:
    """The eight steps for the problem and the pole, and the run."""

    observer: BilinearObserver
    run: Watch


def watch(plant: BilinearPlant, K: np.ndarray, plain: BilinearForm, exact: BilinearForm, design: Design) -> Watch:
    """Run all forms from χ(0), μ̂(0) = χ(0) + L y(0). A kick moves x, and through ẏ the exact form, never χ."""
    tau, u = design["tau"], signal(design)
    form, rows = joined(plain, exact, tau), np.repeat(K, 3, axis=0)
    x0, start = np.array(X0), (exact.R @ plant.C @ X0).item()
    z0 = np.array([design["chi0"], design["chi0"] + start, design["chi0"] + start, start])
    at = int(design["kick"] / DT + 1e-9) if design["kick"] >= 0 else None
    last = round(HORIZON / DT)
    noise = design["noise"] * noise_values(design, last + 1, plant.m) if design["noise"] else None

    def ran(noise: np.ndarray | None) -> list[BilinearRun]:
        def run(x: np.ndarray, z: np.ndarray, begin: int, end: int) -> BilinearRun:
            return simulate_bilinear(plant, form, rows, lambda t: u(t + begin * DT), x, z, horizon=(end - begin) * DT, dt=DT,
                                     noise=None if noise is None else noise[begin:end + 1])
        return [run(x0, z0, 0, last)] if at is None else _kicked(plant, form, run, x0, z0, min(at, last - 1), last)
    still = ran(None)
    pieces = still if noise is None else ran(noise)
    return _watch(plant, exact, tau, form_index(design), plain.A[0, 0], still, pieces, last)


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


def _watch(plant: BilinearPlant, exact: BilinearForm, tau: float, chosen: int, pole: float, still: list[BilinearRun],
           pieces: list[BilinearRun], last: int) -> Watch:
    def whole(name: str, of: list[BilinearRun] = pieces) -> np.ndarray:  # the sample at the kick is the one just after it
        parts = [getattr(p, name) for p in of]
        return np.concatenate([*(p[:-1] for p in parts[:-1]), parts[-1]])

    x, u, z, y, errors, calm = whole("x"), whole("u"), whole("z"), whole("y"), whole("error"), whole("error", still)
    t = DT * np.arange(len(x))
    laws = [p.error[0, chosen] * np.exp(pole * p.t) for p in still]
    law = np.concatenate([*(part[:-1] for part in laws[:-1]), laws[-1]])[:len(x)]
    rate = x @ plant.A.T + u[:, None] * (x @ plant.F.T + plant.B[:, 0])
    L, count = exact.R[0], min(len(errors), len(calm))
    fed = np.column_stack([rate @ plant.C.T @ L, (y @ L - z[:, 3]) / tau])
    return Watch(t[:count], u[:count], x[:count], whole("g")[:count, 0], whole("estimate")[:count], errors[:count],
                 errors[:count] - calm[:count], law[:count], fed[:count], len(x) == last + 1)


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
    if design["noise"]:
        metrics |= _noise(design, run, joined(plain, exact, design["tau"]), problem.plant.m)
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


def _noise(design: Design, run: Watch, form: BilinearForm, outputs: int) -> dict[str, float]:
    """The rms of what noise adds to the estimate in the second half of the run, and what its law promises at u = 0."""
    index, late = form_index(design), run.heard[len(run.t) // 2:]
    says = promised(form, np.full(outputs, design["noise"]), DT)
    return {"noise_rms": float(np.sqrt(np.mean(late[:, index] ** 2))), "noise_promised": float(min(says[index], 1e15))}


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
        *promises(o),
    )


def promises(o: BilinearObserver) -> tuple[Check, Check, Check]:
    """What sizes and a pair of matrices promise before anything is solved."""
    n, m, q = o.plant.n, o.plant.m, o.order
    return (
        Check("fewer", text("r < n − m: fewer states than Luenberger's reduced observer"), q < n - m, float(n - m - q)),
        Check("advised", text("3m + r ≥ 2n: (21) is to be expected"), o.advised, float(3 * m + q - 2 * n)),
        Check("pair", text("(V₂AT₂, V₁AT₂) observable: any pole, if (21) asked nothing of L"), o.observable, float(o.order)),
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
    if design["noise"]:
        return claim(text("The sensors' noise moves ĝ by {rms:.2g} (rms, second half of the run); at rest and u = 0 its law says "
                          "{promised:.2g}.", rms=m["noise_rms"], promised=m["noise_promised"]), m["noise_rms"], above=0.0)
    return claim(text("Case {case}: one state watches g, and ε dies out as e^({pole}t) under this u.", case=o.case, pole=pole),
                 m["law_gap"], below=1e-6, otherwise=text(
                     "The pole is {pole}, but something still drives ε: it ends at {late}.", pole=pole, late=late))
