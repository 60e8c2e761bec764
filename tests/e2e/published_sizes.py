"""Print what a published folder takes: `python tests/e2e/published_sizes.py FOLDER`.

For each lesson its files in all looks, those that one reader loads who sees every scene in one look, and its largest scene, in MB as
they lie in the folder. What a dialog takes, as the page of lessons, is loaded where it is opened, and counts among all looks.
The status is 1 where a lesson or the folder is larger than asked.
"""

from __future__ import annotations

import argparse
import gzip
import sys
from collections.abc import Iterable
from pathlib import Path
from statistics import median

MOST_LESSON, MOST_MEDIAN, MOST_FOLDER, MOST_FIRST = 10.0, 4.0, 150.0, 1.8  # MB; the first is page and first scene, as sent
MEGA = 1e6


def read_by_one(folder: Path, look: str) -> list[Path]:
    """The files of a lesson or a scene that a reader loads in a look such as en-light-wide."""
    return [path for name in (look, look.partition("-")[0], "arrays") if (path := folder / f"{name}.js").is_file()]


def megabytes(paths: Iterable[Path]) -> float:
    """The size of files."""
    return sum(path.stat().st_size for path in paths) / MEGA


def sent(paths: Iterable[Path]) -> float:
    """The size of files as a web server that packs sends them."""
    return sum(len(gzip.compress(path.read_bytes(), 6)) for path in paths) / MEGA


def main() -> int:
    """Print the table of a folder."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    page, ones, whole, first = folder / "index.html", [], 0.0, []
    print(f"{'lesson':<20} all looks  one look  largest scene (MB)")
    for lesson in sorted(path for path in (folder / "data").iterdir() if path.is_dir()):
        look = sorted(path.stem for path in lesson.glob("*-wide.js"))[0]
        scenes = [path for path in lesson.iterdir() if path.is_dir()]
        one = megabytes([page, *(file for place in (lesson, *scenes) for file in read_by_one(place, look))])
        every, largest = megabytes(lesson.rglob("*.js")), max(megabytes(read_by_one(scene, look)) for scene in scenes)
        print(f"{lesson.name:<20} {every:9.2f} {one:9.2f} {largest:9.2f}")
        ones.append(one)
        whole += every
        if (lesson / "meet").is_dir():
            first.append(sent([page, *read_by_one(lesson, look), *read_by_one(lesson / "meet", look)]))
    print(f"{len(ones)} lessons, with the page: one look {median(ones):.2f} in the median, {max(ones):.2f} at most; "
          f"page and first scene {max(first, default=0.0):.2f} at most as sent; all {whole + megabytes([page]):.1f}")
    return int(max(ones) > MOST_LESSON or median(ones) > MOST_MEDIAN or whole > MOST_FOLDER or max(first, default=0.0) > MOST_FIRST)


if __name__ == "__main__":
    sys.exit(main())
