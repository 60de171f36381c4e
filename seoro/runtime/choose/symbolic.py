"""Translation of expressions into terms of the solver, as far as they depend on unchosen values.

Known parts are computed; structs, lists and ranges are decomposed, so that terms contain scalars only. Other
expressions become opaque terms, evaluated when all values that they name are known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import groupby
from typing import cast

from seoro.lang import plan, solve
from seoro.lang.solve import terms
from seoro.runtime.choose import forms
from seoro.runtime.choose.opaque import Opaques
from seoro.runtime.choose.slots import Slot, Slots
from seoro.runtime.functions.methods import MAX_DEPTH, implementation, inside
from seoro.runtime.values.environment import Deferred, Environment, Evaluate, EvaluationError
from seoro.runtime.values.values import Actor, HasFields, Struct, Value


class Translation:
    """Translates expressions of one choice.

    Args:
        slots: Slots of the choice; those of scalars have cells.
        evaluate: Evaluates known expressions.
        put: Puts tentative values into the instances, for evaluation.
    """

    def __init__(
        self, slots: Slots, evaluate: Evaluate, put: Callable[[Mapping[solve.Cell, solve.Value]], None]
    ) -> None:
        self._slots = slots
        self._evaluate = evaluate
        self._open: list[Slot] = []
        self._opaques = Opaques(slots, evaluate, put, self._open)

    def condition(self, expression: plan.Expression, environment: Environment) -> terms.Term:
        """Return the term of a condition.

        Raises:
            NotYet: It is about a subtype that a value may not have.
        """
        return forms.as_term(self._symbolic(expression, environment))

    def equality(self, slot: Slot, expression: plan.Expression, environment: Environment) -> terms.Term:
        """Return the term of the equality of a slot and an expression."""
        return forms.same(self._of_slot(slot), self._symbolic(expression, environment))

    # ------------------------------------------------------------ names

    def _field(self, holder: forms.Symbolic, name: str) -> forms.Symbolic:
        slot = self._slots.of(holder).get(name)
        if slot is not None:
            return self._of_slot(slot)
        if isinstance(holder, forms.UNKNOWN):
            raise forms.NotSymbolic
        if name not in cast(HasFields, holder).fields:
            raise forms.NotYet(name)
        return cast(HasFields, holder).fields[name]

    def _of_slot(self, slot: Slot) -> forms.Symbolic:
        if slot.is_given:
            return slot.holder.fields[slot.key]
        if slot.cell is not None:
            return terms.CellRef(slot.cell)
        if slot.made is not None:
            return slot.made
        if slot.definition is not None:
            return self._definition(slot)
        if "lower" in slot.parts:
            return forms.SymbolicRange(self._of_slot(slot.parts["lower"]), self._of_slot(slot.parts["upper"]))
        if slot.size is not None or not slot.is_sized:
            raise forms.NotYet(slot.path)
        return forms.SymbolicList(tuple(self._of_slot(part) for part in slot.parts.values()))

    def _definition(self, slot: Slot) -> forms.Symbolic:
        rule = slot.definition
        assert rule is not None and rule.value is not None
        if slot in self._open:
            raise EvaluationError(f"the value of `{slot.path}` depends on itself", slot.span)
        self._open.append(slot)
        try:
            return self._symbolic(rule.value, rule.environment)
        finally:
            self._open.pop()

    # ------------------------------------------------------------ expressions

    def _symbolic(self, expression: plan.Expression, environment: Environment) -> forms.Symbolic:
        if environment.depth > MAX_DEPTH:
            raise EvaluationError(f"method calls are nested more than {MAX_DEPTH} deep", expression.span)
        try:
            return self._form(expression, environment)
        except forms.NotSymbolic:
            return self._opaques.term(expression, environment)

    def _form(self, expression: plan.Expression, environment: Environment) -> forms.Symbolic:
        match expression:
            case plan.Literal(value):
                return value
            case plan.Field(name):
                return self._field(environment.instance, name)
            case plan.Global(name):
                return self._field(environment.outermost, name)
            case plan.Self():
                return environment.instance
            case plan.Labelled():
                return self._evaluate(expression, environment)
            case plan.Binding(name):
                bound = environment.bindings[name]
                if isinstance(bound, Deferred):
                    return self._symbolic(bound.expression, bound.environment)
                return bound
            case plan.Member(base, name):
                return self._field(self._symbolic(base, environment), name)
            case plan.Call():
                return self._call(expression, environment)
            case plan.Arithmetic() | plan.Concatenate() | plan.Compare() | plan.Logic():
                return self._chain(expression, environment)
            case plan.Conditional():
                return self._conditional(expression, environment)
            case plan.ListOf(items):
                return forms.listed(tuple(self._symbolic(item, environment) for item in items))
            case plan.ForEach():
                return self._for_each(expression, environment)
            case _:
                return self._operation(expression, environment)

    def _operation(self, expression: plan.Expression, environment: Environment) -> forms.Symbolic:
        """Translate an operation, or compute it if all operands are known."""
        if isinstance(expression, plan.Size) and (size := self._size(expression, environment)) is not None:
            return size
        found = [self._symbolic(part, environment) for part in plan.parts(expression)]
        match expression:
            case plan.Cast(_, type_) if self._deciding_type(found[0], type_):
                raise forms.NotYet(expression.span.text)
            case plan.TypeTest(_, type_) if conditions := self._deciding_type(found[0], type_):
                return terms.And(conditions)
            case _:
                pass
        if not any(isinstance(value, forms.UNKNOWN) for value in found):
            return self._evaluate(forms.with_operands(expression, found), environment)
        match expression, found:
            case plan.Negate(number=number), [operand]:
                return terms.Negate(forms.as_term(operand), number)
            case plan.Not(), [operand]:
                return terms.Not(forms.as_term(operand))
            case plan.Contains(), [item, container]:
                return forms.contains(item, container)
            case plan.Convert(number=number), [operand]:
                return forms.converted(operand, number)
            case plan.RangeOf(), [low, high]:
                return forms.ordered_range(forms.as_term(low), forms.as_term(high))
            case plan.Bound(side), [forms.SymbolicRange(low, high)]:
                return low if side is plan.Side.LOWER else high
            case plan.Size(), [items]:
                return len(forms.items_of(items))
            case plan.Index(), [items, position]:
                return forms.member(forms.items_of(items), position, expression)
            case plan.Join(), lists:
                return forms.listed(tuple(item for each in lists for item in forms.items_of(each)))
            case _:
                raise forms.NotSymbolic

    # ------------------------------------------------------------ chains

    def _chain(self, expression: forms.Operation, environment: Environment) -> forms.Symbolic:
        """Translate a chain of operators from its left end, without recursion: chains may be long."""
        chain = [expression]
        while isinstance(left := chain[-1].left, forms.Operation):
            chain.append(left)
        found = self._symbolic(left, environment)
        for _, steps in groupby(reversed(chain), key=forms.joined):
            run = list(steps)
            try:
                found = self._run(run, found, environment)
            except forms.NotSymbolic:
                found = self._opaques.term(run[-1], environment)
        return found

    def _run(self, run: list[forms.Operation], left: forms.Symbolic, environment: Environment) -> forms.Symbolic:
        """Translate adjacent operators of one kind of `joined` with a known left operand."""
        last = run[-1]
        match last:
            case plan.Logic("and" | "or" as operator):
                return self._junction(operator, [step.right for step in run], left, environment)
            case plan.Logic(_, _, conclusion):
                if isinstance(left, bool):
                    return self._symbolic(conclusion, environment) if left else True
                return terms.Implies(forms.as_term(left), forms.as_term(self._symbolic(conclusion, environment)))
            case _:
                pass
        for step in run:
            right = self._symbolic(step.right, environment)
            if not isinstance(left, forms.UNKNOWN) and not isinstance(right, forms.UNKNOWN):
                left = self._evaluate(forms.with_operands(step, [left, right]), environment)
            else:
                left = forms.operated(step, left, right)
        return left

    def _junction(
        self, operator: str, operands: list[plan.Expression], left: forms.Symbolic, environment: Environment
    ) -> forms.Symbolic:
        """Combine a known left operand of `and` or `or` with the right one; skip that if the left one decides."""
        decides = operator == "or"
        if left is decides:
            return left
        members = [left] if isinstance(left, forms.UNKNOWN) else []
        for operand in operands:
            found = self._symbolic(operand, environment)
            if isinstance(found, forms.UNKNOWN):
                members.append(found)
            elif found is decides and not members:
                return found
            elif found is decides:
                members.append(found)
                break  # the rest is not evaluated
        return forms.junction(operator, members)

    # ------------------------------------------------------------ lists, methods and tables

    def _size(self, expression: plan.Size, environment: Environment) -> forms.Symbolic | None:
        """Return the size of a constructed list without a size yet."""
        slot = self._slots.find(expression.items, environment)
        return terms.CellRef(slot.size) if slot is not None and slot.size is not None else None

    def _for_each(self, expression: plan.ForEach, environment: Environment) -> forms.Symbolic:
        items = forms.items_of(self._symbolic(expression.items, environment))
        results: list[forms.Symbolic] = []
        for item in items:
            results.append(self._symbolic(expression.body, environment.bind(it=cast(Value, item))))
        return forms.gathered(expression.operator, items, results)

    def _call(self, expression: plan.Call, environment: Environment) -> forms.Symbolic:
        """Inline the expression of a method; other methods wait for their arguments."""
        receiver = expression.receiver
        holder = self._symbolic(receiver, environment) if receiver is not None else environment.instance
        if isinstance(holder, forms.UNKNOWN):
            raise forms.NotSymbolic
        holder = cast("Value | HasFields", holder)
        method = implementation(expression, holder, environment.plan.methods)
        if isinstance(method.body, plan.External | plan.Undefined):
            raise forms.NotSymbolic
        given = {name: self._symbolic(value, environment) for name, value in expression.arguments}
        within = inside(expression, holder, environment)
        bindings = dict(within.bindings)
        within = replace(within, bindings=bindings)
        for name, default in method.parameters:
            if name not in given:
                assert default is not None, "checked: it has a value or a default"
                given[name] = self._symbolic(default, within)
            bindings[name] = cast(Value, given[name])
        return self._symbolic(method.body, within)

    def _conditional(self, expression: plan.Conditional, environment: Environment) -> forms.Symbolic:
        """Translate `? :`, whose last branch may be a long chain, as in a table."""
        rows: list[tuple[terms.Term, terms.Term]] = []
        last: plan.Expression = expression
        while isinstance(last, plan.Conditional):
            truth = self._symbolic(last.condition, environment)
            if isinstance(truth, bool):
                last = last.then if truth else last.otherwise
                continue
            rows.append((forms.as_term(truth), forms.as_term(self._symbolic(last.then, environment))))
            last = last.otherwise
        found = self._symbolic(last, environment)
        for condition, then in reversed(rows):
            found = terms.IfThenElse(condition, then, forms.as_term(found))
        return found

    # ------------------------------------------------------------ conditional subtypes (7.3.8.2.5)

    def _deciding_type(self, value: forms.Symbolic, type_: plan.ValueType) -> tuple[terms.Term, ...]:
        """Return the conditions for a value to be of a type; empty if decided."""
        if not isinstance(value, Struct | Actor) or not isinstance(type_, plan.StructType | plan.ActorType):
            return ()
        return self.deciding(value, type_.name)

    def deciding(self, value: Struct | Actor, name: str) -> tuple[terms.Term, ...]:
        """Return the conditions for a value to be of a named type; empty if decided."""
        slot = self._slots.holding(value)
        if slot is None or slot.structure is None:
            return ()
        latents = {latent.type: latent for latent in slot.structure.latents}
        conditions: list[terms.Term] = []
        while name in latents and name not in value.types:
            latent = latents[name]
            conditions.append(forms.same(self._field(value, latent.field), latent.value))
            name = latent.base
        return tuple(conditions) if name in value.types else ()
