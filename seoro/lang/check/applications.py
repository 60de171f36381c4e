"""Whether modifiers without `of` are applied to behaviors that have the parameters they use (7.3.12.1.2).

What a modifier uses of `it` is known when everything is checked: it may stand in any of its members, and in those
of modifiers that it applies itself. So uses and applications are noted as they come, and compared in the end.
"""

from __future__ import annotations

from typing import NamedTuple

from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import modifiers as messages
from seoro.lang.source import Span
from seoro.lang.symbols import Kind, TypeSymbol


class _Application(NamedTuple):
    """An application of a modifier; `what` it is applied to has these parameters."""

    place: Span
    what: str
    parameters: frozenset[str]


class Applications:
    """Uses of `it` in modifiers without `of`, and their applications."""

    def __init__(self) -> None:
        self.count = 0  # of uses and applications that were noted
        self._uses: dict[TypeSymbol, dict[str, Span]] = {}
        self._appliers: dict[TypeSymbol, list[TypeSymbol]] = {}  # modifiers without `of` that apply a modifier
        self._applied: dict[TypeSymbol, list[_Application]] = {}

    def use(self, modifier: TypeSymbol, parameter: str, place: Span) -> None:
        """Note that a modifier uses a parameter of what it modifies."""
        self.count += 1
        self._uses.setdefault(modifier, {}).setdefault(parameter, place)

    def apply(
        self, modifier: TypeSymbol, owner: TypeSymbol | None, place: Span, what: str, parameters: frozenset[str]
    ) -> None:
        """Note an application.

        Args:
            modifier: What is applied.
            owner: The type in which the application stands.
            place: The name of the modifier there.
            what: What it is applied to, for messages.
            parameters: What `it` has there.
        """
        self.count += 1
        if owner is not None and owner.kind is Kind.MODIFIER and owner.of is None:
            self._appliers.setdefault(modifier, []).append(owner)
        else:
            self._applied.setdefault(modifier, []).append(_Application(place, what, parameters))

    def check(self, bag: Bag) -> None:
        """Report applications to what lacks a parameter that the modifier uses."""
        self._spread()
        for modifier, applications in self._applied.items():
            uses = self._uses.get(modifier, {})
            for place, what, parameters in applications:
                lacking = next((name for name in uses if name not in parameters), None)
                if lacking is not None:
                    bag.add(messages.LacksParameter(place, modifier.name, lacking, what, uses[lacking]))

    def _spread(self) -> None:
        """Give the uses of each modifier to those that apply it."""
        pending = [(modifier, *use) for modifier, uses in self._uses.items() for use in uses.items()]
        while pending:
            modifier, name, place = pending.pop()
            for applier in self._appliers.get(modifier, ()):
                if name not in self._uses.setdefault(applier, {}):
                    self._uses[applier][name] = place
                    pending.append((applier, name, place))
