"""Options of emitted runs that directives do not have, for pytest: a `conftest.py` beside the files."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from seoro.campaign.emit import MARK, check_replaceable
from seoro.embed.options import Lab, Options, Ros, Simulator
from seoro.files.inputs import Kind, read_input, resolved

CONFTEST: Final = "conftest.py"
_TEXT: Final = """{mark}: options of its runs, for pytest.
from pathlib import Path

import pytest

import seoro

FOLDER = Path(__file__).parent


@pytest.fixture
def osc_options(osc_options):
    return {{**osc_options, {options}}}
"""


def needs_conftest(options: Options) -> bool:
    """Whether pytest needs more options than directives of the files have, and its own ones."""
    simulator = options.simulator
    named = simulator and Simulator(simulator.name, world=simulator.world, rate=simulator.rate)
    return options.lab is not None or options.ros is not None or simulator != named


def place_conftest(options: Options, folder: Path) -> bool:
    """Write the file if it is needed, and remove an earlier one otherwise; returns whether it is there.

    Args:
        options: Options that all runs share.
        folder: Folder of the emitted files.

    Raises:
        UsageError: A file of this name was not written by a campaign.
        OSError: It cannot be written.
    """
    path = folder / CONFTEST
    if not needs_conftest(options):
        if path.exists() and read_input(path, Kind.OUTPUT).startswith(MARK.encode()):
            path.unlink()
        return False
    check_replaceable(path)
    path.write_text(_TEXT.format(mark=MARK, options=", ".join(_fields(options, resolved(folder)))), "utf-8")
    return True


def _fields(options: Options, folder: Path) -> Iterator[str]:
    if options.clock is not None:
        yield f'"clock": {options.clock!r}'
    if options.lab is not None:
        yield f'"lab": seoro.Lab({", ".join(_lab(options.lab, folder))})'
    if options.ros is not None:
        yield f'"ros": seoro.Ros({", ".join(_ros(options.ros, folder))})'
    if options.simulator is not None:
        yield f'"simulator": seoro.Simulator({", ".join(_simulator(options.simulator, folder))})'


def _lab(lab: Lab, folder: Path) -> Iterator[str]:
    yield _path(lab.file, folder)
    yield from _rate(lab.rate)
    yield from _paths("model_path", lab.model_path, folder)


def _ros(ros: Ros, folder: Path) -> Iterator[str]:
    yield repr(ros.endpoint)
    yield f"domain={ros.domain}"
    if ros.dialect is not None:
        yield f"dialect={ros.dialect!r}"
    yield from _paths("interfaces", ros.interfaces, folder)
    if not ros.state:
        yield "state=False"


def _simulator(simulator: Simulator, folder: Path) -> Iterator[str]:
    texts = {"name": simulator.name, "endpoint": simulator.endpoint, "world": simulator.world}
    yield from (f"{key}={text!r}" for key, text in texts.items() if text is not None)
    yield from _rate(simulator.rate)
    if simulator.snapshot is not None:
        yield f"snapshot={_path(Path(simulator.snapshot), folder)}"
    yield from _paths("model_path", simulator.model_path, folder)


def _rate(rate: float | None) -> Iterator[str]:
    if rate is not None:
        yield "rate=" + ('"max"' if rate == math.inf else repr(rate))


def _paths(name: str, paths: Sequence[Path], folder: Path) -> Iterator[str]:
    if paths:
        yield f"{name}=[{', '.join(_path(each, folder) for each in paths)}]"


def _path(path: Path, folder: Path) -> str:
    """Return a path as an expression, relative to the folder."""
    return f"FOLDER / {os.path.relpath(resolved(path), folder)!r}"
