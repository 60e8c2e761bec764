"""Knobs of the robust observer on a person's own plant."""

from __future__ import annotations

from app.lesson.knobs import Choice, Knob, Number, Poles
from app.text.words import Text, same

from .knobs import ERRORS, NORMS, SEARCH, weight_knobs
from .own_plant import Here

WANTED = Text("What is wanted", "待估计的量")


def own_knobs(here: Here) -> tuple[Knob, ...]:
    """What is wanted, the order and its poles, how wrong the model is, and what J and RLO are told."""
    model, orders = here.model, [order for order, _ in here.starts]
    c, o = model.controller_window, model.observer_window
    speed = -o.re_low
    return (
        Choice("wanted", "", Text("the observer is to give", "观测器给出"), default=here.wanted[0][0], options=here.wanted, group=WANTED,
               hint=Text("A row of K is fed back through the observer, all other inputs from the true state; a state is only watched.",
                         "K 的一行经观测器反馈，其余输入由真实状态反馈；状态只被观测，不参与反馈。")),
        Poles("controller_poles", "p", Text("Controller poles, which give K", "决定 K 的控制器极点"), "rad/s",
              default=model.controller_poles, re_low=c.re_low, re_high=c.re_high, im_high=c.im_high, role="plant", group=WANTED,
              hidden=not model.controller_poles, hint=Text("eig(A − BK): dragging them changes K.", "eig(A − BK)：拖动它们会改变 K。")),
        Choice("order", "q", Text("order of the observer", "观测器阶数"), default=str(orders[0]), group=WANTED, hidden=len(orders) == 1,
               options=tuple((str(q), same(str(q))) for q in orders),
               hint=Text("From the lowest order that these poles allow up to n less the rank of C.",
                         "从所给极点允许的最低阶数，直到 n 减去 C 的秩。")),
        *(Poles(f"poles_{q}", "s", Text("Observer poles", "观测器极点"), "rad/s", default=poles, re_low=o.re_low, re_high=o.re_high,
                im_high=o.im_high, role="estimate", when=("order", (str(q),)), group=WANTED,
                hint=Text("Drag them and watch J and the error.", "拖动它们，观察 J 与误差。")) for q, poles in here.starts),
        Number("delta_a", r"\delta_a", Text("error of every entry of A", "A 各元素的误差"), "%", low=0.0, high=50.0, default=5.0, step=0.5,
               group=ERRORS, hint=Text("Every entry of the true A is this much larger or smaller.", "真实 A 的每个元素都大或小这么多。")),
        Number("delta_c", r"\delta_c", Text("error of every entry of C", "C 各元素的误差"), "%", low=0.0, high=20.0, default=2.0, step=0.5,
               group=ERRORS, hint=Text("Every entry of the true C is this much larger or smaller.", "真实 C 的每个元素都大或小这么多。")),
        Number("signs", "", Text("signs of the errors", "误差的符号"), low=0, high=20, default=1, scale="integer", group=ERRORS,
               hint=Text("0: every entry is larger; 1 to 20: signs drawn at random.", "0：每个元素都偏大；1 至 20：符号随机抽取。")),
        Number("push", "v", Text("amplitude of v", "v 的幅值"), model.input_unit, low=0.0, high=5 * model.u_max, default=model.u_max,
               group=ERRORS, hint=Text("v = a sin ωt with three periods in the run.", "v = a sin ωt，运行中共三个周期。")),
        Choice("norm", "", Text("norm in J", "J 中的范数"), default="2", group=SEARCH,
               when=("order", tuple(str(q) for q in orders if q > 1)),
               options=tuple((name, same("∞" if name == "inf" else name)) for name in NORMS),
               hint=Text("Column sum, spectral or row sum norm; for order 1 all three agree.",
                         "列和范数、谱范数或行和范数；一阶时三者相同。")),
        *weight_knobs(),
        Number("region_low", "a", Text("region for RLO, left end", "RLO 区域左端"), "rad/s", low=-1.5 * speed, high=-0.5 * speed,
               default=-speed, group=SEARCH, hint=Text("RLO keeps every pole right of this.", "RLO 使所有极点都在此线右侧。")),
        Number("region_high", "b", Text("region for RLO, right end", "RLO 区域右端"), "rad/s", low=-0.45 * speed, high=-0.002 * speed,
               default=-0.02 * speed, group=SEARCH, hint=Text("RLO keeps every pole left of this.", "RLO 使所有极点都在此线左侧。")),
        Number("region_tall", "c", Text("region for RLO, largest |Im s|", "RLO 区域 |Im s| 的上限"), "rad/s", low=0.0, high=o.im_high,
               default=0.0, group=SEARCH,
               hint=Text("0: real poles only. Pairs take RLO longer.", "0：只取实极点。允许共轭对时 RLO 耗时更长。")),
    )
