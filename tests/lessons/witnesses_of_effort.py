"""Witnesses for equal effort: each loop written out as one matrix, commands on their way included, at frequencies of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import expm
from scipy.stats import norm
from witnesses import Shown, Witness, near, value

from observer_lab.lessons.showdown.controllers import LQE, OPEN_LOOP, ORDER, SHORT_NAMES, SISO
from observer_lab.lessons.showdown.equal_effort import Equal, retuned
from observer_lab.lessons.showdown.simulation import World, ground_filter
from observer_lab.plants.platform import model
from observer_lab.text import Text

H = 1e-3  # s: the computer's period
FROM, TO = 0.1, 499.0  # Hz
BAND = (0.5, 3.0)
EDGE = 1e-12  # below a radius of one: nearer than that is not said to be stable
CHANNELS = np.array([[0.5, 0, 0.5, 0], [0.5, 0, -0.5, 0], [0, 0.5, 0, -0.5]])
NEAR = np.geomspace(0.02, 300.0, 60)  # half widths beside a resonance
SAME = 0.03  # of an effort
DB = 0.3


@dataclass(frozen=True)
class Moved:
    """RMS from FROM to TO Hz: of the command that is largest (N), of the channels in µm/s, and the channels in the band alone."""

    force: float
    rms: np.ndarray
    band: np.ndarray


def _held(A: np.ndarray, B: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    n, m = B.shape
    step = expm(h * np.block([[A, B], [np.zeros((m, n + m))]]))
    return step[:n, :n], step[:n, n:]


def _mechanics(world: World) -> tuple[np.ndarray, ...]:
    """A, B of the commands, C, and the intensity of the noise of ground, deck and drivers as one continuous system."""
    p, hardware = model.plant(world.parameters), world.hardware
    A, B, C, W = p.A, p.B[:, :3], p.C, 1e-12 * p.B[:, 3:] @ p.B[:, 3:].T
    if world.shaped:
        g = ground_filter()
        A = np.block([[A, p.B[:, 3:] @ g.C], [np.zeros((g.n, p.n)), g.A]])
        W = np.block([[np.zeros((p.n, p.n + g.n))], [np.zeros((g.n, p.n)), g.B @ g.B.T]])
        B, C = np.vstack([B, np.zeros((g.n, 3))]), np.hstack([C, np.zeros((4, g.n))])
    if np.isfinite(hardware.bandwidth):
        omega, eye, none = 2 * np.pi * hardware.bandwidth, np.eye(3), np.zeros((3, 3))
        own = -omega * eye if hardware.order == 1 else omega * np.block([[none, eye], [-eye, -np.sqrt(2) * eye]])
        n, d = len(A), len(own)
        A = np.block([[A, B, np.zeros((n, d - 3))], [np.zeros((d, n)), own]])
        B, C = np.vstack([np.zeros((n + d - 3, 3)), omega * eye]), np.hstack([C, np.zeros((4, d))])
        W = np.pad(W, (0, d))
    return A, B, C, W


def _jumps(A: np.ndarray, W: np.ndarray) -> np.ndarray:
    """∫ e^{At} W e^{Aᵀt} dt over a sample, from a hundred-and-twenty-eighth of one by doubling."""
    h, parts = H / 128, 7
    Phi = expm(A * h)
    Q = h / 6 * (W + 4 * expm(A * h / 2) @ W @ expm(A.T * h / 2) + Phi @ W @ Phi.T)
    for _ in range(parts):
        Q, Phi = Q + Phi @ Q @ Phi.T, Phi @ Phi
    return Q


@lru_cache(maxsize=64)
def _loop(world: World, id: str, dial: float, v: float, pair: str) -> tuple[np.ndarray, ...]:
    """w⁺ = M w + jumps + N v for w = (mechanics, controller, commands on their way); rows of channels and commands, what v adds."""
    A, B, C, W = _mechanics(world)
    steps = world.hardware.delay / H
    whole = int(steps + 1e-9)
    part = steps - whole if steps - whole > 1e-9 else 0.0
    (late_step, late), (step, soon) = _held(A, B, part * H), _held(A, B, (1 - part) * H)
    late, waiting = step @ late, whole + (part > 0)
    silent = (np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((3, 0)), np.zeros((3, 4)))
    k = None if id == OPEN_LOOP else retuned(id, dial, v, pair)
    Ac, Bc, Cc, Dc = silent if k is None else (k.A[-1], k.B[-1], k.C[-1], k.D[-1])
    a, c = len(A), len(Ac)
    size = a + c + 3 * waiting
    u = np.hstack([Dc @ C, Cc, np.zeros((3, 3 * waiting))])

    def command(ago: int) -> np.ndarray:
        return u if ago == 0 else np.eye(size)[a + c + 3 * (ago - 1):a + c + 3 * ago]
    M, N = np.zeros((size, size)), np.zeros((size, 4))
    M[:a, :a] = step @ late_step
    M[:a] += soon @ command(whole) + (late @ command(whole + 1) if part else 0)
    M[a:a + c, :a], M[a:a + c, a:a + c], N[a:a + c] = Bc @ C, Ac, Bc
    if whole == 0:
        N[:a] = soon @ Dc
    for ago in range(1, waiting + 1):
        M[a + c + 3 * (ago - 1):a + c + 3 * ago] = command(ago - 1)
    if waiting:
        N[a + c:a + c + 3] = Dc
    seen = np.hstack([CHANNELS @ model.plant(world.parameters).C, np.zeros((3, size - 10))])
    return M, N, np.pad(_jumps(A, W), (0, size - a)), np.vstack([seen, u]), np.vstack([np.zeros((3, 4)), Dc])


def _grid(M: np.ndarray) -> np.ndarray:
    """Frequencies in Hz, close together at each resonance of this very loop."""
    poles = np.linalg.eigvals(M)
    s = np.log(poles[np.abs(poles) > 1e-6].astype(complex)) / (2 * np.pi * H)
    s = s[s.imag > 0]
    beside = np.concatenate([-NEAR[::-1], [0.0], NEAR])
    f = np.concatenate([np.geomspace(FROM, TO, 400), BAND, *(p.imag + abs(p.real) * beside for p in s)])
    return np.unique(f[(f >= FROM) & (f <= TO)])


@lru_cache(maxsize=256)
def moved(world: World, id: str, dial: float, v: float, pair: str) -> Moved | None:
    """How much a controller moves and asks for, None where its loop is not stable."""
    M, N, Q, rows, direct = _loop(world, id, dial, v, pair)
    if np.abs(np.linalg.eigvals(M)).max() > 1 - EDGE:
        return None
    f, eye = _grid(M), np.eye(len(M))
    spread, S = world.sensor / H + world.hardware.step**2 / 12, np.empty((len(f), 6))
    for i, z in enumerate(np.exp(2j * np.pi * f * H)):
        X = np.linalg.solve((z * eye - M).T, rows.T).T
        noise = spread + world.hardware.walk**2 * H / abs(z - 1) ** 2
        S[i] = 2 * H * (np.einsum("ij,jk,ik->i", X, Q, X.conj()).real + noise * np.sum(np.abs(X @ N + direct) ** 2, axis=1))
    inside = (f >= BAND[0]) & (f <= BAND[1])
    rms, band = (np.sqrt(np.trapezoid(S[part], f[part], axis=0)) for part in (slice(None), inside))
    return Moved(float(rms[3:].max()), 1e6 * rms[:3], 1e6 * band[:3])


# --- the sentences -------------------------------------------------------------------------------------------------------
def _found(shown: Shown) -> Equal:
    found = shown.outcome.study.trials.equal
    assert found is not None
    return found


def _of(shown: Shown, id: str, dial: float) -> Moved | None:
    return moved(shown.outcome.study.world, id, dial, shown["v"], shown["pair"])


def _retuned(shown: Shown) -> dict[str, Moved]:
    """Those that met the effort."""
    met = {id: _of(shown, id, float(dial)) for id, dial in zip(ORDER[1:], _found(shown).dials, strict=True) if np.isfinite(dial)}
    assert all(met.values()), f"unstable: {[id for id, one in met.items() if one is None]}"
    return {id: one for id, one in met.items() if one is not None}


def _same_effort(all_of_them: bool) -> Witness:
    def witness(shown: Shown, words: Text) -> None:
        met = _retuned(shown)
        assert (len(met) == 4) == all_of_them, f"{len(met)} get there"
        for one in met.values():
            near(value(words, "force"), 1e3 * one.force, SAME)
    return witness


def _lead(shown: Shown) -> np.ndarray:
    met = _retuned(shown)
    return 20 * np.log10(met[SISO].rms / met[LQE].rms)


def _told(said: float, true: float) -> None:
    assert abs(said - true) < DB, f"says {said:.1f} dB, is {true:.2f}"


def _ahead(sign: int) -> Witness:
    def witness(shown: Shown, words: Text) -> None:
        lead = sign * _lead(shown)
        assert lead.min() > 0, f"ahead by {lead.round(2)} dB"
        _told(value(words, "least"), float(lead.min()))
        _told(value(words, "most"), float(lead.max()))
    return witness


def _nobody(shown: Shown, words: Text) -> None:
    lead = _lead(shown)
    assert lead.min() < DB and lead.max() > -DB, f"ahead by {lead.round(2)} dB"
    for name, true in zip(("first", "second", "third"), lead.tolist(), strict=True):
        _told(value(words, name), true)


def _or_tied(sign: int) -> Witness:
    def witness(shown: Shown, words: Text) -> None:
        lead = _lead(shown)
        assert (sign * lead).min() > -DB, f"ahead by {lead.round(2)} dB"
        for name, true in zip(("first", "second", "third"), lead.tolist(), strict=True):
            _told(value(words, name), true)
    return witness


def _with_no_gain(shown: Shown, _: Text) -> None:
    """From a four-millionth of the gain to four million times: where the loop is stable, it never passes the effort wanted."""
    wanted, before = _found(shown).wanted, None
    for dial in np.geomspace(4.0**-11, 4.0**11, 89).tolist():
        now = _of(shown, SISO, dial)
        assert now is None or before is None or (now.force - wanted) * (before.force - wanted) > 0, f"it does at {dial:.3g} times the gain"
        before = now


def _clipped(shown: Shown, words: Text) -> None:
    limit, force = shown.outcome.study.world.hardware.limit, _retuned(shown)[LQE].force
    near(value(words, "limit"), 1e3 * limit)
    assert 2 * norm.sf(limit / force) > 2e-3, "seldom"


def _best(shown: Shown, words: Text) -> None:
    """In both tables: as they are, and at equal effort."""
    figure = shown.figure
    assert figure is not None
    met = _retuned(shown) if figure.id == "effort_db" else \
        {id: one for id in ORDER[1:] if (one := _of(shown, id, 1.0)) is not None}
    open_loop = _of(shown, OPEN_LOOP, 1.0)
    assert open_loop is not None, "the deck alone is stable"
    by_short = {str(short): id for short, id in zip(SHORT_NAMES, ORDER, strict=True)}
    for j, name in enumerate(("short", "short2", "short3")):
        least = min(one.band[j] for one in met.values())
        for said in str(dict(words.values)[name]).split(", "):
            id = by_short[said]
            if id == ORDER[0]:
                assert 20 * np.log10(open_loop.band[j] / least) < DB, f"{id} is not the best"
                continue
            assert id in met, f"{id} is unstable"
            behind = 20 * np.log10(met[id].band[j] / min(least, open_loop.band[j]))
            assert behind < DB, f"{id} is {behind:.2f} dB behind the best"


WITNESSES: Mapping[str, Witness] = {
    "{split} The coil with the largest command gets {force:.3g} mN RMS from each.": _same_effort(True),
    "{split} The coil with the largest command gets {force:.3g} mN RMS from each that reaches this effort.": _same_effort(False),
    "At this effort the full LQG moves less than the SISO loops in every channel, by {least:.1f} to {most:.1f} dB.": _ahead(1),
    "At this effort the SISO loops move less than the full LQG in every channel, by {least:.1f} to {most:.1f} dB.": _ahead(-1),
    "At this effort no controller leads in every channel. By RMS velocity the full LQG is {first:+.1f}, {second:+.1f} and {third:+.1f} "
    "dB ahead of the SISO loops.": _nobody,
    "The full LQG leads the SISO loops at this effort, or ties with them, in every channel. By RMS velocity it is {first:+.1f}, "
    "{second:+.1f} and {third:+.1f} dB ahead.": _or_tied(1),
    "The SISO loops lead the full LQG at this effort, or tie with it, in every channel. By RMS velocity it is {first:+.1f}, "
    "{second:+.1f} and {third:+.1f} dB ahead of them.": _or_tied(-1),
    "The SISO loops cannot be made to spend that, with any gain.": _with_no_gain,
    "A coil that may give {limit:.3g} mN would be clipped often; that is left out.": _clipped,
    "Best by area: {short} vertically, {short2} in rotation, {short3} horizontally.": _best,
}
