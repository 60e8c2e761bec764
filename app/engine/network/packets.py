"""Draw packets on a link: which are lost, when the others arrive, how old the newest is."""

from __future__ import annotations

import numpy as np

from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import GENERATOR, SHARE, WHOLE, count, gated, passed, takes
from ..systems.records import record

__all__ = ["Link"]

LOST_PACKET = -1
LATEST = 64  # samples a packet may be late


@record(eq=True)
class Link:
    """What happens to packets: each is lost with probability `loss`, and arrives `delay` + 0 … `jitter` samples late.

    Losses are independent, every extra delay up to `jitter` is equally likely, so packets may overtake each other.

    >>> Link(loss=0.2).loss
    0.2
    """

    loss: float = 0.0
    delay: int = 0
    jitter: int = 0

    def __post_init__(self) -> None:
        passed(self, loss=SHARE, delay=count(), jitter=count())
        if self.latest > LATEST:
            raise EngineError("Delay and jitter are whole numbers of samples ≥ 0, together at most {latest}.",
                              latest=LATEST)

    @property
    def latest(self) -> int:
        """The longest delay in samples."""
        return self.delay + self.jitter

    @gated(steps=count(0, 10_000_000), rng=GENERATOR)
    def draw(self, steps: int, rng: np.random.Generator) -> np.ndarray:
        """The sample at which each packet arrives (steps,), −1 if it is lost.

        Of two losses drawn from equal generators the larger one loses all that the smaller one loses.
        """
        chance, extra = rng.random(steps), rng.random(steps)
        arrivals = np.arange(steps) + self.delay + np.floor(extra * (self.jitter + 1)).astype(int)
        return np.where(chance < self.loss, LOST_PACKET, arrivals)


@takes(arrivals=WHOLE)
def newest_packet_age(arrivals: np.ndarray) -> np.ndarray:
    """How many samples old the newest packet is that has arrived by each sample (N,); k + 1 where none has."""
    if arrivals.ndim != 1:
        raise ShapeError("{name} must have one dimension, not {ndim}.", name="arrivals", ndim=arrivals.ndim)
    newest = np.full(len(arrivals), LOST_PACKET)
    for j, k in enumerate(arrivals):
        if LOST_PACKET < k < len(arrivals):
            newest[k] = j  # j rises, so the newest packet of this sample stays
    return np.arange(len(arrivals)) - np.maximum.accumulate(newest)
