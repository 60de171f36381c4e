"""Collection of scenario files as modules of pytest, and of their scenarios as test functions.

Since items are functions, fixtures, marks and other plugins work as for Python tests. Each function runs one
scenario with one combination of parameters.
"""

from __future__ import annotations

import ast
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from seoro.cli.terminal import error_text
from seoro.embed import Scenario, check_file
from seoro.embed.directives import INVALID, Directives, FileDirectives, MarkComment, read_directives, top_scenarios
from seoro.embed.options import OptionFields
from seoro.errors import InvalidScenario, UsageError
from seoro.lang.lower.lower import find_entry
from seoro.lang.symbols import TypeSymbol
from seoro.pytest_plugin.runner import Case, run_case

MAX_VALUE = 40  # characters of a value in a test name
_EXAMPLE = "for example `slow, flaky(reruns=2)`"
CHECK = "check"  # name of the test of an invalid file


class OscFile(pytest.Module):
    """Scenario file as a module of pytest, so that fixtures may have its scope."""

    obj = None

    def collect(self) -> Iterator[OscItem]:
        """Yield an item per scenario and variant; a single failing one for an invalid file."""
        scenario = check_file(_shown(self.path))
        symbols = top_scenarios(scenario.checked)
        try:
            found = read_directives(scenario.file, scenario.scenario_lines)
            marks = {each: read_marks(each.marks) for each in (found.common, *found.scenarios.values())}
            tests = [] if scenario.checked.errors else list(self._tests(scenario, symbols, found))
        except (InvalidScenario, UsageError) as error:
            yield self._check(Directives(), error)
            return
        if scenario.checked.errors:
            yield self._check(found.common, InvalidScenario(scenario.checked.errors), marks[found.common])
        for name, line, case in tests:
            run = _function(case, [*marks[case.directives], *_requirements(case.directives)])
            yield OscItem.from_parent(self, name=name, callobj=run, line=line)

    def _tests(
        self, scenario: Scenario, symbols: Sequence[TypeSymbol], found: FileDirectives
    ) -> Iterator[tuple[str, int, Case]]:
        """Yield name, line and case of each test; a simulator on the command line replaces those of directives."""
        given = self.config.getoption("osc_sim") or self.config.getoption("osc_connect")
        for symbol in _chosen(scenario, symbols, found):
            directives = found.scenarios.get(symbol.span.line, found.common)
            varied = directives if given is None else replace(directives, simulators=())
            bare = symbol.plan_name.replace("::", ".")  # pytest has another meaning for the colons
            for variant, simulator, options in _variants(varied):
                name = f"{bare}[{variant}]" if variant else bare
                options["name"] = symbol.plan_name
                yield name, symbol.span.line, Case(scenario, directives, options, simulator)

    def _check(
        self,
        directives: Directives,
        error: InvalidScenario | UsageError,
        marks: Sequence[pytest.MarkDecorator] = (),
    ) -> OscItem:
        """Make the item of an invalid file; it passes if the error is expected."""

        def check() -> None:
            if directives.expect != INVALID or directives.reason not in str(error):
                pytest.fail(error_text(error), pytrace=False)

        check.pytestmark = list(marks)  # type: ignore[attr-defined]
        return OscItem.from_parent(self, name=CHECK, callobj=check, line=1)


class OscItem(pytest.Function):
    """Scenario as a test.

    Args:
        line: Line of its declaration, from 1.
    """

    def __init__(self, *, line: int, **arguments: Any) -> None:
        super().__init__(**arguments)
        self._line = line
        # pytest 9.2 compares the parts of node ids with those parsed from its cache. A new id whose name has
        # brackets has other parts until it is parsed, too. Otherwise `--lf` and `--sw` would not find it.
        node_id = getattr(self, "_id", None)
        if node_id is not None:
            self._id = type(node_id).parse(str(node_id))

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return the location and the name of the test for reports."""
        return self.path, self._line - 1, self.name


def _shown(path: Path) -> str:
    """Return the name of a file in messages, relative to the working directory if below it."""
    folder = Path.cwd()
    return os.fspath(path.relative_to(folder) if path.is_relative_to(folder) else path)


def _chosen(scenario: Scenario, symbols: Sequence[TypeSymbol], found: FileDirectives) -> Sequence[TypeSymbol]:
    """Return the scenarios that are tests: those with directives, else the entry, else all."""
    chosen = [symbol for symbol in symbols if symbol.span.line in found.scenarios]
    if chosen or not symbols:
        return chosen
    try:
        return [find_entry(scenario.checked, None)]
    except InvalidScenario:
        return symbols


def _variants(directives: Directives) -> Iterator[tuple[str, str | None, OptionFields]]:
    """Yield all combinations of varied values: a unique name that `-k` can select, the simulator, and options.

    The name is empty if nothing is varied. Without a simulator or a seed, those of the fixture are used.
    """
    choices = [[(axis.name, value) for value in axis.values] for axis in directives.axes]
    seen: Counter[str] = Counter()
    for simulator, file, seed, values in product(
        directives.simulators or [None], directives.files or [None], directives.seeds or [None], product(*choices)
    ):
        parts = [
            *([simulator] if simulator else []),
            *([file.stem] if file else []),
            *(f"{name}:{value[:MAX_VALUE]}" for name, value in values),
            *([f"seed:{seed}"] if seed is not None else []),
        ]
        name = "-".join(parts)
        again = f"-{seen[name]}" if seen[name] else ""
        seen[name] += 1
        options = OptionFields(overrides=dict(values), parameters=file)  # `start` adds those of `set`
        if seed is not None:
            options["seed"] = seed
        yield name + again, simulator, options


def _requirements(directives: Directives) -> Iterator[pytest.MarkDecorator]:
    if directives.requirements:
        yield pytest.mark.requirement(*directives.requirements)


def _function(case: Case, marks: Sequence[pytest.MarkDecorator]) -> Callable[..., None]:
    """Make the test function; its parameters are fixtures."""

    def run(request: pytest.FixtureRequest, osc_options: OptionFields, tmp_path: Path) -> None:
        run_case(case, request.node, osc_options, tmp_path)

    run.pytestmark = list(marks)  # type: ignore[attr-defined]
    return run


# ---------------------------------------------------------------- marks in `# pytest:` comments


def read_marks(comments: Iterable[MarkComment]) -> tuple[pytest.MarkDecorator, ...]:
    """Read the marks of a scenario.

    Raises:
        UsageError: A mark is missing, invalid or unknown; the error has its place.
    """
    return tuple(_decorator(parsed, comment) for comment in comments for parsed in _parse(comment))


def _parse(comment: MarkComment) -> list[tuple[str, list[Any], dict[str, Any]]]:
    try:
        tree = ast.parse(f"[{comment.text}]", mode="eval").body
        assert isinstance(tree, ast.List)
        parsed = [_mark(element) for element in tree.elts]
    except (SyntaxError, ValueError) as error:
        raise UsageError(f"invalid marks: `{comment.text}`", comment.span, _EXAMPLE) from error
    if not parsed:
        raise UsageError("missing mark", comment.span, _EXAMPLE)
    return parsed


def _decorator(parsed: tuple[str, list[Any], dict[str, Any]], comment: MarkComment) -> pytest.MarkDecorator:
    name, arguments, keywords = parsed
    if name == "parametrize":
        raise UsageError(
            "unsupported mark `parametrize`", comment.span, "write `# seoro: parametrize speed=[1mps, 2mps]`"
        )
    try:
        mark: pytest.MarkDecorator = getattr(pytest.mark, name)
    except (AttributeError, pytest.fail.Exception) as error:
        raise UsageError(str(error), comment.span) from error
    # `with_args`, since a mark called with a single function would decorate it.
    return mark.with_args(*arguments, **keywords) if arguments or keywords else mark


def _mark(element: ast.expr) -> tuple[str, list[Any], dict[str, Any]]:
    """Parse name, literal arguments and keywords of a mark; raise `ValueError` for anything else."""
    match element:
        case ast.Name(id=name):
            return name, [], {}
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=keywords):
            named = {keyword.arg: ast.literal_eval(keyword.value) for keyword in keywords if keyword.arg}
            return name, [ast.literal_eval(argument) for argument in arguments], named
    raise ValueError
