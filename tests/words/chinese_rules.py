"""Rules for plain Chinese sentences: words that do not stand, the contexts in which they may, and the length."""

from __future__ import annotations

import re
from collections.abc import Container
from types import MappingProxyType

from word_rules import NUMBERS, PATTERNS, masked

MAX_CHARACTERS = 60  # Chinese ones of a sentence
CHARACTER = re.compile("[\u4e00-\u9fff]")

PERSON = "(?<!你)(?<!们)(?<!谁)(?<!学生)(?<!容易)(?<!误解：)(?<!有人)"  # may believe, hear and know
THING = "(?:器|机|线圈|回路|闭环|模型|方程|检验|残差|新息|读数|记录|误差|估计|成员|对象|它|者|双方|两边)"

WORDS: MappingProxyType[str, tuple[str, ...]] = MappingProxyType({
    "a thing acts like a person": (
        f"{PERSON}(?:相信|以为|认为|觉得|怀疑|忘掉|忘记|忘得|听到|听见|听得|听不|感到|察觉)",
        f"{PERSON}{THING}[^，。；：？！“”]{{0,4}}(?:知道|得知|看得?不?[见到])",
        "(?:告诉|告知)(?!你|学生|全班)", "没有?人(?:告诉|报告|预告|知道)", "不?知情", "谎|诚实|真相|信念", "安静|沉默",
        "胆[大小怯]", "判决", "指控|被告|证人|无辜", "原谅|承诺|许诺", "独自演化|各行其是"),
    "an idiom": (
        "对症下药|了如指掌|无能为力|前功尽弃|便知分晓|无济于事|毫无|一字不差|无所不知|无从|无妨", "到得了|不妨|而已|全凭|一模一样",
        "初值错两倍|停在指令旁边|颜色(?:已经)?变成|弹簧是弯|结论为“否”|自报",
        "心急|说了算|露了?馅|孪生|胜负|赛跑|对手", "救[不得]?[回了]|谁也|跑飞|淹没|够不到", "(?:管|镇|顶|稳)得?不?住"),
    "another word than the standard one": (
        "能观(?![察测看])|能控(?!制)", "请在请在", "选项卡", "煤气炉|过渡误差", "舞台|[本这下上一]幕"),
    NUMBERS: PATTERNS[NUMBERS],
})
RULES = tuple((name, tuple(re.compile(pattern) for pattern in patterns)) for name, patterns in WORDS.items())


def chinese_offences(sentence: str, allowed: Container[str] = ()) -> list[str]:
    """What is wrong with a Chinese sentence, one phrase for each find: the rule and the words found. `allowed` names rules left out."""
    plain = masked(sentence).strip()
    found = [f"{name}: {hit[0].strip()}" for name, patterns in RULES if name not in allowed for pattern in patterns
             if (hit := pattern.search(plain))]
    count = len(CHARACTER.findall(plain))
    return found + [f"{count} characters, {MAX_CHARACTERS} at most"] * (count > MAX_CHARACTERS)
