"""What an external method sees of the run.

Methods take no time, and most need nothing but their arguments. A Python function whose first parameter is
annotated with `MethodContext` is given the run before them: for what it draws to come from the run's seed, and
for the places of the run's files.
"""

from __future__ import annotations

import random
from pathlib import Path

from seoro.located import Locate, as_named


class MethodContext:
    """The run, as external methods see it.

    Args:
        seed: Of everything that is drawn.
        file: The scenario file.
        output_directory: Where the results of the run go; None if it has no such place.
        locate: Gives the places of files that are named by absolute paths.
    """

    def __init__(
        self, seed: int, file: Path, output_directory: Path | None = None, locate: Locate = as_named
    ) -> None:
        self.seed = seed
        self._locate = locate
        self.file = file
        self.output_directory = output_directory
        self._streams: dict[str, random.Random] = {}

    def place_of(self, name: str) -> Path:
        """Where a file or a folder is that the scenario names, relative to its own file or by an absolute path."""
        return self._locate(self.file.parent / name)

    def random(self, purpose: str) -> random.Random:
        """A stream of random numbers of its own for each purpose, which lasts as long as the run.

        On the clocks `virtual` and `sim`, methods are called in the same order in each run of a seed, and so
        draw the same numbers.
        """
        if purpose not in self._streams:
            # A prefix of its own, so that no stream is one of those that behaviors draw from.
            self._streams[purpose] = random.Random(f"{self.seed}/method/{purpose}")  # noqa: S311 - reproducible
        return self._streams[purpose]
