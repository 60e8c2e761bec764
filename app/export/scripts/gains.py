"""Write the lines of a script that compute its gains from poles and eigenvector directions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .literals import array_text, complex_text

__all__ = ["directions_of", "gain_lines", "placed_gain"]


def gain_lines(name: str, gain: np.ndarray, A: np.ndarray, B: np.ndarray, matrix: str) -> Iterator[str]:
    """A gain from its poles, with several inputs from the directions chosen for them too, else as a number."""
    dual = name == "L"
    plain = gain.T if dual else gain
    if not np.any(gain):
        yield f"{name} = np.zeros({gain.shape})  # nothing is fed back by {name} here"
        return
    poles = np.linalg.eigvals(A - B @ plain)
    placed = placed_gain(A, B, poles) if B.shape[1] == 1 else None
    if placed is not None and np.allclose(placed, plain, rtol=1e-8, atol=1e-9 * np.abs(plain).max()):
        yield f"# One {'output' if dual else 'input'}: the poles of {matrix} make {name} unique (Ackermann)."
        yield f"{name.lower()}_poles = {complex_text(poles)}"
        yield f"{name} = np.asarray(control.acker({'Am.T, Cm.T' if dual else 'Am, Bm'}, {name.lower()}_poles)).reshape({plain.shape})" + (
            ".T" if dual else "")
        yield array_text(f"{name}_on_the_page", gain)
        yield f"assert agree({name}, {name}_on_the_page), '{name}'"
        yield f"{name} = {name}_on_the_page  # these digits from here on: a run that grows would magnify the last of them"
        return
    directions = directions_of(A, B, plain)
    if directions is not None:
        poles, free = directions
        yield f"# Several {'outputs' if dual else 'inputs'}: beside the poles s of {matrix} a direction g is free, here the page's."
        yield "# " + ("(A - s I)' v = C' g, L = ([g ...] [v ...]^-1)'" if dual else "(A - s I) v = B g, K = [g ...] [v ...]^-1")
        yield f"{name.lower()}_poles = {complex_text(poles)}"
        yield "g = np.array([" + f",\n{' ' * 14}".join(complex_text(row) for row in free) + "])"
        pair = ("Am.T", "Cm.T") if dual else ("Am", "Bm")
        yield f"v = [np.linalg.solve({pair[0]} - s * np.eye(len(Am)), {pair[1]} @ one) for s, one in zip({name.lower()}_poles, g)]"
        yield f"{name} = np.real(np.linalg.solve(np.array(v), g)){'' if dual else '.T'}"
        yield array_text(f"{name}_on_the_page", gain)
        yield f"assert agree({name}, {name}_on_the_page), '{name}'"
        yield f"{name} = {name}_on_the_page  # these digits from here on: a run that grows would magnify the last of them"
        return
    yield f"# {name} stands as the page found it: its poles (asserted below) and directions do not say it exactly enough."
    yield array_text(name, gain)


def placed_gain(A: np.ndarray, B: np.ndarray, poles: np.ndarray) -> np.ndarray | None:
    """Ackermann's gain, computed as python-control does; None where it fails."""
    n = len(A)
    reach = np.hstack([np.linalg.matrix_power(A, k) @ B for k in range(n)])
    try:
        value = sum(c * np.linalg.matrix_power(A, n - k) for k, c in enumerate(np.real(np.poly(poles))))
        return np.linalg.solve(reach, value)[-1:, :]
    except np.linalg.LinAlgError:
        return None


def directions_of(A: np.ndarray, B: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Poles s (n,) of A - B K and directions g = K v (n, m) from which K can be found again; None where they say it too poorly."""
    poles, V = np.linalg.eig(A - B @ K)
    G = (K @ V).T
    try:
        found = np.array([np.linalg.solve(A - s * np.eye(len(A)), B @ g) for s, g in zip(poles, G, strict=True)])
        again = np.real(np.linalg.solve(found, G)).T
    except np.linalg.LinAlgError:
        return None
    return (poles, G) if np.allclose(again, K, rtol=1e-8, atol=1e-8 * np.abs(K).max()) else None
