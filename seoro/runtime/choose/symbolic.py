"""Expressions of the plan as terms of the solver, where they depend on values that are not chosen yet.

What is known already is computed; structs, lists and ranges are taken apart, so that terms are about scalars only.
What has no such form becomes an opaque term, evaluated like any expression once all that it names is known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import groupby
from typing import cast

from seoro.lang import solve
from seoro.lang.plan import (
    ActorType,
    Arithmetic,
    Binding,
    Bound,
    Bulk,
    Call,
    Cast,
    Compare,
    Concatenate,
    Conditional,
    Contains,
    Convert,
    Expression,
    External,
    Field,
    ForEach,
    Global,
    Index,
    Join,
    Labelled,
    ListOf,
    Literal,
    Logic,
    Member,
    Negate,
    Not,
    RangeOf,
    Self,
    Side,
    Size,
    StructType,
    TypeTest,
    Undefined,
    ValueType,
    parts,
)
from seoro.lang.solve import terms
from seoro.runtime.choose.chains import Operation, joined, junction, operated
from seoro.runtime.choose.forms import (
    NUMBERS,
    UNKNOWN,
    NotSymbolic,
    NotYet,
    Symbolic,
    SymbolicList,
    SymbolicRange,
    any_of,
    as_term,
    contains,
    converted,
    count_of,
    items_of,
    listed,
    ordered_range,
    same,
    with_operands,
)
from seoro.runtime.choose.opaque import Opaques
from seoro.runtime.choose.slots import Slot, Slots
from seoro.runtime.environment import Deferred, Environment, Evaluate, EvaluationError
from seoro.runtime.methods import MAX_DEPTH, implementation, inside
from seoro.runtime.values import Actor, HasFields, Struct, Value


class Translation:
    """Translates the expressions of one choice.

    Args:
        slots: The slots that get values; those of scalars have cells.
        evaluate: Evaluates expressions of which everything is known.
        put: Puts tentative values into the instances, for what is evaluated.
    """

    def __init__(
        self, slots: Slots, evaluate: Evaluate, put: Callable[[Mapping[solve.Cell, solve.Value]], None]
    ) -> None:
        self._slots = slots
        self._evaluate = evaluate
        self._open: list[Slot] = []
        self._opaques = Opaques(slots, evaluate, put, self._open)

    def condition(self, expression: Expression, environment: Environment) -> terms.Term:
        """A condition as a term.

        Raises:
            NotYet: It is about a subtype that a value may not be of.
        """
        return as_term(self._symbolic(expression, environment))

    def equality(self, slot: Slot, expression: Expression, environment: Environment) -> terms.Term:
        """That a slot holds the value of an expression, as a term."""
        return same(self._of_slot(slot), self._symbolic(expression, environment))

    # ------------------------------------------------------------ names

    def _field(self, holder: Symbolic, name: str) -> Symbolic:
        slot = self._slots.of(holder).get(name)
        if slot is not None:
            return self._of_slot(slot)
        if isinstance(holder, UNKNOWN):
            raise NotSymbolic
        if name not in cast(HasFields, holder).fields:
            raise NotYet(name)
        return cast(HasFields, holder).fields[name]

    def _of_slot(self, slot: Slot) -> Symbolic:
        if slot.is_given:
            return slot.holder.fields[slot.key]
        if slot.cell is not None:
            return terms.CellRef(slot.cell)
        if slot.made is not None:
            return slot.made
        if slot.definition is not None:
            return self._definition(slot)
        if "lower" in slot.parts:
            return SymbolicRange(self._of_slot(slot.parts["lower"]), self._of_slot(slot.parts["upper"]))
        if slot.size is not None or not slot.is_sized:
            raise NotYet(slot.path)
        return SymbolicList(tuple(self._of_slot(part) for part in slot.parts.values()))

    def _definition(self, slot: Slot) -> Symbolic:
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

    def _symbolic(self, expression: Expression, environment: Environment) -> Symbolic:
        if environment.depth > MAX_DEPTH:
            raise EvaluationError(f"methods call each other more than {MAX_DEPTH} deep", expression.span)
        try:
            return self._form(expression, environment)
        except NotSymbolic:
            return self._opaques.term(expression, environment)

    def _form(self, expression: Expression, environment: Environment) -> Symbolic:
        match expression:
            case Literal(value):
                return value
            case Field(name):
                return self._field(environment.instance, name)
            case Global(name):
                return self._field(environment.outermost, name)
            case Self():
                return environment.instance
            case Labelled():
                return self._evaluate(expression, environment)
            case Binding(name):
                bound = environment.bindings[name]
                if isinstance(bound, Deferred):
                    return self._symbolic(bound.expression, bound.environment)
                return bound
            case Member(base, name):
                return self._field(self._symbolic(base, environment), name)
            case Call():
                return self._call(expression, environment)
            case Arithmetic() | Concatenate() | Compare() | Logic():
                return self._chain(expression, environment)
            case Not() | Conditional() | Contains() | TypeTest():
                return self._truth(expression, environment)
            case ListOf(items):
                return listed(tuple(self._symbolic(item, environment) for item in items))
            case ForEach():
                return self._for_each(expression, environment)
            case _:
                return self._operation(expression, environment)

    def _operation(self, expression: Expression, environment: Environment) -> Symbolic:
        """What is computed from other values, in terms of them or, if they are all known, at once."""
        if isinstance(expression, Size) and (size := self._size(expression, environment)) is not None:
            return size
        found = [self._symbolic(part, environment) for part in parts(expression)]
        if isinstance(expression, Cast) and self._deciding(found[0], expression.type):
            raise NotYet(expression.span.text)
        if not any(isinstance(value, UNKNOWN) for value in found):
            return self._evaluate(with_operands(expression, found), environment)
        match expression, found:
            case Negate(number=number), [operand]:
                return terms.Negate(as_term(operand), NUMBERS[number])
            case Convert(number=number), [operand]:
                return converted(operand, number)
            case RangeOf(), [low, high]:
                return ordered_range(as_term(low), as_term(high))
            case Bound(side), [SymbolicRange(low, high)]:
                return low if side is Side.LOWER else high
            case Size(), [items]:
                return len(items_of(items))
            case Index(), [items, position]:
                return self._member(items_of(items), position, expression)
            case Join(), lists:
                return listed(tuple(item for each in lists for item in items_of(each)))
            case _:
                raise NotSymbolic

    # ------------------------------------------------------------ chains

    def _chain(self, expression: Operation, environment: Environment) -> Symbolic:
        """A chain of operators, from its left end: chains may be long, so they are no recursion."""
        chain = [expression]
        while isinstance(left := chain[-1].left, Operation):
            chain.append(left)
        found = self._symbolic(left, environment)
        for _, steps in groupby(reversed(chain), key=joined):
            run = list(steps)
            try:
                found = self._run(run, found, environment)
            except NotSymbolic:
                found = self._opaques.term(run[-1], environment)
        return found

    def _run(self, run: list[Operation], left: Symbolic, environment: Environment) -> Symbolic:
        """What operators in a row give whose left operand is known; they are one kind of `joined`."""
        last = run[-1]
        match last:
            case Logic("and" | "or" as operator):
                return self._junction(operator, [step.right for step in run], left, environment)
            case Logic(_, _, conclusion):
                if isinstance(left, bool):
                    return self._symbolic(conclusion, environment) if left else True
                return terms.Implies(as_term(left), as_term(self._symbolic(conclusion, environment)))
            case _:
                pass
        for step in run:
            right = self._symbolic(step.right, environment)
            if not isinstance(left, UNKNOWN) and not isinstance(right, UNKNOWN):
                left = self._evaluate(with_operands(step, [left, right]), environment)
            else:
                left = operated(step, left, right)
        return left

    def _junction(
        self, operator: str, operands: list[Expression], left: Symbolic, environment: Environment
    ) -> Symbolic:
        """`and` or `or` of a value and of what follows it, as far as what is known leaves that open."""
        decides = operator == "or"
        if left is decides:
            return left
        members = [left] if isinstance(left, UNKNOWN) else []
        for operand in operands:
            found = self._symbolic(operand, environment)
            if isinstance(found, UNKNOWN):
                members.append(found)
            elif found is decides and not members:
                return found
            elif found is decides:
                members.append(found)
                break  # what follows is not evaluated
        return junction(operator, members)

    # ------------------------------------------------------------ lists and methods

    def _size(self, expression: Size, environment: Environment) -> Symbolic | None:
        """The size of a list that is made here and has none yet."""
        slot = self._slots.find(expression.items, environment)
        return terms.CellRef(slot.size) if slot is not None and slot.size is not None else None

    def _member(self, items: tuple[Symbolic, ...], position: Symbolic, expression: Index) -> Symbolic:
        if not isinstance(position, int):
            raise NotSymbolic
        if not 0 <= position < len(items):
            raise EvaluationError(f"index {position} is outside of a list of {len(items)}", expression.span)
        return items[position]

    def _for_each(self, expression: ForEach, environment: Environment) -> Symbolic:
        items = items_of(self._symbolic(expression.items, environment))
        results: list[Symbolic] = []
        for item in items:
            within = replace(environment, bindings={**environment.bindings, "it": cast(Value, item)})
            results.append(self._symbolic(expression.body, within))
        match expression.operator:
            case Bulk.MAP:
                return listed(tuple(results))
            case Bulk.HAS:
                return any_of([as_term(result) for result in results])
            case Bulk.COUNT:
                return count_of([as_term(result) for result in results])
            case Bulk.FILTER if all(isinstance(result, bool) for result in results):
                return listed(tuple(item for item, result in zip(items, results, strict=True) if result))
            case Bulk.FIRST_INDEX if all(isinstance(result, bool) for result in results):
                return results.index(True) if True in results else -1
            case _:
                raise NotSymbolic

    def _call(self, expression: Call, environment: Environment) -> Symbolic:
        """A method with an expression is put in the place of its call; any other waits for its arguments."""
        receiver = expression.receiver
        holder = self._symbolic(receiver, environment) if receiver is not None else environment.instance
        if isinstance(holder, UNKNOWN):
            raise NotSymbolic
        holder = cast("Value | HasFields", holder)
        method = implementation(expression, holder)
        if isinstance(method.body, External | Undefined):
            raise NotSymbolic
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

    # ------------------------------------------------------------ truth

    def _truth(self, expression: Expression, environment: Environment) -> Symbolic:
        match expression:
            case Not(operand):
                truth = self._symbolic(operand, environment)
                return terms.Not(as_term(truth)) if isinstance(truth, UNKNOWN) else not truth
            case Conditional():
                return self._conditional(expression, environment)
            case Contains():
                one, other = (self._symbolic(part, environment) for part in parts(expression))
                if not isinstance(one, UNKNOWN) and not isinstance(other, UNKNOWN):
                    return self._evaluate(with_operands(expression, [one, other]), environment)
                return contains(one, other)
            case TypeTest(operand):
                return self._type_test(expression, self._symbolic(operand, environment), environment)
            case _:
                raise AssertionError("not a truth")

    def _conditional(self, expression: Conditional, environment: Environment) -> Symbolic:
        """`? :`, whose last branch may have many more in a row, as a table has."""
        rows: list[tuple[terms.Term, terms.Term]] = []
        last: Expression = expression
        while isinstance(last, Conditional):
            truth = self._symbolic(last.condition, environment)
            if isinstance(truth, bool):
                last = last.then if truth else last.otherwise
                continue
            rows.append((as_term(truth), as_term(self._symbolic(last.then, environment))))
            last = last.otherwise
        found = self._symbolic(last, environment)
        for condition, then in reversed(rows):
            found = terms.IfThenElse(condition, then, as_term(found))
        return found

    def _type_test(self, expression: TypeTest, operand: Symbolic, environment: Environment) -> Symbolic:
        """A value that is made here is of a conditional subtype if the fields that decide say so."""
        if conditions := self._deciding(operand, expression.type):
            return terms.And(conditions)
        if isinstance(operand, UNKNOWN):
            raise NotSymbolic
        return self._evaluate(with_operands(expression, [operand]), environment)

    def _deciding(self, value: Symbolic, type_: ValueType) -> tuple[terms.Term, ...]:
        """On what it depends whether a value turns out to be of a type; empty if that is known."""
        if not isinstance(value, Struct | Actor) or not isinstance(type_, StructType | ActorType):
            return ()
        return self.deciding(value, type_.name)

    def deciding(self, value: Struct | Actor, name: str) -> tuple[terms.Term, ...]:
        """On what it depends whether a value turns out to be of the type of that name; empty if that is known."""
        slot = self._slots.holding(value)
        if slot is None or slot.structure is None:
            return ()
        latents = {latent.type: latent for latent in slot.structure.latents}
        conditions: list[terms.Term] = []
        while name in latents and name not in value.types:
            latent = latents[name]
            conditions.append(same(self._field(value, latent.field), latent.value))
            name = latent.base
        return tuple(conditions) if name in value.types else ()
