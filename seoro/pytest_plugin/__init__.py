"""Scenario files as tests of pytest: what pytest loads in every project where seoro is installed.

So it does nothing, and imports next to nothing, until there is a scenario file to collect or a fixture is used.
`docs/pytest.md` says what it offers.
"""

from __future__ import annotations

import argparse
import math
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from seoro.embed.options import OptionFields
    from seoro.pytest_plugin.collecting import OscFile
    from seoro.pytest_plugin.running import RunScenario

SUFFIX = ".osc"
_WAS_BARE = "osc_was_bare"  # what xdist tells its workers


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("seoro", "scenario files (OpenSCENARIO DSL)")
    group.addoption("--osc-sim", metavar="NAME", help="start this simulator for each scenario: mujoco or pybullet")
    group.addoption("--osc-connect", metavar="ENDPOINT", help="use the simulator that runs at this endpoint")
    group.addoption("--osc-world", metavar="WORLD", help="name or file of the simulator's world")
    group.addoption(
        "--osc-clock",
        choices=("real", "virtual", "sim"),
        help="clock of scenarios (default: virtual, or the simulator's if there is one)",
    )
    group.addoption(
        "--osc-seed",
        type=_seed,
        default=0,
        metavar="N",
        help="seed of scenarios that name none, or `random` to draw it (default: 0)",
    )
    group.addoption(
        "--osc-timeout",
        type=_seconds,
        metavar="SECONDS",
        help="end a scenario as an error after this wall time (default: 3600)",
    )
    parser.addini(
        "osc_files",
        type="args",
        default=None,
        help="globs of the scenario files that are tests (default: all below the paths that pytest is given)",
    )


def _seed(text: str) -> int | None:
    if text == "random":
        return None
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"a seed is a whole number from 0, or `random`, not {text!r}")
    return int(text)


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number of seconds above 0, not {text!r}")
    return value


def pytest_configure(config: pytest.Config) -> None:
    """Refuse options that do not go together."""
    named, connected, world = (config.getoption(f"osc_{key}") for key in ("sim", "connect", "world"))
    if named is not None and connected is not None:
        raise pytest.UsageError("--osc-sim and --osc-connect: a simulator is either started or connected to")
    if world is not None and named is None and connected is None:
        raise pytest.UsageError("--osc-world is a simulator's, and there is none: add --osc-sim mujoco")


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Called by xdist, whose workers are always given paths: tell them whether a person did."""
    node.workerinput[_WAS_BARE] = _is_bare(node.config)


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> OscFile | None:
    """Collect a scenario file that is asked for."""
    if file_path.suffix != SUFFIX or not _is_wanted(file_path, parent):
        return None
    from seoro.pytest_plugin.collecting import OscFile  # noqa: PLC0415 - the front end, for those who need it

    return OscFile.from_parent(parent, path=file_path)


def _is_wanted(path: Path, parent: pytest.Collector) -> bool:
    config = parent.config
    if parent.session.isinitpath(path):
        return True
    globs = config.getini("osc_files")
    if globs is None:
        return not _is_bare(config)
    inside = path.relative_to(config.rootpath) if path.is_relative_to(config.rootpath) else path
    return any(fnmatch(inside.as_posix() if "/" in glob else path.name, glob) for glob in globs)


def _is_bare(config: pytest.Config) -> bool:
    """Whether pytest was given no path, by nobody: then scenario files that lie about are not its business."""
    told: dict[str, bool] = getattr(config, "workerinput", {})
    return told.get(_WAS_BARE, config.args_source is pytest.Config.ArgsSource.INVOCATION_DIR)


@pytest.fixture
def osc_options(pytestconfig: pytest.Config) -> OptionFields:
    """How scenarios are run: the arguments of `seoro.start`, from pytest's command line.

    Override it in a `conftest.py` to choose a simulator, a clock, a seed or values of parameters for a folder.
    """
    from seoro.pytest_plugin.running import options_of  # noqa: PLC0415

    return options_of(pytestconfig)


@pytest.fixture
def osc_run(request: pytest.FixtureRequest, osc_options: OptionFields, tmp_path: Path) -> RunScenario:
    """Runs a scenario from a test in Python: `result = osc_run("maze.osc", seed=3); assert result.passed`.

    A path is relative to the folder of the test. Arguments of `seoro.start` go before those of `osc_options`.
    """
    from seoro.pytest_plugin.running import RunScenario  # noqa: PLC0415

    return RunScenario(request.node, request.path.parent, osc_options, tmp_path)
