"""Colours of the materials that Gazebo defines by name, for <script> elements of SDF."""

from __future__ import annotations

from types import MappingProxyType

from sim_nodes.views import Colour

_COLOURS: dict[str, tuple[float, float, float]] = {
    "Black": (0.0, 0.0, 0.0),
    "FlatBlack": (0.1, 0.1, 0.1),
    "DarkGrey": (0.175, 0.175, 0.175),
    "DarkGray": (0.175, 0.175, 0.175),
    "Grey": (0.7, 0.7, 0.7),
    "Gray": (0.7, 0.7, 0.7),
    "White": (1.0, 1.0, 1.0),
    "Red": (1.0, 0.0, 0.0),
    "Green": (0.0, 1.0, 0.0),
    "Blue": (0.0, 0.0, 1.0),
    "SkyBlue": (0.13, 0.44, 0.7),
    "Turquoise": (0.0, 1.0, 1.0),
    "Yellow": (1.0, 1.0, 0.0),
    "DarkYellow": (0.7, 0.7, 0.0),
    "ZincYellow": (0.97, 0.95, 0.21),
    "Gold": (0.8, 0.65, 0.12),
    "Orange": (1.0, 0.51, 0.05),
    "Purple": (1.0, 0.0, 1.0),
    "Indigo": (0.33, 0.0, 0.5),
    "Wood": (0.6, 0.45, 0.27),
}
COLOURS: MappingProxyType[str, Colour] = MappingProxyType(
    {f"Gazebo/{name}": (*colour, 1.0) for name, colour in _COLOURS.items()}
)
"""Colours by name; `Gazebo/Wood` is the mean of its picture, about."""
