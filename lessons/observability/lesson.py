"""Observability: which sensor sees everything? Rows of O, distances, and the states that the data so far allow."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from app.lesson.figures import Figure
from app.lesson.knobs import Choice, Number, Switch
from app.lesson.lesson import Check, Design, ExamItem, Formula, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.plants import Model
from app.text.words import Text

from ..toolkit.latex import matrix, number, pole_words
from .bodies import body_of
from .cases import CASES, sensed
from .criteria import CRITERIA, criteria
from .knowledge import REACH, learn, rebuild
from .pictures import all_figures
from .sweep import sweep
from .tasks import TASKS
from .verdict import NEAR, Found, judged

DECK, NOTES, PAIR, MANY = "deck", "notes", "pair", "many"


def _place(name: str, symbol: str, en: str, zh: str, default: float) -> Number:
    return Number(name, symbol, Text(en, zh), "m", low=-0.2, high=0.2, default=default, step=0.002,
                  when=(f"{name}_on", (True,)),
                  hint=Text("Where along the deck this vertical sensor stands; 0 is above the centre of mass.",
                            "竖直传感器沿台面的位置；0 在质心正上方。"))


def _on(name: str, en: str, zh: str, default: bool) -> Switch:
    return Switch(name, "", Text(en, zh), default=default, when=("plant", (DECK,)),
                  hint=Text("On or off. A sensor that is off turns grey on the deck.", "开或关；关闭的传感器在台面上变灰。"))


def _rows(name: str, plants: tuple[str, ...], high: int) -> Number:
    return Number(name, "k", Text("block rows of O", "O 的块行数"), low=1, high=high, default=1, scale="integer",
                  when=("plant", plants),
                  hint=Text("One step adds the next row C Aᵏ, that is, one more derivative of y.",
                            "每加一步就多一行 C Aᵏ，也就是多用 y 的一阶导数。"))


KNOBS = (
    Choice("plant", "", Text("case", "算例"), default=DECK, options=tuple((c.id, c.label) for c in CASES.values()),
           hint=Text("The platform's deck, the example of the notes, and two plants that are hard to judge.",
                     "平台台面、讲义的例子，以及两个不好判断的对象。")),
    _on("left_on", "left sensor, vertical", "左传感器（竖直）", True),
    _place("left", "p_1", "place of the left sensor", "左传感器位置", 0.0),
    _on("right_on", "right sensor, vertical", "右传感器（竖直）", False),
    _place("right", "p_2", "place of the right sensor", "右传感器位置", 0.072),
    _on("across_on", "horizontal sensor", "水平传感器", False),
    Number("angle", r"\varphi", Text("sensor direction", "传感器方向"), "°", low=-90.0, high=90.0, default=0.0, step=0.1,
           when=("plant", (NOTES,)), hint=Text("C = [cos φ, sin φ]: at 0° it is the notes' [1 0].",
                                               "C = [cos φ, sin φ]：0° 时即讲义的 [1 0]。")),
    Number("gap", r"\varepsilon", Text("gap between the modes", "两模态之差"), low=1e-8, high=1.0, default=0.5, scale="log",
           when=("plant", (PAIR,)), hint=Text("A = diag(−1, −1−ε), C = [1 1]: with ε = 0 the modes cannot be told apart.",
                                              "A = diag(−1, −1−ε)，C = [1 1]：ε = 0 时两个模态无法区分。")),
    Number("count", "n", Text("number of modes", "模态个数"), low=2, high=20, default=20, scale="integer",
           when=("plant", (MANY,)), hint=Text("A = diag(−1, …, −n), and one sensor that adds all states up.",
                                              "A = diag(−1, …, −n)，一个传感器测所有状态之和。")),
    _rows("rows_deck", (DECK,), 6),
    _rows("rows_two", (NOTES, PAIR), 2),
    _rows("rows_many", (MANY,), 20),
    Number("tolerance", r"\tau", Text("tolerance of the rank", "秩的容差"), low=1e-16, high=0.1, default=5e-15, scale="log",
           hint=Text("Singular values of O at or below τ times the largest count as zero.",
                     "O 的奇异值不超过最大值的 τ 倍者按零计。")),
    Number("reading", r"\delta", Text("error of each derivative", "各阶导数的误差"), low=1e-12, high=0.1, default=1e-3,
           scale="log", hint=Text("Relative error with which y and its derivatives are read at t = 0.",
                                  "t = 0 时读取 y 及其导数的相对误差。")),
    Number("noise", r"\nu", Text("noise of the sensors", "传感器噪声"), low=1e-4, high=1.0, default=0.03, scale="log",
           hint=Text("White noise over the run, as a share of a typical reading.", "运行时的白噪声，以典型读数为单位。")),
    Choice("criterion", "", Text("criterion for “observable”", "能观的判据"), default="det", options=CRITERIA,
           hint=Text("One of these sentences is what the notes derive from C e^{At}, and it is no criterion.",
                     "其中一句是讲义由 C e^{At} 推出的，它并不是判据。")),
    Number("seed", r"s_0", Text("noise seed", "噪声种子"), low=0, high=9999, default=1, scale="integer", hidden=True),
)


def _blocks(design: Design, n: int) -> int:
    name = {DECK: "rows_deck", MANY: "rows_many"}.get(design["plant"], "rows_two")
    return min(int(design[name]), n)


def compute(design: Design) -> Outcome:
    """O and its rank, every mode's distance, x(0) from derivatives, and x(0) from noisy y over a growing window."""
    case, s = CASES[design["plant"]], sensed(design)
    n, seed = s.plant.n, int(design["seed"])
    start = np.array(case.start[:n])
    built = rebuild(s, start, _blocks(design, n), design["reading"], design["tolerance"], seed)
    belief = learn(s, start, design["noise"], seed)
    weakest = min(s.seen.modes, key=lambda m: (m.visible, m.distance))
    full = s.seen.matrix_rank(design["tolerance"]) if s.seen.singular_values[0] > 0 else 0
    found = Found(case, s, built, belief, start, criteria(s, full), weakest, full, sweep(design))
    metrics = metrics_of(found)
    return Outcome(design, {}, {"plant": np.array([m.pole for m in s.seen.modes])}, metrics, checks_of(metrics),
                   stage=_stage(design, found), formulas=formulas_of(found), live=live_of(found, metrics), study=found)


def cloud_of(found: Found) -> np.ndarray:
    """Middle, half axes, rotation and truth of the drawn 95 % ellipsoid over time (n_t, 13): right, away, up."""
    count = len(found.belief.mean)
    cov, mean = np.zeros((count, 3, 3)), np.zeros((count, 3))
    truth = np.zeros(3)
    places = [(axis, i) for axis, i in enumerate(found.case.drawn) if i is not None and i < len(found.start)]
    axes, states = [a for a, _ in places], [i for _, i in places]
    cov[:, np.array(axes)[:, None], axes] = found.belief.P[:, np.array(states)[:, None], states]
    mean[:, axes] = found.belief.mean[:, states]
    truth[axes] = found.start[states]
    values, vectors = np.linalg.eigh(cov)
    vectors = vectors * np.where(np.linalg.det(vectors) < 0, -1.0, 1.0)[:, None, None]
    turns = Rotation.from_matrix(vectors).as_quat()[:, [3, 0, 1, 2]]
    return np.hstack([mean, REACH[len(axes) - 1] * np.sqrt(np.maximum(values, 0.0)), turns, np.tile(truth, (count, 1))])


def _stage(design: Design, found: Found) -> Stage:
    """The plant along its free motion, its ghost along the estimate from the data so far, sensors, and the cloud."""
    s, case = found.sensed, found.case
    n = s.plant.n
    if case.id == DECK:
        extra = [design["left"], design["right"], *(float(design[f"{k}_on"]) for k in ("left", "right", "across"))]
    else:
        row = s.plant.C[0] / np.linalg.norm(s.plant.C[0])
        extra = [0.0 if i is None or i >= n else float(row[i]) for i in case.drawn]
    size = np.array(case.scale[:n])
    tail = np.hstack([np.tile(extra, (len(s.t), 1)), cloud_of(found)])
    true = np.hstack([s.powers @ found.start * size, tail])
    guess = np.hstack([np.einsum("kij,kj->ki", s.powers, found.belief.mean) * size, tail])
    return Stage(body_of(case.id, n), s.t, true, guess)


def checks_of(m: dict[str, float]) -> tuple[Check, ...]:
    """What the rank says, and what the distances and the data say."""
    return (
        Check("rank", Text("rank(O) = n at this tolerance", "在此容差下 rank(O) = n"), m["rank"] == m["states"], m["rank"]),
        Check("seen", Text("every mode leaves a trace", "每个模态都留下痕迹"), m["hidden"] == 0, m["weakest"]),
        Check("clear", Text("no mode is nearly hidden", "没有几乎隐藏的模态"), m["weakest"] >= NEAR, m["weakest"]),
        Check("known", Text("every direction of x(0) known to a tenth", "x(0) 的每个方向都确定到十分之一"),
              m["known"] == m["states"], m["known"]),
    )


def formulas_of(found: Found) -> tuple[Formula, ...]:
    """O as far as it is built, and what is solved with it."""
    s, built = found.sensed, found.rebuilt
    n, p, k = s.plant.n, s.plant.p, built.rows
    power = "" if k == 1 else "A" if k == 2 else rf"A^{{{k - 1}}}"
    last = built.matrix[-p:]
    whole = (Formula("O", rf"\mathcal O_{{{k}}} = {matrix(built.matrix)}") if n == 2 else
             Formula("O", rf"C{power} = {matrix(last)}") if n <= 6 else
             Formula("O", rf"\left\| C{power} \right\| = {number(float(np.linalg.norm(last)))}"))
    return (whole, Formula("solve", r"\mathcal O_k\, x(0) = \begin{bmatrix} y \\ \dot y \\ \vdots \end{bmatrix}_{t=0}"),
            Formula("rank", rf"\mathrm{{rank}}\,\mathcal O_{{{k}}} = {built.rank}, \quad n = {n}"),
            Formula("P", r"P(t) = \left( I + W(t)/v \right)^{-1}"))


def live_of(found: Found, m: dict[str, float]) -> Text:
    """One sentence on what is seen now."""
    n, rank, known = int(m["states"]), int(m["rank"]), int(m["known"])
    verdict, d = judged(found), f"{m['weakest']:.2g}"
    if verdict == "hidden":
        poles = pole_words([p for p in found.sensed.seen.unobservable if p.imag >= 0])
        return Text(f"Not observable: {poles} leave no trace in y. Known to a tenth: {known} of {n} directions.",
                    f"不能观：{poles} 在 y 中不留痕迹。确定到十分之一的方向：{known}/{n}。")
    if verdict == "near":
        mode = pole_words([complex(found.weakest.pole.real, abs(found.weakest.pole.imag))])
        return Text(f"Nearly unobservable: the mode {mode} is {d} away from being hidden, while rank(O) = {rank} of {n}.",
                    f"接近不能观：模态 {mode} 离隐藏只有 {d}，而 rank(O) = {rank}/{n}。")
    if verdict == "unresolved":
        return Text(f"No mode is hidden (nearest: {d}), yet this run fixes only {known} of {n} directions to a tenth; "
                    f"rank(O) = {rank}.", f"没有隐藏模态（最近距离 {d}），但本次运行只把 {n} 个方向中的 {known} 个确定到十分之一；"
                                          f"rank(O) = {rank}。")
    return Text(f"Observable: the nearest mode is {d} from being hidden, and all {n} directions are known to a tenth.",
                f"能观：最近的模态离隐藏 {d}，{n} 个方向全部确定到十分之一。")


def figures(outcome: Outcome) -> tuple[Figure, ...]:
    """O and the rebuilt start; the shrinking ellipsoid; modes, their distances and the criteria."""
    return all_figures(outcome)


def exam(seed: int) -> ExamItem:
    """A = [a b; c d], C = [1 0], y(0) and ẏ(0) given: x₂(0) = (ẏ(0) − a y(0))/b."""
    rng = np.random.default_rng(seed)
    a, b, c, d = (float(v) for v in (rng.integers(-4, 5), rng.choice([-5, -4, -2, 2, 4, 5]), *rng.integers(-4, 5, 2)))
    y, x2 = float(rng.integers(1, 6)), float(rng.integers(-12, 13)) / 2
    return ExamItem({k: f"{v:g}" for k, v in (("a", a), ("b", b), ("c", c), ("d", d), ("y", y), ("dy", a * y + b * x2))},
                    x2, 1e-6)


def metrics_of(found: Found) -> dict[str, float]:
    """The numbers of a design."""
    s, n = found.sensed, found.sensed.plant.n
    return {
        "rank": float(found.rank), "states": float(n), "rows": float(found.rebuilt.rows), "rank_built": float(found.rebuilt.rank),
        "weakest": found.weakest.distance if found.weakest.visible else 0.0, "hidden": float(n - s.seen.rank),
        "known": float(found.belief.known), "longest": float(found.belief.halves[-1, 0]),
        "rebuild_error": float(np.linalg.norm(found.rebuilt.guess - found.start) / np.linalg.norm(found.start)),
        "least_energy": float(s.heard[-1, 0]),
    }


def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted

    return adapted(lesson, model)


LESSON = Lesson("observability", 3, KNOBS, compute, figures, answer=1, tasks=TASKS, exam=exam, kick=False,
                source="Observer notes (001), section 2: observability matrix, rank criterion; PBH test; Gramian",
                words=read_prose(Path(__file__).parent), adapt=adapt)

__all__ = ["LESSON"]
