"""Pages of scenario runs (`--seoro-report DIR`)."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

import pytest

from seoro.report.page import write_report
from seoro.runtime.trace.jsonl import to_line

OPTION: Final = "seoro_report"
_LONGEST: Final = 150  # [characters] of a name, below the limit of file systems
_UNSAFE: Final = re.compile(r"[^A-Za-z0-9.-]+")


_WRITTEN: Final = pytest.StashKey[list[Path]]()


def write_page(item: pytest.Item, records: Iterable[dict[str, Any]]) -> None:
    """Write the report of a run. Further runs of a test get numbers.

    Args:
        item: The test.
        records: Trace of the run.
    """
    folder = item.config.invocation_params.dir / item.config.getoption(OPTION)
    folder.mkdir(parents=True, exist_ok=True)
    name = _UNSAFE.sub("_", item.nodeid).strip("_.")[-_LONGEST:]
    written: list[Path] = item.stash.setdefault(_WRITTEN, [])
    path = folder / f"{name}{f'-{len(written) + 1}' if written else ''}.html"
    with path.open("w", encoding="utf-8", newline="\n") as file:
        write_report(io.BytesIO(b"".join(map(to_line, records))), None, file)
    written.append(path)
    item.add_report_section("call", "scenario report", str(path))
