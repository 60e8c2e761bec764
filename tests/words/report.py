"""Print sentences that break the rules of plain English or Chinese, with file and line; keep the list of known ones.

`python tests/words/report.py [FILE or FOLDER …]` prints every offender and the figures of length; `--new` those alone that are not in
the list of known ones. `--update` takes from that list what is gone. `--begin` writes it anew: only where rewritten text has
to wait, as after a merge, since a sentence that is in the list fails no test.
"""

from __future__ import annotations

import hashlib
import statistics
import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path

HERE = Path(__file__).resolve().parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent)]

from chinese_rules import chinese_offences  # noqa: E402
from word_rules import NUMBERS, masked, offences, word_count  # noqa: E402
from word_sources import CHINESE, Sentence, every_sentence, of_files  # noqa: E402

BASELINE = HERE / "known_offenders.txt"
HEAD = "# Sentences that still break the rules: a hash of each. `python tests/words/report.py --update` shortens the list.\n"


def mark(sentence: str) -> str:
    """A hash of a sentence: the same wherever it stands and whatever values, formulas and code stand in it."""
    return hashlib.sha256(" ".join(masked(sentence).lower().split()).encode()).hexdigest()[:12]


def known() -> dict[str, str]:
    """The list: hash → where the sentence stood and how it begins."""
    lines = BASELINE.read_text(encoding="utf-8").splitlines() if BASELINE.is_file() else []
    return dict(line.split(" ", 1) for line in lines if line and not line.startswith("#"))


def offenders(all_of_them: Iterable[Sentence]) -> dict[Sentence, list[str]]:
    """Sentences that break a rule, and how."""
    found = ((one, (chinese_offences if one.file.startswith(CHINESE) else offences)(one.words, (NUMBERS,) if one.script else ()))
             for one in all_of_them)
    return {one: why for one, why in found if why}


def listed(bad: Iterable[Sentence]) -> dict[str, str]:
    """Entries of the list for these sentences."""
    return {mark(one.words): f"{one.file}: {' '.join(one.words.split()[:6])}" for one in bad}


def write(entries: Mapping[str, str]) -> None:
    """Write the list, by place."""
    lines = sorted(entries.items(), key=lambda entry: (entry[1], entry[0]))
    BASELINE.write_text(HEAD + "".join(f"{key} {place}\n" for key, place in lines), encoding="utf-8")


def figures(all_of_them: Iterable[Sentence]) -> str:
    """How many English sentences there are and how long: median and 95th percentile, of those of three words or more."""
    counts = sorted(count for one in all_of_them if not one.file.startswith(CHINESE) and (count := word_count(one.words)) >= 3)
    if not counts:
        return "no sentences"
    high = counts[min(len(counts) - 1, round(0.95 * len(counts)))]
    return f"{len(counts)} sentences; median {statistics.median(counts):g} words, 95th percentile {high}, longest {counts[-1]}"


def update(begin: bool) -> None:
    """Shorten the list, or begin it anew; print what is gone and how many are new."""
    there, before = listed(offenders(every_sentence())), known()
    write(there if begin else {key: there[key] for key in there if key in before})
    for key in sorted(before.keys() - there.keys(), key=lambda each: before[each]):
        print(f"gone: {before[key]} …")
    print(f"{len(before)} known offenders before, {len(known())} now; {len(before.keys() - there.keys())} gone, "
          f"{len(there.keys() - before.keys())} new")


def main(arguments: list[str]) -> int:
    """Print or update; 1 where new offenders were printed under `--new`."""
    flags, names = {a for a in arguments if a.startswith("--")}, [a for a in arguments if not a.startswith("--")]
    if unknown := flags - {"--new", "--update", "--begin"}:
        print(f"There is no option {', '.join(sorted(unknown))}; use --new, --update or --begin.", file=sys.stderr)
        return 2
    if flags & {"--update", "--begin"}:
        update("--begin" in flags)
        return 0
    every, listed_already = of_files(names), known()
    bad = {one: why for one, why in offenders(every).items() if "--new" not in flags or mark(one.words) not in listed_already}
    for one, why in sorted(bad.items(), key=lambda pair: (pair[0].file, pair[0].line)):
        print(f"{one.where}: {'; '.join(why)}\n    {one.words}")
    rules = Counter(reason.split(":")[0] if ":" in reason else "too long" for why in bad.values() for reason in why)
    print(f"\n{figures(every)}\n{len(bad)} offenders" + "".join(f", {count} × {rule}" for rule, count in rules.most_common()))
    return int("--new" in flags and bool(bad))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
