"""Runs of scenarios from their text, in virtual time."""

import json
from collections.abc import Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import pytest

from seoro.embed import Scenario, accept, load, prepare
from seoro.embed.options import Options
from seoro.embed.runs import Run
from seoro.runtime.functions.actions import ActionFunction
from seoro.runtime.functions.modifiers import ModifierFunction
from seoro.runtime.verdict import Verdict
from tests.leftovers import leftovers  # noqa: F401 - a fixture, for all tests here

VIRTUAL = Options(clock="virtual")
LONG = 20_000  # records of a trace; to check more takes seconds
HEADER = "import osc.types\nimport osc.helpers\n\n"


@dataclass(frozen=True)
class Ran:
    """Result of a run: verdict and trace."""

    verdict: Verdict
    records: Sequence[dict[str, Any]]

    @property
    def logs(self) -> list[tuple[float, str]]:
        """Return times and texts of all logs."""
        return [(record["t"], record["message"]) for record in self.records if record["kind"] == "log"]

    @property
    def ends(self) -> dict[str, str]:
        """Return the status of every behavior by name; the last one of each name counts."""
        names = {record["id"]: record["name"] for record in self.records if record["kind"] == "behavior.start"}
        return {names[r["id"]]: r["status"] for r in self.records if r["kind"] == "behavior.end"}


class Prepare(Protocol):
    def __call__(
        self, text: str, options: Options = VIRTUAL, actions: Sequence[ActionFunction | ModifierFunction] = ()
    ) -> AbstractAsyncContextManager[Run]: ...


class RunText(Protocol):
    async def __call__(
        self, text: str, seed: int = 0, actions: Sequence[ActionFunction | ModifierFunction] = ()
    ) -> Ran: ...


def load_text(folder: Path, text: str, actions: Sequence[ActionFunction | ModifierFunction]) -> Scenario:
    """Load the text of a scenario, with additional actions."""
    path = folder / "test.osc"
    path.write_text(HEADER + text)
    module = ModuleType("actions_of_a_test")
    vars(module).update({function.__name__: function for function in actions})
    return load(path, modules=[module])


@pytest.fixture
def prepare_text(tmp_path: Path) -> Prepare:
    """Return a function that prepares a run of the text of a scenario."""

    def prepare_run(
        text: str, options: Options = VIRTUAL, actions: Sequence[ActionFunction | ModifierFunction] = ()
    ) -> AbstractAsyncContextManager[Run]:
        return prepare(load_text(tmp_path, text, actions), options)

    return prepare_run


@pytest.fixture
def run_text(tmp_path: Path) -> RunText:
    """Return a function that runs the text of a scenario on the virtual clock, and checks its trace."""

    async def run(text: str, seed: int = 0, actions: Sequence[ActionFunction | ModifierFunction] = ()) -> Ran:
        scenario = load_text(tmp_path, text, actions)
        async with prepare(scenario, Options(seed=seed, clock="virtual")) as started, started.running():
            records = [record async for record in started.trace()]
            verdict = await started.result()
        if len(records) < LONG:
            assert accept(scenario, json.loads(json.dumps(records))).violations == ()
        return Ran(verdict, records)

    return run
