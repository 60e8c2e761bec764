"""What an error says that nobody foresaw: its kind, in words. The sentence of a library would help nobody here."""

from __future__ import annotations

from types import MappingProxyType

from ..text.words import Text

KINDS = MappingProxyType({
    "LinAlgError": Text("a matrix is singular or an iteration did not converge", "矩阵奇异或迭代不收敛"),
    "ZeroDivisionError": Text("a division by zero", "除数为零"),
    "OverflowError": Text("a number grew too large", "数值过大"),
    "FloatingPointError": Text("a number is no longer finite", "出现了非有限的数"),
    "MemoryError": Text("not enough memory", "内存不足"),
    "RecursionError": Text("the input is nested too deeply", "输入嵌套过深"),
})


def kind_of(problem: Exception) -> Text:
    """What kind of error this is, in a few words of both languages; its class is named where that is all there is."""
    name = type(problem).__name__
    return KINDS.get(name, Text(f"an error in the program, {name}", f"程序出错：{name}"))
