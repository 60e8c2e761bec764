"""Define the knobs of lesson 10 for one case or several, and the report lines in doubt."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Switch
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import Text, text, text_in

from ..toolkit.knobs import run_knobs
from .cases import DOYLE, REPORT, REPORT_FACTORS, Case

STEADY, RECURSIVE = "steady", "recursive"
STATE, ESTIMATE = "state", "estimate"  # what is fed back in the loop whose gains the blue lane shows
NONE, SPLIT_RULE, SENSOR_RULE, PROCESS_RULE, CAUTION_RULE, UNITS_RULE = "none", "split", "beta-r", "beta-q", "caution", "sigma"
WRONG_RULES = (SENSOR_RULE, UNITS_RULE)
RULES = (
    (NONE, text_in("lqg", "none")),
    (SPLIT_RULE, text("tune LQR first, then LQE")),
    (SENSOR_RULE, text("β_R ↑: sensor noise is suppressed less")),
    (PROCESS_RULE, text("β_Q ↑: the filter is faster and follows disturbances more")),
    (CAUTION_RULE, text("LQG has no robustness of its own")),
    (UNITS_RULE, text("σ_v = 10⁻⁹ gives V = 10⁻⁹")),
)
When = tuple[str, tuple[str, ...]] | None


def knobs_for(cases: tuple[Case, ...]) -> tuple[Choice | Number | Switch, ...]:
    """The knobs for these cases; with one case alone there is no choice of it."""
    first, several = cases[0], len(cases) > 1
    report: When = ("case", tuple(c.id for c in cases if c.id != DOYLE)) if several else None
    paper: When = ("case", (DOYLE,)) if several else None
    pick = () if not several else (Choice(
        "case", "", text_in("lqg", "case"), default=first.id, options=tuple((c.id, c.label) for c in cases),
        hint=text("The platform with the report's weights, or the counterexample of 1978.")),)
    doyle = (*_of_paper(paper), _lane(paper)) if DOYLE in [c.id for c in cases] else ()
    bar = (_noise_bar(report),) if REPORT in [c.id for c in cases] else ()
    return (*pick, *_of_report(first, report), *bar, *doyle, *_for_all(first, report),
            *run_knobs(min(c.horizon for c in cases)))


def _factor(name: str, symbol: str, label: Text, low: float, high: float, default: float, hint: Text, when: When) -> Number:
    return Number(name, symbol, label, low=low, high=high, default=default, scale="log", hint=hint, when=when)


def _of_report(case: Case, when: When) -> tuple[Number, ...]:
    """α_Q, α_R, β_Q, β_R and the true noise of the sensors; on the platform in the report's units and with its values."""
    named = case.id == REPORT
    aq, ar, br = (REPORT_FACTORS.alpha_q, REPORT_FACTORS.alpha_r, REPORT_FACTORS.beta_r) if named else (1.0, 1.0, 1.0)
    told = (text("V = β_R I in units of 10⁻¹⁸ (m/s)² s: the sensor noise that the filter assumes.") if named else
            text("V = β_R I: the sensor noise that the filter assumes."))
    return (
        _factor("alpha_q", r"\alpha_Q", text("state weight α_Q"), 1e-2, 1e6, aq,
                text("Q = α_Q Q₀: what motion costs. Only α_Q/α_R matters for K."), when),
        _factor("alpha_r", r"\alpha_R", text("input weight α_R"), 1e-4, 1e4, ar,
                text("R = α_R I: what force costs."), when),
        _factor("beta_q", r"\beta_Q", text("assumed disturbance β_Q"), 1e-3, 1e3, 1.0,
                text("W = β_Q W₀ is the disturbance that the filter assumes; the disturbance itself stays."), when),
        _factor("beta_r", r"\beta_R", text("assumed sensor noise β_R"), 1e-3, 1e12, br,
                told, when),
        _factor("sensor", r"V_{\mathrm{true}}", text("true sensor noise"), 1e-2, 1e12, 1.0,
                text("In the unit of β_R: what the sensors really do."), when),
    )


def _of_paper(when: When) -> tuple[Number, ...]:
    return (
        _factor("q", "q", text("state weight q"), 0.1, 1e4, 5.0,
                text("Q = q [1 1]ᵀ[1 1], R = 1."), when),
        _factor("sigma", r"\sigma", text("disturbance σ"), 0.1, 1e4, 5.0,
                text("W = σ [1 1]ᵀ[1 1], V = 1, both the true values and those that the filter assumes."), when),
    )


def _lane(when: When) -> Choice:
    return Choice("lane", "", text("blue lane of the stage"), default=ESTIMATE, when=when,
                  options=((ESTIMATE, text("LQG tolerates")), (STATE, text("with the state known"))),
                  hint=text("Gains at which the loop is stable: with the estimate or with the state fed back."))


def _noise_bar(when: When) -> Switch:
    return Switch("noise_bar", "", text("input from noise as a bar"), default=False, when=when,
                  hint=text("A bar before the deck: the input that sensor noise causes, over that at the default settings."))


def _for_all(case: Case, report: When) -> tuple[Choice | Number | Switch, ...]:
    inputs = tuple((str(i + 1), signal_name(case.plant, name)) for i, name in enumerate(case.plant.input_names))
    cut = () if len(inputs) < 2 else (Choice(
        "cut", "", text("loop cut at"), default="1", options=inputs, when=report,
        hint=text("Nyquist and margins: this input is cut, the others stay closed.")),)
    return (
        Number("recovery", r"\rho", text("recovery ρ"), low=0.0, high=10.0, default=0.0, step=0.5,
               hint=text("Decades of fictitious input noise that the filter assumes; 0 is plain LQG.")),
        Number("gain", "m", text("true gain of the inputs"), low=0.5, high=2.0, default=1.0, step=0.001,
               hint=text("How strong the inputs really are, times what the model says.")),
        *cut,
        Choice("filter", "", text("filter"), default=STEADY,
               options=((STEADY, text("steady gain (LQE)")),
                        (RECURSIVE, text("recursive, on a computer"))),
               hint=text("The gain of the Riccati equation, or Joseph's recursion step by step.")),
        Choice("rule", "", text("line of the report in doubt"), default=NONE, options=RULES,
               hint=text("The tab Report shows what this loop says about it.")),
    )
