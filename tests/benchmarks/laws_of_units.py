"""Every law of units on many random plants: how often each is broken.

    python tests/benchmarks/laws_of_units.py [plants] [seed]
"""

from __future__ import annotations

import sys
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2]), str(Path(__file__).resolve().parents[1] / "engine")]

from unit_cases import random_case, random_units  # noqa: E402
from unit_laws import LAWS, breach  # noqa: E402


def main(plants: int = 500, seed: int = 1) -> None:
    """Print a row for each law: broken, refused in one of two units, warnings and exceptions; and one example."""
    broken: Counter[str] = Counter()
    example: dict[str, str] = {}
    for k in range(plants):
        rng = np.random.default_rng((seed, k))
        case = random_case(rng, sampled=k % 4 == 3)
        units = random_units(case, rng)
        for law in LAWS:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    wrong = breach(law, case, units)
                except Exception as problem:
                    wrong = f"{law}: {type(problem).__name__}: {problem}"
            if wrong:
                broken[law] += 1
                example.setdefault(law, f"plant {k}: {wrong}"[:150])
    for law in LAWS:
        print(f"{law:16s} {broken[law]:5d} of {plants}   {example.get(law, '')}")
    print(f"{'all laws':16s} {sum(broken.values()):5d} of {plants * len(LAWS)}")


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3]))
