"""Check that modifiers without `of` modify behaviors that have the parameters they use (7.3.12.1.2).

A modifier may use `it` in any of its members, and through modifiers that it applies. So uses and applications are
recorded during the check, and compared at its end.
"""

from __future__ import annotations

from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import modifiers as messages
from seoro.lang.source import Span
from seoro.lang.symbols import Kind, TypeSymbol


class Applications:
    """Uses of `it` in modifiers without `of`, and their applications."""

    def __init__(self) -> None:
        self.count = 0  # recorded uses and applications
        self._uses: dict[TypeSymbol, dict[str, Span]] = {}
        self._appliers: dict[TypeSymbol, list[TypeSymbol]] = {}  # modifiers without `of` that apply a modifier
        self._applied: dict[TypeSymbol, list[tuple[Span, str, frozenset[str]]]] = {}  # place, what and parameters

    def use(self, modifier: TypeSymbol, parameter: str, place: Span) -> None:
        """Record that a modifier uses a parameter of the modified behavior."""
        self.count += 1
        self._uses.setdefault(modifier, {}).setdefault(parameter, place)

    def apply(
        self, modifier: TypeSymbol, owner: TypeSymbol | None, place: Span, what: str, parameters: frozenset[str]
    ) -> None:
        """Record an application.

        Args:
            modifier: The applied modifier.
            owner: The type that contains the application.
            place: Span of the modifier's name.
            what: Description of the modified behavior, for messages.
            parameters: Parameters of `it` there.
        """
        self.count += 1
        if owner is not None and owner.kind is Kind.MODIFIER and owner.of is None:
            self._appliers.setdefault(modifier, []).append(owner)
        else:
            self._applied.setdefault(modifier, []).append((place, what, parameters))

    def check(self, bag: Bag) -> None:
        """Report applications to behaviors that lack a used parameter."""
        self._spread()
        for modifier, applications in self._applied.items():
            uses = self._uses.get(modifier, {})
            for place, what, parameters in applications:
                lacking = next((name for name in uses if name not in parameters), None)
                if lacking is not None:
                    bag.add(messages.lacks_parameter, place, modifier.name, lacking, what, uses[lacking])

    def _spread(self) -> None:
        """Propagate the uses of each modifier to the modifiers that apply it."""
        pending = [(modifier, *use) for modifier, uses in self._uses.items() for use in uses.items()]
        while pending:
            modifier, name, place = pending.pop()
            for applier in self._appliers.get(modifier, ()):
                if name not in self._uses.setdefault(applier, {}):
                    self._uses[applier][name] = place
                    pending.append((applier, name, place))
