"""Colours of things in rendered images, in every engine: red, green, blue, opacity, from 0 to 1."""

from __future__ import annotations

from zlib import crc32

Colour = tuple[float, float, float, float]

SKY: Colour = (0.72, 0.80, 0.88, 1.0)
FLOOR_TILES: tuple[Colour, Colour] = ((0.86, 0.85, 0.82, 1.0), (0.79, 0.78, 0.75, 1.0))
TILE = 1.0  # [m] edge of a floor tile
WALL: Colour = (0.42, 0.47, 0.56, 1.0)
LIGHT_DIRECTION = (0.35, 0.5, -1.0)  # of the sun's rays

# Colours of bodies without one, chosen by name.
BODIES: tuple[Colour, ...] = (
    (0.89, 0.47, 0.16, 1.0),
    (0.16, 0.50, 0.73, 1.0),
    (0.24, 0.62, 0.35, 1.0),
    (0.78, 0.22, 0.24, 1.0),
    (0.55, 0.36, 0.67, 1.0),
    (0.90, 0.71, 0.16, 1.0),
)


def colour_of(name: str, own: Colour | None) -> Colour:
    """Return the colour of a body: its own, or one derived from its name, the same in each run."""
    return own if own is not None else BODIES[crc32(name.encode()) % len(BODIES)]
