"""Plugin of pytest that collects scenario files as tests; see `docs/how-to/pytest.md`.

pytest loads it in every project where seoro is installed. So it imports next to nothing until it collects a
scenario file or a test uses its fixtures.
"""

from __future__ import annotations

import argparse
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from seoro.cli.shards import Shard
    from seoro.embed.options import OptionFields
    from seoro.pytest_plugin.collector import OscFile
    from seoro.pytest_plugin.runner import RunScenario

SUFFIX = ".osc"
MARK = "seoro_campaign"
_FIXTURES = ("osc_options", "tmp_path")  # of functions with the mark
_WAS_BARE = "osc_was_bare"  # key of the data for xdist workers


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("seoro", "scenario files (OpenSCENARIO DSL)")
    group.addoption("--osc-sim", metavar="NAME", help="start this simulator for each scenario: mujoco or pybullet")
    group.addoption("--osc-connect", metavar="ENDPOINT", help="use the simulator node at this Zenoh endpoint")
    group.addoption("--osc-world", metavar="WORLD", help="name or file of the world")
    group.addoption(
        "--osc-clock",
        choices=("real", "virtual", "sim"),
        help="clock of scenarios (default: virtual; sim with a simulator)",
    )
    group.addoption(
        "--osc-seed",
        type=_seed,
        default=0,
        metavar="N",
        help="seed of scenarios without own seeds, or `random` (default: 0)",
    )
    group.addoption(
        "--osc-timeout",
        type=_seconds,
        metavar="SECONDS",
        help="end a scenario with an error after this wall time (default: 3600)",
    )
    group.addoption(
        "--osc-poses",
        type=_pose_rate,
        metavar="HZ",
        help="samples of poses in the trace, per second of the run's clock; 0 for none (default: 10)",
    )
    group.addoption(
        "--osc-on", metavar="EXECUTOR", help="run scenario files on this executor, started with `seoro serve`"
    )
    group.addoption("--osc-shard", type=_shard, metavar="N/M", help="only part N of M of all tests")
    group.addoption(
        "--osc-requirements",
        metavar="FILE",
        nargs="?",
        const="",
        help="list requirements with the results of their tests; FILE has the names of all, a line each",
    )
    group.addoption(
        "--seoro-report",
        type=Path,
        metavar="DIR",
        help="write a page that shows it for each run of a scenario to this folder",
    )
    parser.addini(
        "osc_files",
        type="args",
        default=None,
        help="globs of scenario files to collect (default: all below the paths given to pytest)",
    )


def _seed(text: str) -> int | None:
    if text == "random":
        return None
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"invalid seed {text!r}: expected a whole number from 0, or `random`")
    return int(text)


def _shard(text: str) -> Shard:
    from seoro.cli.shards import Shard  # noqa: PLC0415 - for this option only

    return Shard.parse(text)


def _seconds(text: str) -> float:
    from seoro.cli.arguments import positive  # noqa: PLC0415 - for this option only

    return positive(text)


def _pose_rate(text: str) -> float:
    from seoro.cli.arguments import pose_rate  # noqa: PLC0415 - for this option only

    return pose_rate(text)


def pytest_configure(config: pytest.Config) -> None:
    """Declare the mark, and check that options are consistent."""
    config.addinivalue_line(
        "markers",
        f"{MARK}(file, *, rate, runs=1000, vary=(), jobs=None): run a campaign, and fail unless its pass rate is "
        "at least `rate` with 95 % confidence; `file` is for tests in Python",
    )
    config.addinivalue_line("markers", "requirement(*names): requirements that a test covers")
    listed: str | None = config.getoption("osc_requirements")
    if listed is not None:
        from seoro.pytest_plugin.requirements import Requirements  # noqa: PLC0415 - for this option only

        config.pluginmanager.register(Requirements(config, Path(listed) if listed else None))
    named, connected, world = (config.getoption(f"osc_{key}") for key in ("sim", "connect", "world"))
    if named is not None and connected is not None:
        raise pytest.UsageError("--osc-sim contradicts --osc-connect: leave out one of them")
    if world is not None and named is None and connected is None:
        raise pytest.UsageError("--osc-world needs a simulator: add --osc-sim mujoco")


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Pass on to xdist workers whether the user gave paths; workers always get some."""
    node.workerinput[_WAS_BARE] = _is_bare(node.config)


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> OscFile | None:
    """Collect a scenario file that is selected."""
    if file_path.suffix != SUFFIX or not _is_wanted(file_path, parent):
        return None
    from seoro.pytest_plugin.collector import OscFile  # noqa: PLC0415 - slow to load

    return OscFile.from_parent(parent, path=file_path)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the tests of the chosen shard."""
    shard: Shard | None = config.getoption("osc_shard")
    if shard is None:
        return
    others = [item for item in items if not shard.has(item.nodeid)]
    if others:
        config.hook.pytest_deselected(items=others)
        items[:] = [item for item in items if shard.has(item.nodeid)]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> None:
    """Mark a test that passes after a failed attempt as flaky."""
    if call.when == "call" and call.excinfo is None and getattr(item, "execution_count", 1) > 1:
        item.user_properties.append(("flaky", "true"))


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Add the requirements of a test to its properties, which JUnit XML has."""
    properties = (("requirement", name) for name in requirements_of(item))
    item.user_properties += [each for each in properties if each not in item.user_properties]


def requirements_of(item: pytest.Item) -> tuple[str, ...]:
    """Return the names of the requirements that a test covers, by its marks."""
    marks = item.iter_markers("requirement")
    return tuple(dict.fromkeys(str(name) for mark in marks for name in mark.args))


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """List flaky tests."""
    passed = terminalreporter.stats.get("passed", ())
    flaky = [report.nodeid for report in passed if ("flaky", "true") in report.user_properties]
    if flaky:
        terminalreporter.section("flaky: passed after a failed attempt")
        for name in flaky:
            terminalreporter.line(name)


def pytest_itemcollected(item: pytest.Item) -> None:
    """Request the fixtures of a function in Python with a campaign."""
    if isinstance(item, pytest.Function) and _campaign_of(item) is not None:
        item.fixturenames += [name for name in _FIXTURES if name not in item.fixturenames]


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> None:
    """Run the campaign of a function in Python before the function itself."""
    mark = _campaign_of(pyfuncitem)
    if mark is not None:
        from seoro.pytest_plugin.campaigns import run_file  # noqa: PLC0415 - slow to load

        found: dict[str, Any] = pyfuncitem.funcargs
        run_file(mark, pyfuncitem.path.parent, found["osc_options"], found["tmp_path"])


def _campaign_of(item: pytest.Function) -> pytest.Mark | None:
    """Return the mark of a function in Python; scenarios run their campaigns themselves."""
    return None if item.path.suffix == SUFFIX else item.get_closest_marker(MARK)


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
    """Return whether the user gave no paths; then only files matching `osc_files` are collected."""
    received: dict[str, bool] = getattr(config, "workerinput", {})
    return received.get(_WAS_BARE, config.args_source is pytest.Config.ArgsSource.INVOCATION_DIR)


@pytest.fixture
def osc_options(pytestconfig: pytest.Config) -> OptionFields:
    """Keyword arguments of `seoro.start` for all scenarios, from pytest's command line.

    Override it in a `conftest.py` to choose a simulator, a clock, a seed or values of parameters for a folder.
    """
    from seoro.pytest_plugin.runner import options_of  # noqa: PLC0415

    return options_of(pytestconfig)


@pytest.fixture
def osc_run(request: pytest.FixtureRequest, osc_options: OptionFields, tmp_path: Path) -> RunScenario:
    """Function that runs a scenario in a Python test: `assert osc_run("maze.osc", seed=3).passed`.

    Paths are relative to the folder of the test. Arguments take precedence over `osc_options`.
    """
    from seoro.pytest_plugin.runner import RunScenario  # noqa: PLC0415

    return RunScenario(request.node, request.path.parent, osc_options, tmp_path)
