"""What goes wrong is told in Chinese on the Chinese page: every sentence of the source, with every value in it."""

from __future__ import annotations

import ast
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from raised import Hole, Raised, Source, samples, source

from app.engine import EngineError, Plant, PoleError, RiccatiError, ShapeError, lqr, observer_gain, place
from app.sentences import TABLES, chinese, kind_of, recognise, told
from app.text.words import Text

HAN = re.compile(r"[\u4e00-\u9fff]")
PAIRS = [pair for table in TABLES for pair in table.SENTENCES]
# Names that a Chinese sentence keeps: of files, formats, functions and parameters, and of people.
WORD = re.compile(r"(?<![A-Za-z_])[A-Za-z]{2}[A-Za-z_]+")
KEPT = frozenset(WORD.findall("""
    Hankel JSON MATLAB NaN UTF json mat object rad True StateSpace control plant stable split_stable sampled_lqg from_plant
    each_column predict save observability_gramian reachability_gramian alpha beta gamma delta_A delta_C fed applied commanded
    told asked on_loss hold zero order arrival stamped free im_high im_low re_high re_low inf norm jumps max_order name
    process readings rank rows rtol runs slope units weight xhat vertical rotation horizontal"""))


def everything_raised() -> list[Raised]:
    return list(source().raised())


def reached_words() -> set[str]:
    """Every fixed word that reaches a place in a sentence."""
    return {word for raised in everything_raised() for part in raised.sentence if isinstance(part, Hole) for word in part.words}


def wrong(english: str) -> str:
    """What is wrong with the Chinese of a sentence, nothing if it is well."""
    zh = chinese(english)
    if zh is None:
        return "no translation"
    left = [word for word in WORD.findall(zh) if word not in KEPT]
    if left:
        return f"English left in it: {left}: {zh}"
    lost = [number for number in re.findall(r"\d{3}", english) if number not in zh]
    return f"lost {lost}: {zh}" if lost else "" if HAN.search(zh) else f"not Chinese: {zh}"


def test_the_walk_of_the_source_finds_what_is_raised() -> None:
    """A net with holes would let every other test here pass."""
    found = {r.template for r in everything_raised()}
    assert len(found) > 290
    assert "B must have {} rows, as A has; it is {}×{}." in found  # an f-string
    assert "The mode at {} is not stable and is {}: no {} can stabilise it; change the plant." in found  # from a helper
    assert "rank(CE) = {} is less than rank(E) = {}: the unknown input does not reach the outputs at once; measure nearer to " \
           "where it enters." in found  # from a field of a record
    assert "{} cannot be differentiated by a complex step; give its Jacobian." in found  # by way of a local name
    assert "{} must be a positive number of seconds." in found  # one of two alternatives
    assert {"uncontrollable", "The horizon", "Each name in C"} <= reached_words()


def test_nothing_is_raised_past_the_walk() -> None:
    """Each of these classes is given its sentence as its first argument, and has no subclass that is left out."""
    bare = [f"{name}: {ast.unparse(call)}" for name in ("EngineError", "ShapeError", "PoleError", "RiccatiError")
            for call, _ in source().calls.get(name, ()) if len(call.args) != 1 or call.keywords]
    assert not bare
    assert not [r.place for r in everything_raised() if not any(isinstance(p, str) and p.strip() for p in r.sentence)]
    known = {"EngineError", "ShapeError", "PoleError", "RiccatiError", "Misfit"}
    assert {kind.__name__ for kind in _below(EngineError)} <= known


def _below(kind: type) -> set[type]:
    return {kind}.union(*(_below(sub) for sub in kind.__subclasses__()))


def test_every_sentence_has_its_chinese() -> None:
    bad = {f"{raised.place}: {english!r}": problem for raised in everything_raised() for english in samples(raised.sentence)
           if (problem := wrong(english))}
    assert not bad, "\n".join(f"{k}: {v}" for k, v in bad.items())


def test_the_tables_hold_nothing_that_nobody_says() -> None:
    used = {found[0] for raised in everything_raised() for english in samples(raised.sentence) if (found := recognise(english))}
    used |= {found[0] for word in reached_words() if (found := recognise(word))}
    assert not {english for english, _ in PAIRS} - used


def test_no_sentence_is_translated_twice() -> None:
    english = [en for en, _ in PAIRS]
    assert len(set(english)) == len(english)


@pytest.mark.parametrize("en, zh", PAIRS, ids=[en[:40] for en, _ in PAIRS])
def test_a_translation_takes_every_value_and_no_other(en: str, zh: str) -> None:
    places, taken = en.count("{}"), re.findall(r"\{(\d*)\}", zh)
    assert "{" not in re.sub(r"\{\d*\}", "", zh)
    assert zh.count("{}") == places or {int(i) for i in taken} == set(range(places))
    assert HAN.search(zh) and en.endswith(".") == zh.endswith("。")


VALUES = st.one_of(st.integers(0, 10**6).map(str), st.floats(allow_nan=False).map(lambda v: f"{v:.4g}"),
                   st.lists(st.integers(0, 99), max_size=3).map(lambda v: str(tuple(v))),
                   st.sampled_from(["A", "Cᵀ", "Q − N R⁻¹ Nᵀ", "-1 + 2j", "3 -0.5j", "'rail'", "x̂", "NaN", "u_max", "{0}", "{}"]))


@given(st.sampled_from([pair for pair in PAIRS if "{}" in pair[0]]), st.lists(VALUES, min_size=8, max_size=8))
def test_values_of_any_kind_come_through(pair: tuple[str, str], values: list[str]) -> None:
    english = pair[0].format(*values) if pair[0] != "Each name in {}" else f"Each name in {values[0]}"
    zh = chinese(english)
    assert zh is not None and HAN.search(zh)
    for value in values[:pair[0].count("{}")]:
        assert value in zh


def test_a_sentence_within_a_sentence_is_told_in_chinese_too() -> None:
    zh = chinese("The pole at 2 is not stable, so the integral to infinity diverges; "
                 "take the Hankel values of split_stable(plant).stable.")
    assert zh == "位于 2 的极点不稳定，积分到无穷时发散；请对 split_stable(plant).stable 求 Hankel 奇异值。"
    inner = "P is not positive definite; leave out states that are known exactly"
    assert chinese(f"There is no plant {inner}.; choose one of a, b.") == "没有对象 P 不正定；请去掉精确已知的状态。；请从 a, b 中选择。"


def test_shapes_that_follow_one_another_stay_whole() -> None:
    zh = chinese("x and x̂ must both be (n_t, n) or (runs, n_t, n); they are (3, 2), (4, 2).")
    assert zh == "x 与 x̂ 应同为 (n_t, n) 或 (runs, n_t, n)；现为 (3, 2)、(4, 2)。"


def test_what_nobody_translated_is_still_told() -> None:
    assert told(EngineError("Seven is not a gain; choose another.")) == Text(
        "Seven is not a gain; choose another.", "无法计算（Seven is not a gain; choose another.）")
    assert chinese("x" * 10_000) is None and chinese("") is None


def test_an_unforeseen_error_is_named_by_its_kind() -> None:
    assert kind_of(np.linalg.LinAlgError("Singular matrix")).zh == "矩阵奇异或迭代不收敛"
    assert kind_of(KeyError("gain")) == Text("an error in the program, KeyError", "程序出错：KeyError")


@pytest.mark.parametrize("raises, kind, zh", [
    (lambda: place([[0, 1], [0, 0]], [[1], [0]], [-1, -2]), PoleError,
     "位于 0 的模态不能控：任何 K 都移不动它，请在所求极点中保留 0。"),
    (lambda: observer_gain([[2, 0], [0, -1]], [[0, 1]], [-1, -3]), PoleError,
     "位于 2 的模态不能观：任何 L 都移不动它，请在所求极点中保留 2。"),
    (lambda: place([[0, 1], [0, 0]], [[0], [1]], [-1 + 1j, -2]), PoleError,
     "复极点 -1 + 1j 缺少共轭极点 -1 - 1j：实增益只能成对移动复极点，请同时给出。"),
    (lambda: Plant([[0, 1], [0, 0]], [[0, 1, 2]], [[1, 0]]), ShapeError, "B 应与 A 一样有 2 行，现为 1×3。"),
    (lambda: Plant([[0, 1], [0, np.nan]], [[0], [1]], [[1, 0]]), EngineError, "A 含有 NaN 或无穷大；每个元素都必须是有限的数。"),
    (lambda: Plant([[1]], [[1]], [[1]], state_names=("a", "b")), ShapeError, "共有 1 个状态，却给了 2 个状态名称；请各给一个名称。"),
    (lambda: lqr([[1, 0], [0, 2]], [[0], [1]], np.eye(2), [[1]]), RiccatiError,
     "位于 1 的模态不稳定且不能控：任何 K 都不能使它稳定；请修改对象。"),
    (lambda: lqr([[0]], [[1]], [[0]], [[1]]), RiccatiError, "位于 0 的模态在稳定边界上，权矩阵 Q 看不到它：请让 Q 作用于它。"),
    (lambda: lqr([[0]], [[1]], [[-1]], [[1]]), EngineError, "Q 有负特征值；它必须半正定。"),
])
def test_real_errors_of_the_engine(raises: object, kind: type[Exception], zh: str) -> None:
    with pytest.raises(kind) as caught:
        raises()  # type: ignore[operator]
    assert told(caught.value).zh == zh and told(caught.value).en == str(caught.value)


def test_an_error_inside_a_text_is_never_put_there_in_english() -> None:
    """Text(str(problem), f"…{problem}") would tell half of it in English; `told` knows both."""
    caught = {}
    for path, module in source().modules.items():
        for handler in (n for n in ast.walk(module) if isinstance(n, ast.ExceptHandler) and n.name):
            for call in (n for n in ast.walk(handler) if isinstance(n, ast.Call) and getattr(n.func, "id", "") == "Text"):
                names = {n.id for arg in call.args for n in ast.walk(arg) if isinstance(n, ast.Name)}
                if handler.name in names:
                    caught[f"{path.name}:{call.lineno}"] = ast.unparse(call)
    assert not caught


def test_the_walk_follows_words_to_where_they_are_given() -> None:
    """A new word that reaches a sentence must be missed if it has no Chinese."""
    module = source().modules
    code = "def check(x, what: str):\n    raise EngineError(f'{what} must be a list of finite numbers.')\n" \
           "def outer(x):\n    for name in ('The wind', 'The sun'):\n        check(x, name)\n"
    small = Source([])
    small.modules = {next(iter(module)): ast.parse(code)}
    small.index()
    (found,) = small.raised()
    assert samples(found.sentence) == ["The sun must be a list of finite numbers.", "The wind must be a list of finite numbers."]
    assert all("English left" in wrong(english) for english in samples(found.sentence))
