"""Choose fonts for exports: a serif for Latin and mathematics, an installed font for Chinese.

No font is shipped and no font package is required: those on PyPI weigh from 15 to 60 MB or have a single release, and
matplotlib finds whatever the system has. Without one, a warning says what to install.
"""

from __future__ import annotations

import warnings
from functools import lru_cache

from matplotlib import font_manager

__all__ = ["MissingFontWarning", "chinese_font", "families"]

SERIF = ("STIXGeneral", "DejaVu Serif", "DejaVu Sans")  # all come with matplotlib; each holds what those before it lack
CHINESE_SAMPLE = "".join(map(chr, (0x89C2, 0x6D4B, 0x5668, 0x8BEF, 0x5DEE, 0x6781, 0x70B9, 0x56FE)))  # observer, error, pole plot
PREFERRED = (
    "Noto Serif CJK SC", "Noto Serif SC", "Source Han Serif SC", "Source Han Serif CN", "Songti SC", "STSong", "SimSun",
    "FandolSong", "AR PL SungtiL GB", "AR PL UMing CN", "Noto Sans CJK SC", "Noto Sans SC", "Source Han Sans SC",
    "Source Han Sans CN", "PingFang SC", "Hiragino Sans GB", "Heiti SC", "Microsoft YaHei", "SimHei",
    "WenQuanYi Micro Hei", "WenQuanYi Zen Hei", "Noto Serif CJK JP", "Noto Sans CJK JP", "Droid Sans Fallback",
    "Arial Unicode MS",
)
HAN = frozenset({"zh", "ja", "ko"})  # languages whose glyphs a Latin font has not
INSTALL = ("No installed font holds Chinese, so Chinese words will show as boxes in this figure; install one, for "
           "example the package fonts-noto-cjk.")


class MissingFontWarning(UserWarning):
    """A figure in Chinese was drawn without a font that holds Chinese."""


def families(language: str) -> list[str]:
    """Font families in the order in which a glyph is looked for, so that a plant's Chinese names show in an English figure too.

    Warns (MissingFontWarning) if Chinese is missing for a language that needs it.
    """
    chinese = chinese_font()
    if language.split("_")[0] not in HAN:
        return [*SERIF, *([] if chinese is None else [chinese])]
    if chinese is None:
        warnings.warn(INSTALL, MissingFontWarning, stacklevel=2)
        return list(SERIF)
    return [SERIF[0], chinese, *SERIF[1:]]


@lru_cache(maxsize=1)
def chinese_font() -> str | None:
    """The family of the best installed font that holds Chinese, a serif if there is one; None if there is none.

    matplotlib keeps a list of fonts from an earlier run; where it holds none, the disk is looked at again.
    """
    known = font_manager.fontManager.ttflist
    ranked = sorted((entry for entry in known if "Last Resort" not in entry.name), key=lambda e: _rank(e.name))
    for entry in ranked:
        if _holds_chinese(entry.fname):
            return entry.name
    for path in sorted(set(font_manager.findSystemFonts()) - {entry.fname for entry in known}):
        if _holds_chinese(path):
            font_manager.fontManager.addfont(path)
            return font_manager.fontManager.ttflist[-1].name
    return None


def _rank(name: str) -> tuple[int, str]:
    return (PREFERRED.index(name), "") if name in PREFERRED else (len(PREFERRED), name)


@lru_cache(maxsize=4096)
def _holds_chinese(path: str) -> bool:
    try:
        font = font_manager.get_font(path)
        return all(font.get_char_index(ord(letter)) for letter in CHINESE_SAMPLE)
    except (OSError, RuntimeError):  # a broken font file is no font
        return False
