"""Conformance cases that lie outside of this repository, where there are some.

`SEORO_CONFORMANCE` names a folder with a runner `run.py` and cases; by default it is `shared/conformance` beside
the repository. A case is a scenario whose first lines say what is expected of it; those of which `seoro check`
decides are run here in this process. `python run.py --seoro seoro` in that folder runs them all.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType

import pytest

from seoro.embed import check_file
from seoro.lang.diagnostic import Severity

FOLDER = Path(os.environ.get("SEORO_CONFORMANCE") or Path(__file__).parents[2] / "shared/conformance")


def load_runner() -> ModuleType | None:
    """The runner of the cases; None if there is none."""
    path = FOLDER / "run.py"
    if not path.is_file():
        return None
    specification = importlib.util.spec_from_file_location("seoro_conformance", path)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[specification.name] = module  # its dataclasses look themselves up there
    writes_bytecode, sys.dont_write_bytecode = sys.dont_write_bytecode, True  # nothing is left in that folder
    try:
        specification.loader.exec_module(module)
    finally:
        sys.dont_write_bytecode = writes_bytecode
    return module


RUNNER = load_runner()
CASES = [path for path in RUNNER.find_cases() if RUNNER.load_case(path).is_check] if RUNNER is not None else []


@pytest.mark.skipif(RUNNER is None, reason="there are no conformance cases here")
@pytest.mark.parametrize("path", CASES, ids=lambda path: path.relative_to(FOLDER).as_posix())
def test_checking_says_what_the_case_expects(path: Path) -> None:
    assert RUNNER is not None
    found = check_file(path).checked.diagnostics
    errors = [found.primary.span for found in found if found.severity is Severity.ERROR]
    places = tuple((Path(span.file.name).resolve(), span.line) for span in errors)
    outcome = RUNNER.Outcome("invalid" if errors else "valid", places)
    assert RUNNER.compare(RUNNER.load_case(path), outcome) == []
