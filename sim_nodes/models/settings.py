"""Settings of the readers of models."""

from __future__ import annotations

from seoro.deferred import dataclass
from sim_nodes.views import Colour


@dataclass(frozen=True)
class ModelSettings:
    """Settings of a model.

    Attributes:
        static: Whether its bodies are static regardless of the file.
        colour: Colour of all bodies; None for the colours of the file.
        decompose: Whether solid meshes are split into convex pieces; else they are their convex hulls.
    """

    static: bool = False
    colour: Colour | None = None
    decompose: bool = False


FROM_FILE = ModelSettings()
