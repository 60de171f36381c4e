"""Resources: sources of scenarios, and results of runs."""

from __future__ import annotations

from typing import Final
from urllib.parse import quote, unquote

from mcp_types import Resource, ResourceTemplate, TextResourceContents

from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input_text
from seoro.mcp.bounds import LARGEST
from seoro.mcp.reading import ListScenarios, ScenarioReader
from seoro.mcp.results import ExplainRun, ResultReader
from seoro.mcp.served_folder import ServedFolder

SCENARIO: Final = "seoro://scenario/"
RUN: Final = "seoro://run/"
TEMPLATES: Final = (
    ResourceTemplate(
        name="scenario",
        uri_template=f"{SCENARIO}{{+file}}",
        description="source of a scenario",
        mime_type="text/plain",
    ),
    ResourceTemplate(
        name="run",
        uri_template=f"{RUN}{{+folder}}",
        description="result of a run, as by `explain_run`",
        mime_type="application/json",
    ),
)


class Resources:
    """Resources of a server.

    Args:
        served: Folder of the server.
        scenarios: Reader of scenarios.
        results: Reader of results.
    """

    def __init__(self, served: ServedFolder, scenarios: ScenarioReader, results: ResultReader) -> None:
        self._served = served
        self._scenarios = scenarios
        self._results = results

    def list_scenarios(self) -> list[Resource]:
        """Return the first scenario files; `list_scenarios` lists all."""
        found = dict.fromkeys(each.file for each in self._scenarios.list_scenarios(ListScenarios()).scenarios)
        return [Resource(name=name, uri=SCENARIO + quote(name), mime_type="text/plain") for name in found]

    def read(self, uri: str) -> TextResourceContents:
        """Read a resource.

        Raises:
            UsageError: It is unknown, or larger than the limit of answers.
            OSError: It cannot be read.
        """
        if uri.startswith(SCENARIO):
            text = read_input_text(self._served.scenario(unquote(uri[len(SCENARIO) :])), Kind.SCENARIO)
            if len(text) > LARGEST:
                raise UsageError(f"the file is larger than {LARGEST:,} characters")
            return TextResourceContents(uri=uri, text=text, mime_type="text/plain")
        if uri.startswith(RUN):
            found = self._results.explain_run(ExplainRun(run=unquote(uri[len(RUN) :])))
            return TextResourceContents(uri=uri, text=found.model_dump_json(), mime_type="application/json")
        raise UsageError(f"unknown resource `{uri[:100]}`", help=f"resources: {SCENARIO}FILE, {RUN}FOLDER")
