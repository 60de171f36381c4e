"""Changes of variables: their causes, and the types of their values (7.3.6.1.2)."""

from __future__ import annotations

from seoro.lang.plan import FieldDeclaration
from seoro.runtime.accept.findings import Rule
from seoro.runtime.accept.fitting import fits
from seoro.runtime.accept.history import LoggedEvent, Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.world import Checker
from seoro.runtime.values.values import Actor, Struct, Variable, plain


class VariableChecker(Checker):
    """Check of changes of variables."""

    def check(self) -> None:
        """Check all changes."""
        for (number, name), changes in self.history.changes.items():
            holder = self.world.holder(number)
            if holder is None:
                continue  # reported while reading
            declared = self.world.declared(holder, name)
            for change in changes:
                self._check(holder, name, declared, change)

    def _check(
        self, holder: Instance | Struct | Actor, name: str, declared: FieldDeclaration | None, change: LoggedEvent
    ) -> None:
        seq = change.mark.seq
        if declared is None or not declared.is_variable:
            message = f"`{name}` changes, but is not a variable"
            self.findings.violate(Rule.VARIABLE, message, declared.span if declared is not None else None, seq)
            return
        with self.findings.undecided(Rule.VARIABLE, declared.span):
            value = self.world.decode(change.recorded.get("exact"))
            if not fits(value, declared.type):
                message = f"`{name}` takes the value {plain(value)!r}, which has another type"
                self.findings.violate(Rule.VARIABLE, message, declared.span, seq)
            node = self.history.nodes.get(change.recorded.get("by", -1))
            if node is None or node.start.seq > seq or node.end.t < change.mark.t:
                message = f"`{name}` changes at {change.mark.t:g} s, when its writer is not running"
                self.findings.violate(Rule.VARIABLE, message, declared.span, seq)
            elif not (self._is_given(holder, name, node) or self._is_sampled(holder, name)):
                message = f"`{name}` is changed by `{node.name}`, which does not have it as an argument"
                self.findings.violate(Rule.VARIABLE, message, declared.span, node.start.seq, seq)

    def _is_given(self, holder: Instance | Struct | Actor, name: str, node: Node) -> bool:
        """Whether an action has the variable as an argument."""
        instances = (self.world.instances.get(number) for number in node.owner.instances)
        values = (value for each in instances if each is not None for value in each.fields.values())
        return any(
            isinstance(value, Variable) and value.holder is holder and value.name == name for value in values
        )

    def _is_sampled(self, holder: Instance | Struct | Actor, name: str) -> bool:
        return any(sample.field == name for sample in self.world.samples_of(holder))
