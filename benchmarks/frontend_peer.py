"""Prints the seconds that `scenario-execution` takes to parse a file, to build its model, and to resolve that.

Run by `frontend.py`, with the interpreter of an environment that has it.
"""

from __future__ import annotations

import logging
import sys
import time

import py_trees
from scenario_execution.model.model_resolver import resolve_internal_model
from scenario_execution.model.osc2_parser import OpenScenario2Parser


def main(path: str) -> None:
    """Measure and print."""
    logger = logging.getLogger("peer")
    parser = OpenScenario2Parser(logger)
    start = time.process_time()
    tree = parser.parse_file(path, False)
    parsed = time.process_time()
    model = parser.load_internal_model(tree, path, False, False)
    built = time.process_time()
    resolve_internal_model(model, py_trees.composites.Sequence(name="", memory=True), logger, False)
    resolved = time.process_time()
    print(parsed - start, built - parsed, resolved - built)


if __name__ == "__main__":
    main(sys.argv[1])
