"""Print sentences that break the rules of plain English or Chinese, with file and line, and the figures of length.

`python tests/words/report.py [FILE or FOLDER …]` reads these files, or all; it ends with 1 where a sentence breaks a rule.
"""

from __future__ import annotations

import statistics
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

HERE = Path(__file__).resolve().parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent)]

from chinese_rules import chinese_offences  # noqa: E402
from word_rules import NUMBERS, offences, word_count  # noqa: E402
from word_sources import CHINESE, Sentence, of_files  # noqa: E402


def offenders(all_of_them: Iterable[Sentence]) -> dict[Sentence, list[str]]:
    """Sentences that break a rule, and how."""
    found = ((one, (chinese_offences if one.file.startswith(CHINESE) else offences)(one.words, (NUMBERS,) if one.script else ()))
             for one in all_of_them)
    return {one: why for one, why in found if why}


def figures(all_of_them: Iterable[Sentence]) -> str:
    """How many English sentences there are and how long: median and 95th percentile, of those of three words or more."""
    counts = sorted(count for one in all_of_them if not one.file.startswith(CHINESE) and (count := word_count(one.words)) >= 3)
    if not counts:
        return "no sentences"
    high = counts[min(len(counts) - 1, round(0.95 * len(counts)))]
    return f"{len(counts)} sentences; median {statistics.median(counts):g} words, 95th percentile {high}, longest {counts[-1]}"


def main(names: list[str]) -> int:
    """Print them; 1 where there are any."""
    every = of_files(names)
    bad = offenders(every)
    for one, why in sorted(bad.items(), key=lambda pair: (pair[0].file, pair[0].line)):
        print(f"{one.where}: {'; '.join(why)}\n    {one.words}")
    rules = Counter(reason.split(":")[0] if ":" in reason else "too long" for why in bad.values() for reason in why)
    print(f"\n{figures(every)}\n{len(bad)} offenders" + "".join(f", {count} × {rule}" for rule, count in rules.most_common()))
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
