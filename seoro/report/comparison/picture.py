"""Paths of two runs in one picture from above, as SVG."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from seoro.report.comparison.runs import ComparedRun, Point, position
from seoro.report.fallback import safe

WIDTH: Final = 720.0  # [units of the picture]
_HEIGHTS: Final = (180.0, 540.0)
_MARGIN: Final = 28.0
_COLOURS: Final = 7  # of entities
_MOST_SHAPES: Final = 2_000
_STILL: Final = 0.05  # [m]: bodies with shorter paths in both runs are left out
_CIRCLES: Final = frozenset({"sphere", "cylinder", "capsule"})


class _Frame:
    """Maps positions [m] to the picture."""

    def __init__(self, points: Sequence[tuple[float, float]]) -> None:
        (left, right), (bottom, top) = ((min(values), max(values)) for values in zip(*points, strict=True))
        width, height = max(right - left, 1.0), max(top - bottom, 0.5)
        self.scale = min((WIDTH - 2 * _MARGIN) / width, (_HEIGHTS[1] - 2 * _MARGIN) / height)
        self.height = max(height * self.scale + 2 * _MARGIN, _HEIGHTS[0])
        self._x = WIDTH / 2 - (left + right) / 2 * self.scale
        self._y = self.height / 2 + (bottom + top) / 2 * self.scale

    def at(self, x: float, y: float) -> str:
        return f"{self._x + x * self.scale:.1f},{self._y - y * self.scale:.1f}"


def picture(first: ComparedRun, second: ComparedRun, times: tuple[float, float] | None) -> Iterator[str]:
    """Yield the picture with its legend; nothing if nothing moved.

    Args:
        first: Run A, with solid lines.
        second: Run B, with dashed lines.
        times: Times of the first difference in each run [s]; None for equal runs.
    """
    names = _moved(first, second)
    if not names:
        return
    runs = (first, second)
    frame = _Frame([point[1:] for run in runs for name in names for point in run.paths.get(name, ())])
    title = f"Paths of {', '.join(names)} in both runs, from above"
    yield f'<svg viewBox="0 0 {WIDTH:.0f} {frame.height:.0f}" role="img" aria-label="{safe(title)}">'
    yield from _shapes(first.scene, frame)
    yield from _scale_bar(frame)
    for number, name in enumerate(names):
        for letter, run in zip("AB", runs, strict=True):
            if path := run.paths.get(name):
                yield from _path(path, frame, number, letter)
    if times is not None:
        for number, name in enumerate(names):
            for letter, run, time in zip("AB", runs, times, strict=True):
                if path := run.paths.get(name):
                    yield _place(path, frame, number, letter, time)
    yield "</svg>"
    yield from _legend(names, has_places=times is not None)


def _moved(first: ComparedRun, second: ComparedRun) -> list[str]:
    names = dict.fromkeys((*first.paths, *second.paths))
    return [name for name in names if any(_length(run.paths.get(name, [])) > _STILL for run in (first, second))]


def _length(path: Sequence[Point]) -> float:
    return max((math.hypot(x - path[0][1], y - path[0][2]) for _, x, y in path), default=0.0)


def _path(path: Sequence[Point], frame: _Frame, number: int, letter: str) -> Iterator[str]:
    points = " ".join(frame.at(x, y) for _, x, y in path)
    style = f"way e{number % _COLOURS} {letter.lower()}"
    yield f'<polyline class="{style}" points="{points}"/>'
    (x0, y0), (x1, y1) = (frame.at(*point[1:]).split(",") for point in (path[0], path[-1]))
    yield f'<circle class="{style} start" cx="{x0}" cy="{y0}" r="4"/>'
    yield f'<rect class="{style} stop" x="{float(x1) - 4:.1f}" y="{float(y1) - 4:.1f}" width="8" height="8"/>'


def _place(path: list[Point], frame: _Frame, number: int, letter: str, time: float) -> str:
    x, y = frame.at(*position(path, time)).split(",")
    dx = -11 if letter == "A" else 11
    return (
        f'<circle class="place e{number % _COLOURS} {letter.lower()}" cx="{x}" cy="{y}" r="7"/>'
        f'<text class="place" x="{float(x) + dx:.1f}" y="{float(y) - 7:.1f}" text-anchor="middle">{letter}</text>'
    )


def _shapes(scene: Mapping[str, Any], frame: _Frame) -> Iterator[str]:
    """Yield walls and static objects; malformed ones are skipped."""
    shapes = scene.get("shapes")
    for shape in shapes[:_MOST_SHAPES] if isinstance(shapes, list) else ():
        try:
            outline = _outline(shape)
        except (KeyError, TypeError, ValueError, IndexError, OverflowError, ZeroDivisionError):
            continue
        if outline:
            yield f'<polygon class="wall" points="{" ".join(frame.at(x, y) for x, y in outline)}"/>'


def _outline(shape: Mapping[str, Any]) -> list[tuple[float, float]]:
    """Return the corners of a shape from above [m]; none for parts of the floor."""
    x, y, z, qx, qy, qz, qw = map(float, shape["pose"])
    size = shape["size"]
    yaw = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
    if shape["kind"] == "box":
        if z + size[2] / 2 <= 0.02:
            return []
        corners = [(size[0] / 2 * a, size[1] / 2 * b) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    elif shape["kind"] in _CIRCLES:
        turns = [math.pi * step / 12 for step in range(24)]
        corners = [(size[0] * math.cos(turn), size[0] * math.sin(turn)) for turn in turns]
    else:
        corners = [(float(a), float(b)) for a, b in shape["points"]]
    cos, sin = math.cos(yaw), math.sin(yaw)
    found = [(x + a * cos - b * sin, y + a * sin + b * cos) for a, b in corners]
    return found if all(math.isfinite(value) for corner in found for value in corner) else []


def _scale_bar(frame: _Frame) -> Iterator[str]:
    length = 10 ** math.floor(math.log10(120 / frame.scale))
    length *= next(factor for factor in (5, 2, 1) if length * factor * frame.scale <= 120)
    y = frame.height - 10
    yield f'<path class="bar" d="M12,{y - 4:.1f}V{y:.1f}H{12 + length * frame.scale:.1f}v-4"/>'
    yield f'<text class="dim" x="14" y="{y - 7:.1f}">{length:g} m</text>'


def _legend(names: Sequence[str], *, has_places: bool) -> Iterator[str]:
    line = '<svg class="key" viewBox="0 0 32 10" aria-hidden="true"><path class="way {style}" d="M1,5H31"/></svg>'
    yield '<p class="legend">'
    yield f"<span>{line.format(style='a')} A</span><span>{line.format(style='b')} B</span>"
    yield "<span>\N{BLACK CIRCLE} start</span><span>\N{BLACK SQUARE} end</span>"
    if has_places:
        yield "<span>\N{WHITE CIRCLE} where they first differ</span>"
    if len(names) > 1:
        for number, name in enumerate(names):
            yield f"<span>{line.format(style=f'e{number % _COLOURS} a')} {safe(name)}</span>"
    yield "</p>"
