"""Values of parameters and variables: their types, arguments, constraints and changes.

Sections 7.6.2.2, 7.6.2.3 and 7.3.6.1.2. Overriding of defaults is not decided (7.3.11.3.2): a default that does
not hold is reported as unchecked.
"""

from __future__ import annotations

from collections.abc import Iterable

from seoro.lang import plan as plan_
from seoro.lang.plan import FieldDeclaration
from seoro.runtime.accept.findings import Rule
from seoro.runtime.accept.fitting import fits, is_plain_form, same
from seoro.runtime.accept.frames import Checker, Matched
from seoro.runtime.accept.history import LoggedEvent, Node
from seoro.runtime.accept.instances import Holder, Instance
from seoro.runtime.accept.layers import times_in
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Actor, Range, Struct, Value, Variable, plain


class ValueChecker(Checker):
    """Check of values of parameters."""

    def check(self, matched: Matched) -> None:
        """Check all parameters."""
        for plan, instance, around in matched.invocations:
            self._instance(instance)
            if plan is None:
                self._entry(instance)
            else:
                self._invoked(plan, instance, around)
        if matched.invocations:
            entry = matched.invocations[0][1]
            for holder, seq in self.world.recorded:
                self._object(holder, entry, seq)
        of_objects = [id(each) for type_ in self.world.plan.objects.values() for each in type_.modifiers]
        for application, modifier, node, environment in matched.modifiers:
            if id(application) in of_objects:
                reason = "the trace does not identify the struct or actor with these values"
                self.findings.skip(Rule.VALUE, reason, application.span)
            else:
                self._modifier(application, modifier, node, environment)

    # -------------------------------------------------------- instances

    def _instance(self, instance: Instance) -> None:
        """Check the types of an instance's values, and the constraints of its declaration."""
        structure = instance.declaration.structure
        place = instance.seq + 1
        if isinstance(instance.declaration, plan_.Scenario):
            self._types(structure, instance.fields, instance.seq)
        self._constraints(structure.members, instance.environment, place, instance.seq)

    def _entry(self, entry: Instance) -> None:
        """Check that the values of the run equal those of its start, and the parameters set by the user."""
        self._types(self.world.plan.globals, entry.fields, entry.seq)
        members: tuple[plan_.StructureMember, ...] = (*self.world.plan.globals.members, *self.world.plan.overrides)
        self._constraints(members, entry.environment, entry.seq + 1, entry.seq)
        recorded = self.history.run["parameters"]
        self.world.present.seq = entry.seq + 1
        values = dict(entry.fields.items())
        for name in sorted(recorded.keys() | values.keys()):
            if name not in recorded or name not in values or not is_plain_form(recorded[name], values[name]):
                message = f"`{name}` has another value in `run.start` than in the instance"
                self.findings.violate(Rule.VALUE, message, entry.declaration.span, 0, entry.seq)

    def _invoked(
        self, plan: plan_.InvokeScenario | plan_.InvokeAction, instance: Instance, around: Instance
    ) -> None:
        """Check the arguments and constraints of an invocation."""
        outside, seq = around.environment, instance.seq
        for name, expression in plan.arguments:
            self._equal(name, expression, outside, instance, seq)
        inside = outside.bind(it=instance)
        self._constraints(plan.constraints, inside, seq + 1, seq)
        given = {name for name, _ in plan.arguments}
        structure = instance.declaration.structure
        if structure.is_plain and not plan.constraints and not plan.modifications:
            for declared in structure.fields.values():
                if declared.name not in given and declared.default is not None:
                    self._equal(declared.name, declared.default, instance.environment, instance, seq)

    def _equal(
        self, name: str, expression: plan_.Expression, environment: Environment, instance: Instance, seq: int
    ) -> None:
        """Check that a field has the value of an expression."""
        with self.findings.undecided(Rule.VALUE, expression.span):
            expected = self.world.value(expression, environment, seq)
            self.world.present.seq = seq
            if name not in instance.fields or not same(instance.fields[name], expected):
                found = plain(instance.fields[name]) if name in instance.fields else "no value"
                message = f"`{name}` has the value {found!r}; expected {plain(expected)!r}"
                self.findings.violate(Rule.VALUE, message, expression.span, seq)

    # -------------------------------------------------------- structs, actors, modifiers

    def _object(self, holder: Struct | Actor, entry: Instance, seq: int) -> None:
        """Check the types of an object's fields, and its constraints."""
        structure = self.world.plan.structures.of(holder.type)
        environment = self.world.scope_of(holder, entry.environment)
        self._types(structure, holder.fields, seq)
        self._constraints(structure.members, environment, seq + 1, seq)
        for latent in structure.latents:
            if latent.type in holder.latent:
                self._constraints(latent.members, environment, seq + 1, seq)

    def _modifier(
        self, application: plan_.ModifierApplication, modifier: plan_.Modifier, node: Node, around: Environment
    ) -> None:
        """Check the arguments and constraints of a modifier."""
        with self.findings.undecided(Rule.VALUE, application.span, KeyError):
            fields = {name: self.world.decode(value) for name, value in node.arguments.items()}
            self._types(modifier.structure, fields, node.start.seq)
            owner = node.owner
            place = owner.recorded[0] + 1 if owner.recorded else owner.start.seq
            bindings = {name: value for name, value in around.bindings.items() if name == "it"}
            for name, expression in application.arguments:
                if not same(fields[name], self.world.value(expression, around, place)):
                    message = f"`{name}` differs from the argument of the modifier"
                    self.findings.violate(Rule.VALUE, message, expression.span, node.start.seq)
            for name, expression in application.ranges:
                bounds = self.world.value(expression, around, place)
                if isinstance(bounds, Range) and fields[name] not in bounds:
                    message = f"`{name}` is outside the range given to the modifier"
                    self.findings.violate(Rule.VALUE, message, expression.span, node.start.seq)
            if application.actor is not None:
                bindings["actor"] = self.world.value(application.actor, around, place)
            holder = Holder((plan_.modifier_type(modifier.name),), fields)
            inside = Environment(holder, self.world.plan, bindings, scenario=around.outermost)
            self._constraints(modifier.structure.members, inside, place, node.start.seq)

    # -------------------------------------------------------- rules

    def _types(self, structure: plan_.Structure, fields: dict[str, Value], seq: int) -> None:
        for name, declared in structure.fields.items():
            if name not in fields:
                self.findings.violate(Rule.VALUE, f"`{name}` has no value", declared.span, seq)
            elif not fits(value := dict.__getitem__(fields, name), declared.type):
                message = f"`{name}` has the value {plain(value)!r} of another type"
                self.findings.violate(Rule.VALUE, message, declared.span, seq)

    def _constraints(
        self, members: Iterable[plan_.StructureMember], environment: Environment, place: int, seq: int
    ) -> None:
        """Check that hard constraints hold, and defaults unless they may be overridden."""
        for member in members:
            # Constraints on times are checked where the behavior runs.
            if not isinstance(member, plan_.Constraint) or times_in(member.condition):
                continue
            span = member.span
            with self.findings.undecided(Rule.CONSTRAINT, span):
                if self.world.value(member.condition, environment, place):
                    continue
                if member.is_default:
                    reason = "it is not decided whether this default is overridden"
                    self.findings.skip(Rule.CONSTRAINT, reason, span)
                else:
                    message = f"`{' '.join(span.text.split())}` does not hold for the values of the trace"
                    self.findings.violate(Rule.CONSTRAINT, message, span, seq)


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
