"""Scenario file that invokes the scenario of a RoboVAST file with parameters that vary as numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.campaign.vast.values import Range
from seoro.lang.frozen import Value

TEXT = """
struct text:
    def of_float(value: float) -> string is external builtins.str()
    def of_int(value: int) -> string is external builtins.str()
"""


class Wrapper(Value):
    """Scenario around another one.

    Args:
        name: Its name.
        scenario: Name of the invoked scenario.
        file: Its file, relative to the file of the wrapper.
        ranges: Values of its own parameters, by name.
        missing: Types of parameters that have no value yet, by name.
        given: Values of other parameters of the invoked scenario, in the notation of scenarios.
        types: Types of the parameters of the invoked scenario.
    """

    name: str
    scenario: str
    file: str
    ranges: Mapping[str, Range]
    missing: Mapping[str, str]
    given: Mapping[str, str]
    types: Mapping[str, str]

    def source(self, comments: Sequence[str]) -> str:
        """Return the text of the file.

        Args:
            comments: Lines of a comment, without `#`.
        """
        lines = [*(f"# {line}" for line in comments), "", f'import "{self.file}"', TEXT, f"scenario {self.name}:"]
        for name, found in self.ranges.items():
            lines += [f"    {name}: {found.type_name}", f"    keep({name} in {found.container})"]
        for name, type_name in self.missing.items():
            lines += [f"    {name}: {type_name}", f"    # missing: keep({name} == EXPRESSION)"]
        arguments = [f"{name}: {self._passed(name)}" for name in self.types if self._passed(name)]
        lines.append(f"    do {self.scenario}({', '.join(arguments)})")
        return "\n".join(lines) + "\n"

    def _passed(self, name: str) -> str:
        if name in self.given:
            return self.given[name]
        own = self.ranges[name].type_name if name in self.ranges else self.missing.get(name)
        if own is None:
            return ""
        return f"text.of_{own}({name})" if self.types[name] == "string" and own in ("float", "int") else name
