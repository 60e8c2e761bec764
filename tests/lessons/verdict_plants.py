"""Own plants on which verdicts were false once: without units, stiff, twins, unreachable, integrators, of first order."""

from __future__ import annotations

import json

from observer_lab.plants.own_plant import clean_plant_json

PLANTS = (
    {"A": [[-0.3, 0, 0], [0, -1, 1], [0, -2, -1]], "B": [[1], [0], [1]], "C": [[0, 1, 0]]},
    {"A": [[-0.3, 0, 0], [0, -1, 1], [0, -2, -1]], "B": [[1], [0], [1]], "C": [[1, 1, 0]]},
    {"A": [[0, 1, 0], [0, 0, 1], [0, 0, 0]], "B": [[0], [0], [1]], "C": [[1, 0, 0]]},
    {"A": [[-1, 0], [0, -1]], "B": [[1], [2]], "C": [[1, 1]]},
    {"A": [[-1]], "B": [[1]], "C": [[1]]},
    {"A": [[0.5]], "B": [[1]], "C": [[2]]},
    {"A": [[-2000, 0], [1, -0.5]], "B": [[2000], [0]], "C": [[0, 1]]},
    {"A": [[0.4, 0], [0, -1]], "B": [[0], [1]], "C": [[1, 1]]},
    {"A": [[0, 1], [4, 0]], "B": [[0], [1]], "C": [[1, 0]], "units": {"time": "s", "inputs": ["N"], "outputs": ["m"]}},
    {"A": [[0, 1], [-9, -0.2]], "B": [[0], [1]], "C": [[1, 0]]},
)


def _text(plant: dict[str, object]) -> str:
    try:
        return clean_plant_json(json.dumps(plant))
    except ValueError:
        return clean_plant_json(json.dumps({name: value for name, value in plant.items() if name != "units"}))


OWN_PLANTS = tuple(_text(plant) for plant in PLANTS)
