"""Line drawings in SVG: points of the world projected onto paper, curves, arrows, axes.

Paper is in millimetres of the world, x to the right and y down; looks are left to the page's style
sheet, so every shape carries only the names of its classes.
"""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull

Array = NDArray[np.float64]
View = Literal["side", "front"]


@dataclass(frozen=True)
class Paper:
    """Projects the world onto paper and writes what is drawn as SVG elements.

    `side` looks from the person's right, x to the right; `front` looks at the face, y to the right.
    """

    view: View

    def project(self, points: ArrayLike) -> Array:
        """Points of the world (k, 3), m, on paper (k, 2), mm."""
        points = np.atleast_2d(np.asarray(points, float))
        return 1000.0 * np.column_stack([points[:, 0 if self.view == "side" else 1], -points[:, 2]])

    def curve(self, points: ArrayLike, style: str, closed: bool = False) -> str:
        """A smooth curve through points of the world (k, 3): Catmull-Rom as cubic Bézier."""
        on = self.project(points)
        p = np.vstack([on[-1:], on, on[:2]] if closed else [on[:1], on, on[-1:]])
        steps = [
            f"C{_pairs(np.array([b + (c - a) / 6, c - (d - b) / 6, c]))}"
            for a, b, c, d in zip(p, p[1:], p[2:], p[3:], strict=False)
        ]
        path = f"M{_pairs(on[:1])}{''.join(steps)}{'Z' if closed else ''}"
        return f'<path d="{path}" class="{style}"/>'

    def polygon(self, points: ArrayLike, style: str) -> str:
        """A closed shape with the given corners (k, 3)."""
        return _polygon(self.project(points), style)

    def hull(self, points: ArrayLike, style: str) -> str:
        """What a convex solid with the given corners (k, 3) looks like."""
        return _hull(self.project(points), style)

    def limb(self, start: ArrayLike, end: ArrayLike, radii: tuple[float, float], style: str) -> str:
        """The shape around two balls at points of the world, with radii in m."""
        turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        circle = 1000.0 * np.column_stack([np.cos(turn), np.sin(turn)])
        ends = zip((start, end), radii, strict=True)
        return _hull(np.vstack([self.project(p) + r * circle for p, r in ends]), style)

    def dots(self, points: ArrayLike, radius: float, style: str) -> str:
        """A disc of a radius in m at each point (k, 3)."""
        return "".join(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{1000.0 * radius:.1f}" class="{style}"/>'
            for x, y in self.project(points)
        )


def arrow(tail: Array, tip: Array, style: str) -> str:
    """An arrow between two points on paper (2,), mm."""
    along = (tip - tail) / np.linalg.norm(tip - tail)
    across = 13.0 * np.array([-along[1], along[0]])
    neck = tip - 36.0 * along
    shaft = f'<polyline points="{_pairs(np.array([tail, neck]))}" class="shaft {style}"/>'
    return shaft + _polygon(np.array([tip, neck + across, neck - across]), f"tip {style}")


def arc(centre: Array, clockwise: bool, style: str) -> str:
    """Three quarters of a circle about a point on paper, turning as a moment does, with a tip."""
    turn = np.linspace(-0.75 * np.pi, 0.65 * np.pi, 30)
    circle = 62.0 * np.column_stack([np.cos(turn), np.sin(turn)])
    points = centre + circle * (1.0 if clockwise else -1.0, 1.0)
    line = f'<polyline points="{_pairs(points[:-3])}" class="shaft {style}"/>'
    return line + arrow(points[-5], points[-1], style)


def text(at: Array, words: str, style: str, anchor: str = "start") -> str:
    """Words beside a point on paper: to its right (`start`), left (`end`), or centred."""
    gap = {"start": 14.0, "end": -14.0}.get(anchor, 0.0)
    place = f'x="{at[0] + gap:.0f}" y="{at[1]:.0f}" text-anchor="{anchor}"'
    return f'<text {place} class="{style}">{escape(words)}</text>'


def sheet(drawing: str, low: Array, high: Array, title: str, axes: str) -> str:
    """The finished SVG element: a window from `low` to `high` on paper (mm), with a grid in m.

    Its `flex` is its aspect, so that drawings side by side come out equally high.
    """
    (left, top), (right, bottom) = low, high
    window = f"{left:.0f} {top:.0f} {right - left:.0f} {bottom - top:.0f}"
    size = f'x="{left:.0f}" y="{top:.0f}" width="{right - left:.0f}" height="{bottom - top:.0f}"'
    grid = [text(np.array([left - 70, top - 36]), title, "title")]
    for x in range(200 * int(np.ceil(left / 200)), int(right), 200):
        grid.append(f'<path class="grid" d="M{x} {top:.0f}V{bottom:.0f}"/>')
        grid.append(text(np.array([x, bottom + 42]), f"{x / 1000:.1f}", "tick", "middle"))
    for y in range(200 * int(np.ceil(top / 200)), int(bottom), 200):
        grid.append(f'<path class="grid" d="M{left:.0f} {y}H{right:.0f}"/>')
        grid.append(text(np.array([left, y + 9]), f"{0.0 - y / 1000:.1f}", "tick", "end"))
    grid.append(text(np.array([(left + right) / 2, bottom + 88]), axes, "tick", "middle"))
    wide, high_ = right - left + 100, bottom - top + 180
    return (
        f'<svg class="person" role="img" aria-label="{escape(title)}" '
        f'style="flex: {wide / high_:.3f} 1 0" '
        f'viewBox="{left - 80:.0f} {top - 80:.0f} {wide:.0f} {high_:.0f}">'
        f'{"".join(grid)}<svg {size} viewBox="{window}">{drawing}</svg></svg>'
    )


def _polygon(points: Array, style: str) -> str:
    return f'<polygon points="{_pairs(points)}" class="{style}"/>'


def _hull(points: Array, style: str) -> str:
    return _polygon(points[ConvexHull(points).vertices], style)


def _pairs(points: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
