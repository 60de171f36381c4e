"""Results of benchmarks as JSON lines, so that an interrupted benchmark continues when it is called again."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, TextIO, TypeVar

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    R = TypeVar("R", bound=DataclassInstance)


def read_results(file: Path, kind: type[R]) -> list[R]:
    """Return the results of a file; none without it.

    Args:
        file: Its path.
        kind: Class of the results, a dataclass of plain values.
    """
    if not file.exists():
        return []
    return [kind(**json.loads(line)) for line in file.read_text(encoding="utf-8").splitlines()]


def write_result(out: TextIO, result: DataclassInstance) -> None:
    """Append a result to an open file."""
    out.write(json.dumps(asdict(result)) + "\n")
    out.flush()
