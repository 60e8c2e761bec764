"""Compare every published number with ours: `verify`."""

from __future__ import annotations

import argparse

from ..options import add_json

HELP = "every published number beside ours"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `verify`."""
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print the table; 1 if one verdict is not what it should be."""
    from ...published import records, table, verify_all
    from ..printing import print_json

    results = verify_all(records())
    if options.json:
        print_json([result.record() for result in results])
    else:
        print(table(results))
    return 0 if all(result.holds for result in results) else 1
