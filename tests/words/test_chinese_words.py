"""Plain Chinese: the rules find what a control engineer would not write, and leave the standard words alone."""

from __future__ import annotations

from chinese_rules import MAX_CHARACTERS, chinese_offences
from report import offenders
from word_rules import NUMBERS
from word_sources import CHINESE, Sentence, chinese

DECODED = (  # words of the guide to our voice, and sentences that stood in the lab
    "能观", "能控且能观", "位于 2 的模态不能观", "无故障的成员保持安静。", "说谎者", "它是谎言。", "判决", "听得到的模态", "胆大",
    "传感器听不到同步运动。", "胆小的滤波器", "请在请在请在", "观测器以为是 2°。", "滤波器相信的过程噪声越大", "初始误差被忘掉。",
    "它忘得有多快", "观测器并不知道。", "编码器看不见机械臂。", "把真相告诉观测器。", "告诉它实际力", "没有人报告的推力", "胜负",
    "误差独自演化。", "了如指掌，却无能为力", "对症下药", "心急的代价", "到得了与听得见", "孪生", "误差毫无察觉。", "谁也救不回来。",
    "“结构”选项卡", "请看舞台。", "本幕没有提问。", "峰值为 1.3e+02。", "改变了 -39.6。", "差" * (MAX_CHARACTERS + 1))
PLAIN = (
    "可观", "可控且可观", "位于 2 的模态不可观", "残差未超阈值", "故障传感器", "诊断结论", "测得到", "测不到", "过于自信", "过于保守",
    "指令力与实际力", "设定值", "补偿器状态卷绕", "回路传递恢复（LTR）", "能观察到误差的变化。", "就能控制平台。", "你知道增益 $K$。",
    "学生知道极点的位置。", "常见误解：以为同一对象的 K 和 L 互为转置。", "关于它的观测器，你知道了什么？", "误差方程是自治的。",
    "估计从 2° 开始。", "把实际力送给观测器。", "改变了 −39.6。", "取 $e=-1$，即 {value:.3g}。", "差" * MAX_CHARACTERS)


def test_a_chinese_sentence_that_has_to_be_decoded_is_found() -> None:
    assert [sentence for sentence in DECODED if not chinese_offences(sentence)] == []


def test_a_plain_chinese_sentence_is_left_alone() -> None:
    assert [(sentence, why) for sentence in PLAIN if (why := chinese_offences(sentence))] == []


def test_comments_of_chinese_scripts_may_write_numbers_in_ascii() -> None:
    assert chinese_offences("误差 1.3e-6") and not chinese_offences("误差 1.3e-6", (NUMBERS,))


def test_chinese_files_are_judged_by_the_chinese_rules() -> None:
    words = "观测器以为它静止。"
    assert [one.file for one in offenders([Sentence(words, f"{CHINESE}arm.md", 1), Sentence(words, "lessons/arm/en.md", 1)])] == [
        f"{CHINESE}arm.md"]


def test_chinese_sentences_end_at_their_stop_and_stand_in_pages_and_catalogues() -> None:
    every = [*chinese()]
    assert len(every) > 8000 and not [one for one in every if "。" in one.words[:-1].rstrip("”）*_") and "“" not in one.words][:3]
    files = {one.file.removeprefix(CHINESE) for one in every}
    assert {"arm.md", "arm.path.md", "arm.teacher.md", "arm.po", "glossary.md", "page.po", "engine.po", "comments.po"} <= files
