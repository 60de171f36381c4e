"""Names of worlds: a name that simulators know or a file, with parameters, as in `office.yaml?generate.seed=3`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

from seoro.deferred import dataclass

SEPARATOR: Final = "?"
WORLD_FILES: Final = frozenset({".yaml", ".yml"})
PLAN_FILES: Final = frozenset({".png", ".pgm", ".jpg", ".jpeg"})  # pictures of floors
SCENE_FILES: Final = frozenset({".sdf", ".world", ".xml", ".mjcf"})
SUFFIXES: Final = WORLD_FILES | PLAN_FILES | SCENE_FILES


@dataclass(frozen=True)
class WorldName:
    """A world without its parameters, and the text of these, such as `generate.seed=3&wall_height=1`."""

    world: str
    parameters: str = ""

    @classmethod
    def parse(cls, text: str) -> WorldName:
        """Split the name of a world at the first `?`."""
        world, _, parameters = text.partition(SEPARATOR)
        return cls(world, parameters)

    @property
    def is_file(self) -> bool:
        """Whether the world is a file of seoro's simulators, not a name that they know."""
        return Path(self.world).suffix.lower() in SUFFIXES

    def located(self, locate: Callable[[Path], Path]) -> str:
        """Return the full name with the path of a file at which `locate` finds it."""
        return str(self.replaced(str(locate(Path(self.world))))) if self.is_file else str(self)

    def replaced(self, world: str) -> WorldName:
        """Return another world with the same parameters."""
        return WorldName(world, self.parameters)

    def __str__(self) -> str:
        return f"{self.world}{SEPARATOR}{self.parameters}" if self.parameters else self.world
