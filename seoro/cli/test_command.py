"""`seoro test`: run scenario files, and tests in Python, by pytest."""

from __future__ import annotations

import argparse
import shlex
import sys
from contextlib import nullcontext, redirect_stdout
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from seoro.cli.arguments import TEXT, add_option, add_output_format
from seoro.cli.exit_status import Exit
from seoro.cli.notifying import add_notify_argument, notifying, use_notify
from seoro.cli.packages import require
from seoro.cli.shards import Shard
from seoro.errors import UsageError
from seoro.lang.projects import Project, project_of

EXAMPLES = """examples:
  seoro test
  seoro test scenarios/ -k deliver -j 4
  seoro test --last-failed
  seoro test --retries 2 --junit results.xml
  seoro test --shard 2/5 --output-format github
  seoro test --on lab-a
  seoro test --watch

Without PATH, the tests are those of the project (`paths` in `[tool.seoro.test]`), else those of this folder.

exit status: 0 all passed, 1 some failed, 2 invalid command line or no tests,
3 error in pytest, 130 by Ctrl-C"""

_STATUSES: Final = {0: Exit.PASSED, 1: Exit.FAILED, 2: Exit.INTERRUPTED, 3: Exit.ERROR, 4: Exit.INVALID}
_IMPORTED: Final = "ignore:Module already imported:pytest.PytestAssertRewriteWarning"  # seoro itself
_NO_TESTS: Final = 5  # exit status of pytest


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("paths", metavar="PATH", nargs="*", help="files and folders, or FILE::TEST")
    add_option(parser, "-k EXPRESSION", "only tests whose names match, such as 'maze and not slow'")
    add_option(parser, "-m --tag EXPRESSION", "only tests with marks (`# pytest: smoke`), such as 'smoke or fast'")
    add_option(parser, "-j --jobs N", "number of tests at a time (default: that of the project, else 1)")
    add_option(parser, "-x --fail-fast", "end after the first test that does not pass")
    add_option(parser, "--last-failed", "only tests that failed last time, or all if none did")
    add_option(parser, "--retries N", "further attempts of a failed test, which is flaky if it then passes")
    add_option(
        parser, "--shard N/M", "only part N of M; a test belongs to the same part each time", type=Shard.parse
    )
    add_option(parser, "--sim NAME", "simulator for all scenarios (default: that of the file or the project)")
    add_option(parser, "--seed N", "seed of scenarios without own seeds, or `random` (default: 0)", type=str)
    add_option(parser, "--on EXECUTOR", "run scenarios on this executor, started with `seoro serve`")
    add_option(parser, "--watch", "run the tests again whenever a file changes, until Ctrl-C")
    add_option(parser, "--list", "list the tests without running them")
    add_option(parser, "--junit FILE", "write the results as JUnit XML to this file")
    add_option(parser, "--requirements", "list requirements with the results of their tests")
    add_option(parser, "--report DIR", "write a page that shows it for each run of a scenario to this folder")
    add_option(parser, "--pytest OPTIONS", "further options of pytest, such as '--durations 5'", default="")
    add_notify_argument(parser)
    add_output_format(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    require("`seoro test`", "test", "pytest")
    if options.watch:
        from seoro.cli.watching import rerun_at_changes  # noqa: PLC0415 - for this option only

        return rerun_at_changes(options.arguments, _watched(options))
    return _run_pytest(options)


def _run_pytest(options: argparse.Namespace) -> int:
    import pytest  # noqa: PLC0415 - slow to load

    from seoro.cli.test_outcomes import TITLES, Outcomes  # noqa: PLC0415 - the same
    from seoro.text.findings import formatted  # noqa: PLC0415 - for this command only

    project = _project(options)
    use_notify(options, {} if project is None else project.values)
    if options.list:
        options.notify = []
    outcomes = Outcomes()
    is_text = options.output_format == TEXT
    # Other formats are for programs: all else goes to stderr.
    with notifying(options, "test", outcomes.content), nullcontext() if is_text else redirect_stdout(sys.stderr):
        status = outcomes.status = int(pytest.main(arguments_of(options), plugins=[outcomes]))
    if not is_text and status in {0, 1}:
        print(formatted(options.output_format, outcomes.findings, TITLES))
    if status == _NO_TESTS:
        is_filtered = any((options.k, options.tag, options.shard))
        hint = "no test matches `-k`, `--tag` and `--shard`" if is_filtered else "name files or folders with tests"
        raise UsageError("no tests found", help=hint)
    return _STATUSES.get(status, Exit.ERROR)


def arguments_of(options: argparse.Namespace) -> list[str]:
    """Return the command line of pytest for the options, and for the settings of the project.

    Raises:
        UsageError: A setting is invalid, or the package of an option is missing.
    """
    project = _project(options)
    settings: dict[str, Any] = {} if project is None else dict(project.test)
    paths = options.paths or [str(path) for path in settings.get("paths", ())] or ["."]
    arguments = ["--quiet", "--no-header", "-r", "fE", "--tb", "short", "-W", _IMPORTED, *paths]
    if project is not None:
        arguments += ["--rootdir", str(project.folder)]
    for option, value in {
        "-k": options.k,
        "-m": options.tag,
        "--osc-shard": options.shard,
        "--osc-sim": options.sim,
        "--osc-seed": options.seed,
        "--osc-on": options.on,
        "--junit-xml": options.junit,
        "--seoro-report": options.report,
    }.items():
        arguments += [] if value is None else [option, str(value)]
    if options.requirements:
        arguments.append(f"--osc-requirements={settings.get('requirements', '')}")
    arguments += ["--last-failed"] * options.last_failed + ["--exitfirst"] * options.fail_fast
    arguments += ["--collect-only"] * options.list
    jobs = settings.get("jobs", 1) if options.jobs is None else options.jobs
    retries = settings.get("retries", 0) if options.retries is None else options.retries
    if jobs > 1 and not options.list:
        _need("jobs", "xdist", "pytest-xdist")
        arguments += ["--numprocesses", str(jobs), "--dist", "worksteal"]
    if retries > 0:
        _need("retries", "pytest_rerunfailures", "pytest-rerunfailures")
        arguments += ["--reruns", str(retries)]
    return [*arguments, *shlex.split(options.pytest)]


def _need(option: str, module: str, package: str) -> None:
    if find_spec(module) is None:
        raise UsageError(f"`--{option}` needs the package {package}", help="pip install 'seoro[test]'")


def _watched(options: argparse.Namespace) -> Path:
    """Return the folder whose files are watched: that of the project, else the working directory."""
    project = _project(options)
    return Path.cwd() if project is None else project.folder


def _project(options: argparse.Namespace) -> Project | None:
    """Return the project of the first path, else of the working directory."""
    first = options.paths[0].partition("::")[0] if options.paths else "."
    return project_of(Path(first))
