"""The knobs of lesson 3: the deck's sensors, and one for each of the other cases."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Switch
from app.text.words import Text

from .cases import CASES
from .criteria import CRITERIA

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
