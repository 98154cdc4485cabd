"""Solids from distance functions: a small vocabulary, and the mesh of what it says.

A solid is a function from points (..., 3), in metres, to the signed distance to its surface
(negative inside). Solids joined by `blend` flow into each other, which is what makes bone and
flesh look grown rather than built; `mesh` finds the surface by naive surface nets (Gibson 1998).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from posture_ik.arrays import Array

Solid = Callable[[Array], Array]


class Mesh(NamedTuple):
    """A closed surface of triangles seen counter-clockwise from outside.

    Attributes:
        vertices: (n, 3), m.
        faces: (m, 3), indices of vertices.
    """

    vertices: Array
    faces: npt.NDArray[np.int64]


def ellipsoid(centre: ArrayLike, radii: ArrayLike) -> Solid:
    """An ellipsoid with half axes along x, y, z; the distance is exact to first order."""
    c, r = np.asarray(centre), np.asarray(radii)

    def distance(p: Array) -> Array:
        level = np.linalg.norm((p - c) / r, axis=-1)
        slope = np.linalg.norm((p - c) / r**2, axis=-1)
        return np.asarray(level * (level - 1.0) / np.maximum(slope, 1e-9))

    return distance


def rod(start: ArrayLike, end: ArrayLike, radius: float, end_radius: float | None = None) -> Solid:
    """A round-ended rod whose radius runs straight from one end's to the other's."""
    a, b = np.asarray(start, float), np.asarray(end, float)
    grow = (radius if end_radius is None else end_radius) - radius

    def distance(p: Array) -> Array:
        t = np.clip((p - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-12), 0.0, 1.0)
        return np.asarray(
            np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1) - radius - t * grow
        )

    return distance


def limb(*nodes: tuple[float, float, float, float]) -> Solid:
    """A smooth limb through nodes (x, y, z, radius): a monotone spline of balls and rods."""
    knots = np.asarray(nodes, float)
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots[:, :3], axis=0), axis=1))])
    fine = PchipInterpolator(at, knots)(np.linspace(0.0, at[-1], 4 * len(knots)))
    rods = [rod(a[:3], b[:3], a[3], b[3]) for a, b in pairwise(fine)]
    return lambda p: np.min([distance(p) for distance in rods], axis=0)


def drum(radii: tuple[float, float], height: float, waist: float, edge: float) -> Solid:
    """An elliptic drum about z with a waist: a vertebral body.

    Args:
        radii: half depth (x) and half width (y) at the rims, m.
        height: whole height along z, m.
        waist: share of the radius lost half-way.
        edge: radius of the rounded rim, m.
    """
    a, b, half = radii[0] - edge, radii[1] - edge, height / 2 - edge

    def distance(p: Array) -> Array:
        x, y, z = np.moveaxis(p, -1, 0)
        rim = 1.0 - waist * np.clip(1.0 - (z / half) ** 2, 0.0, 1.0)
        level = np.hypot(x / a, y / b)
        slope = np.hypot(x / a**2, y / b**2)
        side = level * (level - rim) / np.maximum(slope, 1.0 / max(a, b))
        top = np.abs(z) - half
        outside = np.hypot(np.maximum(side, 0.0), np.maximum(top, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(side, top), 0.0) - edge)

    return distance


def plate(centre: ArrayLike, half: ArrayLike, edge: float, pitch: float = 0.0) -> Solid:
    """A box with rounded edges, half sizes `half`, pitched about y by `pitch` rad."""
    c, h = np.asarray(centre), np.asarray(half) - edge
    cos, sin = np.cos(pitch), np.sin(pitch)
    turn = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])

    def distance(p: Array) -> Array:
        gap = np.abs((p - c) @ turn) - h
        outside = np.linalg.norm(np.maximum(gap, 0.0), axis=-1)
        return np.asarray(outside + np.minimum(gap.max(axis=-1), 0.0) - edge)

    return distance


def blend(width: float, *solids: Solid) -> Solid:
    """The union, each new solid flowing into the others over about `width` m."""

    def distance(p: Array) -> Array:
        d = solids[0](p)
        for solid in solids[1:]:
            other = solid(p)
            share = np.clip(0.5 + (other - d) / (2 * width), 0.0, 1.0)
            d = other + (d - other) * share - width * share * (1.0 - share)
        return d

    return distance


def carve(width: float, solid: Solid, *tools: Solid) -> Solid:
    """What is left of a solid after tools have cut it, edges softened over `width` m."""
    rest = blend(width, lambda p: -solid(p), *tools)
    return lambda p: -rest(p)


def both_sides(solid: Solid) -> Solid:
    """A solid and its mirror image in the plane y = 0."""
    return lambda p: solid(np.stack([p[..., 0], np.abs(p[..., 1]), p[..., 2]], axis=-1))


def mirrored(shape: Mesh, axis: int = 1) -> Mesh:
    """The mirror image of a mesh across the plane normal to `axis`, still seen from outside."""
    sign = np.ones(3)
    sign[axis] = -1.0
    return Mesh(shape.vertices * sign, shape.faces[:, ::-1])


def joined(*shapes: Mesh) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *[len(shape.vertices) for shape in shapes[:-1]]])
    return Mesh(
        np.vstack([shape.vertices for shape in shapes]),
        np.vstack([shape.faces + start for shape, start in zip(shapes, starts, strict=True)]),
    )


def mesh(solid: Solid, lower: ArrayLike, upper: ArrayLike, cell: float) -> Mesh:
    """The surface of a solid inside a box, by naive surface nets.

    Each cell that the surface crosses gets one vertex, each crossed grid edge one quadrilateral
    of the four cells around it; vertices are then pulled onto the surface.

    Args:
        solid: signed distance.
        lower: least corner of a box that holds the solid, m.
        upper: greatest corner, m.
        cell: edge of a grid cell, m; thinner parts may be lost.
    """
    low = np.asarray(lower, float) - cell
    shape = np.ceil((np.asarray(upper) + cell - low) / cell).astype(int) + 1
    grid = np.stack(np.meshgrid(*[np.arange(n) for n in shape], indexing="ij"), axis=-1)
    d = solid(low + cell * grid)
    total, count = np.zeros((*shape, 3)), np.zeros(shape, int)
    quads: list[npt.NDArray[np.int64]] = []
    for axis in range(3):
        here = np.moveaxis(d, axis, 0)[:-1]
        there = np.moveaxis(d, axis, 0)[1:]
        corners = np.moveaxis(grid, axis, 0)[:-1]
        crossed = (here < 0) != (there < 0)
        at = corners[crossed].astype(float)
        first, second = here[crossed], there[crossed]
        at[:, axis] += first / (first - second)
        u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
        around = corners[crossed][:, None] - np.stack([0 * u, u, u + v, v])
        for k in range(4):
            cells = tuple(around[:, k].T)
            np.add.at(total, cells, at)
            np.add.at(count, cells, 1)
        flat = np.ravel_multi_index(tuple(np.moveaxis(around, -1, 0)), tuple(shape))
        quads.append(np.where((first < 0)[:, None], flat, flat[:, ::-1]))
    used = np.flatnonzero(count)
    number = np.zeros(count.size, int)
    number[used] = np.arange(used.size)
    vertices = low + cell * total.reshape(-1, 3)[used] / count.reshape(-1, 1)[used]
    corner = number[np.vstack(quads)]
    faces = np.vstack([corner[:, [0, 1, 2]], corner[:, [0, 2, 3]]])
    return Mesh(_onto(solid, vertices, cell), faces)


def _onto(solid: Solid, vertices: Array, cell: float) -> Array:
    """Pull vertices onto the surface along its gradient, at most half a cell in all."""
    step = 1e-3 * cell * np.eye(3)
    moved = vertices
    for _ in range(3):
        gradient = np.stack([solid(moved + s) - solid(moved - s) for s in step], axis=-1)
        gradient /= 2e-3 * cell
        square = np.maximum((gradient**2).sum(axis=-1), 0.25)
        moved = moved - (solid(moved) / square)[:, None] * gradient
        moved = vertices + np.clip(moved - vertices, -0.5 * cell, 0.5 * cell)
    return moved


def tube(path: ArrayLike, radii: tuple[float, float], sides: int = 8, samples: int = 24) -> Mesh:
    """A closed tube of elliptic section along a smooth curve through the points of `path`.

    Args:
        path: (k, 3) points of a Catmull-Rom spline, m.
        radii: half sizes across the curve: horizontal and vertical, m.
        sides: corners of the section.
        samples: sections along the curve.
    """
    knots = np.asarray(path, float)
    knots = np.vstack([2 * knots[0] - knots[1], knots, 2 * knots[-1] - knots[-2]])
    t = np.linspace(0.0, len(knots) - 3 - 1e-9, samples)
    i = t.astype(int)
    f = (t - i)[:, None]
    p0, p1, p2, p3 = (knots[i + k] for k in range(4))
    curve = 0.5 * (
        2 * p1
        + (p2 - p0) * f
        + (2 * p0 - 5 * p1 + 4 * p2 - p3) * f**2
        + (3 * p1 - p0 - 3 * p2 + p3) * f**3
    )
    along = np.gradient(curve, axis=0)
    across = np.cross([0.0, 0.0, 1.0], along)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    up = np.cross(along, across)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = radii[0] * np.cos(angle)[:, None] * across[:, None] + (
        radii[1] * np.sin(angle)[:, None] * up[:, None]
    )
    return loft(curve[:, None] + ring)


def loft(rings: Array) -> Mesh:
    """A closed surface through rings (k, sides, 3) that turn the same way, ends capped flat."""
    count, sides, _ = rings.shape
    k, j = np.meshgrid(np.arange(count - 1), np.arange(sides), indexing="ij")
    a, b = (k * sides + j).ravel(), (k * sides + (j + 1) % sides).ravel()
    wall = np.vstack([np.stack([a, b, b + sides], 1), np.stack([a, b + sides, a + sides], 1)])
    side = np.arange(sides)
    first, last = count * sides, count * sides + 1
    start = np.stack([np.full(sides, first), (side + 1) % sides, side], axis=1)
    end = (count - 1) * sides + np.stack([side, (side + 1) % sides, side], axis=1)
    end[:, 2] = last
    vertices = np.vstack([rings.reshape(-1, 3), rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    return Mesh(vertices, np.vstack([wall, start, end]))


def write_obj(shape: Mesh, path: Path) -> None:
    """Write a mesh as Wavefront OBJ, in metres to 0.01 mm."""
    lines = ["# posture_ik.body.shapes, metres", "s 1"]
    lines += [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in shape.vertices + 0.0]
    lines += [f"f {a} {b} {c}" for a, b, c in shape.faces + 1]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def read_obj(path: Path) -> Mesh:
    """Read the triangles of a Wavefront OBJ; larger polygons are cut into fans."""
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            vertices.append([float(word) for word in words[:3]])
        elif kind == "f":
            corners = [int(word.split("/")[0]) for word in words]
            corners = [c - 1 if c > 0 else len(vertices) + c for c in corners]
            faces += [[corners[0], b, c] for b, c in pairwise(corners[1:])]
    return Mesh(np.array(vertices, float), np.array(faces, int))


def signed_volume(shape: Mesh) -> float:
    """Volume inside a closed mesh, m³; positive when its triangles face outwards."""
    a, b, c = (shape.vertices[shape.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
