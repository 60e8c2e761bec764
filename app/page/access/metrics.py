"""Write the figures of `/health` in the form that Prometheus reads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

KIND = "text/plain; version=0.0.4; charset=utf-8"
GAUGES = MappingProxyType({
    "tabs": "tabs that are open", "most_tabs": "tabs that find a place", "kept_places": "places kept for tabs whose connection broke",
    "stuck": "threads that go on although their tab was ended", "seconds": "seconds since the server began",
    "resident_bytes": "memory of all workers in bytes", "lag_s": "seconds that the slowest event loop took to answer"})
OF_A_WORKER = MappingProxyType({
    "stands": "whether a worker takes connections", "tabs": "tabs of a worker", "stuck": "threads of a worker that go on",
    "seconds": "seconds since a worker's process began", "starts": "processes that a worker has had",
    "resident_bytes": "memory of a worker in bytes", "lag_s": "seconds that a worker's event loop took to answer"})


def metrics_text(health: Mapping[str, Any]) -> str:
    """One gauge for each figure, and one for each of every worker; `store_up` is 0 where the room's store cannot be used."""
    return "\n".join(_lines(health))


def _lines(health: Mapping[str, Any]) -> Iterator[str]:
    yield from _gauge("info", "the version that runs", [(f'{{version="{_escaped(health["version"])}"}}', 1)])
    yield from _gauge("up", "whether all works that the server knows of", [("", int(health["status"] == "ok"))])
    if "store" in health:
        yield from _gauge("store_up", "whether the room's store can be read and written", [("", int(health["store"] == "ok"))])
    for name, words in GAUGES.items():
        yield from _gauge(name, words, [("", health[name])])
    workers = health.get("workers", ())
    for name, words in OF_A_WORKER.items() if workers else ():
        yield from _gauge(f"worker_{name}", words, [(f'{{worker="{each["worker"]}"}}', each[name]) for each in workers])


def _gauge(name: str, words: str, samples: list[tuple[str, Any]]) -> Iterator[str]:
    yield f"# HELP observer_lab_{name} {words}"
    yield f"# TYPE observer_lab_{name} gauge"
    for labels, value in samples:
        yield f"observer_lab_{name}{labels} {float(value):.10g}"


def _escaped(words: object) -> str:
    return str(words).replace("\\", r"\\").replace('"', r'\"').replace("\n", r"\n")
