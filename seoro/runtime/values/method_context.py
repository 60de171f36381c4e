"""The run as seen by external methods.

Methods take no time, and most need only their arguments. A Python function whose first parameter is annotated with
`MethodContext` receives the run first: for random numbers from the run's seed, and for paths of the run's files.
"""

from __future__ import annotations

import random
from pathlib import Path

from seoro.files.path_mapping import Locate, unchanged_path


class MethodContext:
    """The run as seen by external methods.

    Args:
        seed: Seed of all random numbers.
        file: The scenario file.
        output_directory: Output folder of the run, or None.
        locate: Maps absolute paths of files.
    """

    def __init__(
        self, seed: int, file: Path, output_directory: Path | None = None, locate: Locate = unchanged_path
    ) -> None:
        self.seed = seed
        self._locate = locate
        self.file = file
        self.output_directory = output_directory
        self._streams: dict[str, random.Random] = {}

    def resolve_path(self, name: str) -> Path:
        """Resolve a path in the scenario: relative to the scenario file, or absolute."""
        return self._locate(self.file.parent / name)

    def random(self, purpose: str) -> random.Random:
        """Return the stream of random numbers for a purpose; it lasts as long as the run.

        On the clocks `virtual` and `sim`, methods are called in the same order in each run with a seed, and draw
        the same numbers.
        """
        if purpose not in self._streams:
            # With a prefix, so that it differs from all streams of behaviors.
            self._streams[purpose] = random.Random(f"{self.seed}/method/{purpose}")  # noqa: S311 - reproducible
        return self._streams[purpose]
