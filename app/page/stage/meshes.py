"""Make triangle meshes that viser lacks: springs, crosses, bolts, landscapes."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull

BEVEL, MOST_BEVEL = 0.12, 0.03  # of a part's least side; stage units
Mesh = tuple[np.ndarray, np.ndarray]  # vertices (k, 3) float32, faces (f, 3) uint32


@lru_cache(maxsize=32)
def helix(radius: float, turns: float, wire: float, sides: int = 8, per_turn: int = 20) -> Mesh:
    """A helical spring along z from 0 to 1, a tube of `wire` radius with straight-cut ends."""
    count = int(turns * per_turn) + 1
    s = np.linspace(0.0, 1.0, count)
    angle = 2 * np.pi * turns * s
    taper = np.clip(np.minimum(s, 1 - s) * 2 * turns, 0.0, 1.0)  # the ends wind in to the axis
    r = radius * taper
    centre = np.column_stack([r * np.cos(angle), r * np.sin(angle), s])
    tangent = np.gradient(centre, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    up = np.array([0.0, 0.0, 1.0])
    side = np.cross(up, tangent)
    length = np.linalg.norm(side, axis=1, keepdims=True)
    side = np.where(length > 1e-6, side / np.maximum(length, 1e-6), np.array([1.0, 0.0, 0.0]))
    other = np.cross(tangent, side)
    ring = 2 * np.pi * np.arange(sides) / sides
    vertices = (centre[:, None, :] + wire * (np.cos(ring)[None, :, None] * side[:, None, :]
                                             + np.sin(ring)[None, :, None] * other[:, None, :])).reshape(-1, 3)
    return vertices.astype(np.float32), _strip(count, sides, closed=True)


def _strip(rows: int, columns: int, closed: bool) -> np.ndarray:
    """Faces of a grid of vertices; `closed` joins the last column to the first."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns if closed else columns - 1), indexing="ij")
    k = (j + 1) % columns
    a, b, c, d = i * columns + j, i * columns + k, (i + 1) * columns + k, (i + 1) * columns + j
    return np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3),
                           np.stack([a, c, d], -1).reshape(-1, 3)]).astype(np.uint32)


def _box(size: tuple[float, float, float], angle: float) -> Mesh:
    """A box turned by `angle` in the x–z plane."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float) * np.array(size) / 2
    c, s = np.cos(angle), np.sin(angle)
    corners = corners @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6),
             (0, 6, 4), (1, 5, 7), (1, 7, 3)]
    return corners.astype(np.float32), np.array(faces, dtype=np.uint32)


@lru_cache(maxsize=128)
def bevelled_box(size: tuple[float, float, float]) -> Mesh:
    """A box with its middle at the origin and its edges broken, so that they catch the light.

    Corners are shared by their faces: the browser shades across a bevel as if it were round.
    """
    half = np.array(size) / 2
    bevel = min(BEVEL * 2 * float(half.min()), MOST_BEVEL)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = np.vstack([signs * (half - bevel * (1 - np.eye(3)[axis])) for axis in range(3)])  # those on the faces across each axis
    hull = ConvexHull(corners)
    return corners.astype(np.float32), _outwards(corners, hull.simplices)


@lru_cache(maxsize=128)
def bevelled_cylinder(radius: float, bottom: float, top: float, sides: int = 32) -> Mesh:
    """An upright cylinder around the z axis with its rims broken."""
    bevel = min(BEVEL * min(2 * radius, top - bottom), MOST_BEVEL)
    angle = 2 * np.pi * np.arange(sides) / sides
    rings = [np.column_stack([r * np.cos(angle), r * np.sin(angle), np.full(sides, z)])
             for r, z in ((radius - bevel, bottom), (radius, bottom + bevel), (radius, top - bevel), (radius - bevel, top))]
    vertices, j = np.vstack([*rings, [[0, 0, bottom], [0, 0, top]]]), np.arange(sides)
    k, last = (j + 1) % sides, 3 * sides
    caps = [np.stack([k, j, np.full(sides, 4 * sides)], -1), np.stack([last + j, last + k, np.full(sides, 4 * sides + 1)], -1)]
    return vertices.astype(np.float32), np.concatenate([_strip(4, sides, closed=True), *caps]).astype(np.uint32)


@lru_cache(maxsize=128)
def box_edges(size: tuple[float, float, float]) -> np.ndarray:
    """The edges of a box around the origin (12, 2, 3)."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    pairs = [(i, j) for i in range(8) for j in range(i + 1, 8) if np.abs(signs[i] - signs[j]).sum() == 2]
    return (signs[np.array(pairs)] * (np.array(size) / 2)).astype(np.float32)


@lru_cache(maxsize=128)
def rims(radius: float, height: float, sides: int = 32) -> np.ndarray:
    """The two rims of an upright cylinder around the origin (2 sides, 2, 3)."""
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    rings = [np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(sides + 1, z)]) for z in (-height / 2, height / 2)]
    return np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings]).astype(np.float32)


def _outwards(corners: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The faces of a body around the origin, each turned so that it is seen from outside."""
    a, b, c = (corners[faces[:, k]] for k in range(3))
    inside = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0
    return np.where(inside[:, None], faces[:, ::-1], faces).astype(np.uint32)


@lru_cache(maxsize=8)
def cross(size: float = 0.2, thickness: float = 0.05, depth: float = 0.07) -> Mesh:
    """A pole: two bars crossed in the x–z plane."""
    (v1, f1), (v2, f2) = (_box((size * 1.41, depth, thickness), a) for a in (np.pi / 4, -np.pi / 4))
    return np.vstack([v1, v2]), np.vstack([f1, f2 + len(v1)]).astype(np.uint32)


@lru_cache(maxsize=8)
def disc(sides: int = 32) -> Mesh:
    """A disc of radius 1 in the x–z plane, seen from −y."""
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = np.column_stack([np.cos(angle), np.zeros(sides), np.sin(angle)])
    faces = [(i, (i + 1) % sides, sides) for i in range(sides)]
    return np.vstack([rim, np.zeros((1, 3))]).astype(np.float32), np.array(faces, dtype=np.uint32)


@lru_cache(maxsize=8)
def bolt(radius: float = 0.11, depth: float = 0.1) -> Mesh:
    """A hexagonal bolt head lying in the x–z plane."""
    ring = np.pi / 3 * np.arange(6)
    front = np.column_stack([radius * np.cos(ring), np.full(6, -depth), radius * np.sin(ring)])
    back = front + np.array([0.0, 2 * depth, 0.0])
    vertices = np.vstack([front, back, [[0, -depth, 0]], [[0, depth, 0]]])
    faces = []
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, 12), (j + 6, i + 6, 13), (i, i + 6, j + 6), (i, j + 6, j)]
    return vertices.astype(np.float32), np.array(faces, dtype=np.uint32)


def landscape(matrix: np.ndarray, re: np.ndarray, im: np.ndarray, width: float, depth: float,
              height: float) -> Mesh:
    """The surface of |det(sI − M)|⁻¹ over a window of the s-plane, on a logarithmic height from 0 to `height`.

    x is Re s over `width`, y is Im s over `depth`; peaks stand at the eigenvalues of M.
    """
    s = re[None, :] + 1j * im[:, None]
    poles = np.linalg.eigvals(matrix)
    level = -np.sum(np.log10(np.maximum(np.abs(s[..., None] - poles), 1e-3)), axis=-1)
    low, high = float(level.min()), float(level.max())
    z = height * ((level - low) / max(high - low, 1e-9)) ** 2
    x = (re - re[0]) / (re[-1] - re[0]) * width - width / 2
    y = (im - im[0]) / (im[-1] - im[0]) * depth - depth / 2
    grid = np.stack([np.broadcast_to(x[None, :], z.shape), np.broadcast_to(y[:, None], z.shape), z], axis=-1)
    return grid.reshape(-1, 3).astype(np.float32), _strip(len(im), len(re), closed=False)
