"""Tools that read scenarios: list, describe, check, and explanations of codes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from pydantic import Field

from seoro.embed.directives import read_directives
from seoro.embed.scenarios import Scenario, check_file
from seoro.errors import UsageError
from seoro.lang.diagnostic import Diagnostic, Severity
from seoro.lang.explain import explanation, near_codes
from seoro.lang.lint.linter import with_lints
from seoro.lang.render import to_json
from seoro.mcp.bounds import MOST_ITEMS, Bounds
from seoro.mcp.served_folder import ServedFolder
from seoro.mcp.tool import Answer, Arguments
from seoro.ui.parameters import read_form
from seoro.ui.scenario_files import ScenarioFiles
from seoro.ui.walking import walk

_MOST_CHECKED: Final = 100  # files of a check
_OUTSIDE: Final = "(a file outside of the served folder)"


class ListScenarios(Arguments):
    """Arguments of `list_scenarios`."""

    folder: str = Field("", description="folder to list, relative to the served one")
    offset: int = Field(0, ge=0, description="number of scenarios to skip")


class ScenarioEntry(Answer):
    """A scenario in the list."""

    file: str
    scenario: str = Field(description="its name; empty if the file has errors")
    line: int
    doc: str = Field(description="the comment above it")
    problem: str = Field("", description="the first error of the file")


class Scenarios(Answer):
    """Scenarios of the folder."""

    scenarios: list[ScenarioEntry]
    total: int
    next_offset: int | None = Field(description="offset of the rest; null at the end")


class DescribeScenario(Arguments):
    """Arguments of `describe_scenario`."""

    file: str = Field(description="scenario file, relative to the served folder")
    scenario: str = Field("", description="name of the scenario; may be left out if the file has one")


class ScenarioDescription(Answer):
    """Parameters and needs of a scenario."""

    file: str
    scenario: str
    parameters: list[dict[str, Any]] = Field(
        description="path, type, unit, default, doc, choices and bounds of each; `required` ones need a value"
    )
    robots: list[str]
    needs_simulator: bool
    simulators: list[str]
    world: str
    requirements: list[str]
    seed: int | None
    timeout: float | None = Field(description="limit of the wall time [s]")
    cut: list[str] = Field(description="places of values that were cut")


class CheckScenarios(Arguments):
    """Arguments of `check_scenarios`."""

    path: str = Field("", description="scenario file, or folder with such files, relative to the served folder")


class CodeFinding(Answer):
    """A finding."""

    file: str
    line: int
    column: int
    severity: str
    code: str = Field(description="`explain_code` explains it")
    message: str
    help: str = Field(description="suggested fix; may be empty")


class Findings(Answer):
    """Findings of a check."""

    files: int
    errors: int
    warnings: int
    findings: list[CodeFinding]
    is_cut: bool = Field(description="whether findings or files were left out")


class ExplainCode(Arguments):
    """Arguments of `explain_code`."""

    code: str = Field(description="code of a finding, such as E0312")


class CodeExplanation(Answer):
    """Explanation of a code."""

    code: str
    title: str
    text: str = Field(description="Markdown, with a wrong and a right example")


def checked_scenario(path: Path, name: str) -> Scenario:
    """Check a scenario without its Python.

    Args:
        path: The file.
        name: Its name in messages.

    Raises:
        UsageError: It has errors; the message does not quote them, since they may be in files elsewhere.
    """
    scenario = check_file(path, import_python=False, name=name)
    if any(each.severity is Severity.ERROR for each in scenario.checked.diagnostics):
        raise UsageError(f"`{name}` has errors", help="`check_scenarios` lists them")
    return scenario


class ScenarioReader:
    """Reads scenarios.

    Args:
        served: Folder of the server.
    """

    def __init__(self, served: ServedFolder) -> None:
        self._served = served
        self._files = ScenarioFiles((served.root,))

    def list_scenarios(self, given: ListScenarios) -> Scenarios:
        """List scenarios."""
        folder = self._served.folder(given.folder)
        found = [
            each
            for each in self._files.list()
            if (path := self._served.root / each["file"]).is_relative_to(folder) and self._served.name(path)
        ]
        shown = found[given.offset : given.offset + MOST_ITEMS]
        after = given.offset + len(shown)
        return Scenarios(
            scenarios=[ScenarioEntry(scenario=each.pop("name"), **each) for each in map(dict, shown)],
            total=len(found),
            next_offset=after if after < len(found) else None,
        )

    def describe_scenario(self, given: DescribeScenario) -> ScenarioDescription:
        """Describe a scenario. Its Python is not imported."""
        path = self._served.scenario(given.file)
        scenario = checked_scenario(path, given.file)
        entry = scenario.entry(given.scenario or None)
        form = read_form(path, given.file, entry.name)
        directives = read_directives(scenario.file, scenario.scenario_lines)
        own, bounds = directives.scenarios.get(entry.line, directives.common), Bounds()
        world = own.world or ""
        return ScenarioDescription(
            file=given.file,
            scenario=entry.name,
            parameters=bounds.apply([vars(each) for each in form.parameters], "parameters"),
            robots=bounds.apply(form.robots, "robots"),
            needs_simulator=bool(own.simulators or own.world),
            simulators=list(own.simulators),
            world=(self._served.name(Path(world)) or _OUTSIDE) if Path(world).is_absolute() else world,
            requirements=bounds.apply(own.requirements, "requirements"),
            seed=next(iter(own.seeds), None),
            timeout=own.timeout,
            cut=bounds.cut,
        )

    def check_scenarios(self, given: CheckScenarios) -> Findings:
        """Check scenario files. Their Python is not imported."""
        target = self._served.path(given.path)
        files = [self._served.scenario(given.path)] if target.is_file() else list(self._below(target))
        if not files:
            raise UsageError(f"no scenario files in `{given.path}`", help="`list_scenarios` lists them")
        found = list(dict.fromkeys(self._findings(files[:_MOST_CHECKED])))
        found.sort(key=lambda each: each[3] != Severity.ERROR.value)
        shown = [CodeFinding(**dict(zip(CodeFinding.model_fields, each, strict=True))) for each in found]
        errors = sum(each.severity == Severity.ERROR.value for each in shown)
        return Findings(
            files=len(files[:_MOST_CHECKED]),
            errors=errors,
            warnings=len(shown) - errors,
            findings=shown[:MOST_ITEMS],
            is_cut=len(shown) > MOST_ITEMS or len(files) > _MOST_CHECKED,
        )

    def explain_code(self, given: ExplainCode) -> CodeExplanation:
        """Explain a code."""
        found = explanation(given.code)
        if found is None:
            hint = near_codes(given.code) or "`check_scenarios` lists findings with their codes"
            raise UsageError(f"unknown code `{given.code[:100]}`", help=hint)
        return CodeExplanation(code=found.code, title=found.title, text=found.text)

    def _below(self, folder: Path) -> Iterator[Path]:
        for place, _, names in walk((folder,)):
            for name in sorted(names):
                if name.endswith(".osc") and self._served.name(place / name) is not None:
                    yield place / name

    def _findings(self, files: list[Path]) -> Iterator[tuple[Any, ...]]:
        for file in files:
            scenario = check_file(file, import_python=False, name=self._served.name(file))
            for each in with_lints(scenario.checked):
                yield self._finding(each)

    def _finding(self, diagnostic: Diagnostic) -> tuple[Any, ...]:
        """Return the fields of a finding; one in a file outside of the folder has no text, which may quote it."""
        found = Bounds().apply(to_json(diagnostic), "finding")
        path = diagnostic.primary.span.file.path
        if path is not None and self._served.name(path) is None:
            found |= {"file": _OUTSIDE, "message": "invalid import", "help": "import files below the folder"}
        elif path is not None:
            found["file"] = self._served.name(path)
        return tuple(found[name] for name in CodeFinding.model_fields)
