"""Traces of scenarios, original and edited."""

import json
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from seoro.embed import Scenario, accept, load, prepare
from seoro.embed.options import Options
from seoro.runtime.accept import Acceptance
from seoro.runtime.functions.actions import ActionFunction
from seoro.runtime.functions.modifiers import ModifierFunction

HEADER = "import osc.types\nimport osc.helpers\n\n"
Record = dict[str, Any]


@dataclass
class Traced:
    """A scenario and an editable trace of its run."""

    scenario: Scenario
    records: list[Record] = field(default_factory=list)

    def accept(self) -> Acceptance:
        return accept(self.scenario, json.loads(json.dumps(self.records)))

    @property
    def broken(self) -> set[str]:
        """Rules that the trace breaks."""
        return {violation.rule.title for violation in self.accept().violations}

    @property
    def messages(self) -> str:
        return "\n".join(violation.message for violation in self.accept().violations)

    def copy(self) -> "Traced":
        return Traced(self.scenario, [dict(record) for record in self.records])

    # -------------------------------------------------------- finding and editing

    def find(self, kind: str, number: int = 0, **fields: Any) -> Record:
        """Return a record by kind, fields and number among the matches."""
        return [r for r in self.records if r["kind"] == kind and fields.items() <= r.items()][number]

    def start(self, name: str, number: int = 0) -> Record:
        return self.find("behavior.start", number, name=name)

    def end(self, name: str, number: int = 0) -> Record:
        return self.find("behavior.end", id=self.start(name, number)["id"])

    def drop(self, *records: Record) -> None:
        """Remove records, and close the gap in their numbers."""
        self.records = [record for record in self.records if not any(record is other for other in records)]
        self.number()

    def drop_behavior(self, name: str, number: int = 0) -> None:
        """Remove all records of a behavior."""
        numbers = {self.start(name, number)["id"]}
        for record in self.records:
            if record["kind"] == "behavior.start" and record["parent"] in numbers:
                numbers.add(record["id"])
        mine = [r for r in self.records if {r.get("id"), r.get("behavior"), r.get("modifier")} & numbers]
        self.drop(*mine)

    def insert(self, after: Record, **fields: Any) -> None:
        """Insert a record after another, at its time."""
        position = next(index for index, record in enumerate(self.records) if record is after)
        self.records.insert(position + 1, {"seq": 0, "t": after["t"], **fields})
        self.number()

    def move(self, record: Record, after: Record) -> None:
        """Move a record after another, at its time."""
        self.records = [other for other in self.records if other is not record]
        position = next(index for index, other in enumerate(self.records) if other is after)
        record["t"] = after["t"]
        self.records.insert(position + 1, record)
        self.number()

    def rewrite(self, value: Any, number: int = 0, **fields: Any) -> None:
        """Replace the value of a variable, in both forms."""
        self.find("variable", number, **fields).update(value=value, exact=value)

    def shift(self, first: Record, by: float) -> None:
        """Delay a record and all later ones by some seconds."""
        for record in self.records[first["seq"] :]:
            record["t"] += by
            if "duration" in record:
                record["duration"] += by

    def number(self) -> None:
        """Number the records anew, and drop their causes, which have other numbers then."""
        for seq, record in enumerate(self.records):
            record["seq"] = seq
            record.pop("cause", None)


TraceText = Callable[..., Awaitable[Traced]]


@pytest.fixture
def trace_text(tmp_path: Path) -> TraceText:
    """Return a function that runs the text of a scenario on the virtual clock, and returns its trace."""

    async def trace(
        text: str, seed: int = 0, actions: Sequence[ActionFunction | ModifierFunction] = (), **options: Any
    ) -> Traced:
        path = tmp_path / "test.osc"
        path.write_text(HEADER + text)
        module = ModuleType("actions_of_a_test")
        vars(module).update({function.__name__: function for function in actions})
        scenario = load(path, modules=[module])
        async with prepare(scenario, Options(seed=seed, clock="virtual", **options)) as run, run.running():
            return Traced(scenario, [dict(record) async for record in run.trace()])

    return trace
