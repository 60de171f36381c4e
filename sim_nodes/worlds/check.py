"""Checks the files of worlds by themselves: the keys and values of each, without its maps, scenes and generation.

    python -m sim_nodes.worlds.check WORLD...

ends at the first error, which it prints. So a campaign whose worlds differ finds a misspelled key before its runs.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from sim_nodes.worlds.loader import WorldError, read_described


def main(worlds: Sequence[str]) -> int:
    """Check worlds; returns the exit status.

    Args:
        worlds: Names or paths of worlds, perhaps with parameters.
    """
    for world in worlds:
        try:
            read_described(world)
        except WorldError as error:
            sys.stderr.write(f"{error}\n")
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
