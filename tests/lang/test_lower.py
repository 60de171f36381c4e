"""Lowering: the plan of a scenario."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from seoro.errors import InvalidScenario
from seoro.lang import frontend, plan
from seoro.lang.arithmetic import Number
from tests.lang.helpers import check, lower

NAVIGATION = """
import osc.ros
import osc.gazebo

scenario errand:
    robot: differential_drive_robot
    box: sim_object
    do parallel:
        serial:
            robot.init_nav2(pose_3d(position_3d(x: 0.0m, y: 0.0m)))
            parallel:
                robot.nav_to_pose(pose_3d(position_3d(x: 3.0m, y: -3.0m)))
                box.spawn(spawn_pose: pose_3d(orientation: orientation_3d(yaw: 90deg)), model: 'box.sdf')
            emit end
        time_out: serial:
            wait elapsed(120s)
            emit fail
"""

BASICS = """
import osc.helpers

scenario greet:
    name: string
    times: int = 2
    event done(count: int, note: string = "n")
    do serial:
        log(name)
        emit done(times)

scenario main:
    event go
    do serial:
        a: greet("bob")
        one_of:
            wait elapsed([1s..2s])
            wait @go
            wait @a.end
        emit go
"""


def walk(behavior: plan.Behavior | None) -> Iterator[plan.Behavior]:
    """Yield a behavior and its descendants in source order."""
    if behavior is not None:
        yield behavior
        if isinstance(behavior, plan.Serial | plan.Parallel | plan.OneOf):
            for member in behavior.members:
                yield from walk(member)


def literal(expression: plan.Expression | None) -> object:
    assert isinstance(expression, plan.Literal)
    return expression.value


def given(construct: plan.Expression | None) -> dict[str, plan.Expression]:
    assert isinstance(construct, plan.Construct)
    return dict(construct.arguments)


def defaults(made: plan.Plan, scenario: str = "main") -> dict[str, plan.Expression | None]:
    """Return the default values of the parameters of a scenario."""
    return {name: field.default for name, field in made.scenarios[scenario].structure.fields.items()}


def value(text: str, folder: Path) -> plan.Expression | None:
    """Return the default value of the first parameter of a scenario."""
    return next(iter(defaults(lower(folder, text)).values()))


def test_a_navigation_scenario_is_lowered(tmp_path: Path) -> None:
    made = lower(tmp_path, NAVIGATION)
    assert made.entry == "errand"
    robot, box = made.scenarios["errand"].structure.fields.values()
    assert robot.type == plan.ActorType("differential_drive_robot", ("robot", "osc_actor"), ("namespace",))
    assert box.type == plan.ActorType("sim_object", ("osc_actor",), ())
    assert robot.default is None and isinstance(robot.type, plan.ActorType)
    assert literal(made.structures.of(robot.type).fields["namespace"].default) == ""
    assert {name: action.library for name, action in made.actions.items()} == {
        "differential_drive_robot.init_nav2": "osc.nav2",
        "differential_drive_robot.nav_to_pose": "osc.nav2",
        "osc_actor.spawn": "osc.gazebo",
    }
    words = [type(behavior).__name__ for behavior in walk(made.scenarios["errand"].body)]
    assert words == [
        *("Parallel", "Serial", "InvokeAction", "Parallel", "InvokeAction", "InvokeAction", "Emit"),
        *("Serial", "Wait", "Emit"),
    ]


def test_arguments_of_an_action_are_in_the_order_of_its_parameters(tmp_path: Path) -> None:
    made = lower(tmp_path, NAVIGATION)
    spawn = [found for found in walk(made.scenarios["errand"].body) if isinstance(found, plan.InvokeAction)][2]
    assert [name for name, _ in spawn.arguments] == ["spawn_pose", "model"]
    fields = made.actions[spawn.action].structure.fields
    assert list(fields) == ["spawn_pose", "model", "world_name", "xacro_arguments"]
    assert literal(fields["world_name"].default) == "default"
    assert isinstance(spawn.actor, plan.Field) and spawn.actor.name == "box"
    pose = given(dict(spawn.arguments)["spawn_pose"])
    assert literal(given(pose["orientation"])["yaw"]) == pytest.approx(1.5707963268)


def test_scenarios_events_and_labels_are_lowered(tmp_path: Path) -> None:
    made = lower(tmp_path, BASICS)
    assert made.entry == "main"
    assert list(made.scenarios) == ["main", "greet"]
    greet = made.scenarios["greet"]
    assert [(name, default is None) for name, default in defaults(made, "greet").items()] == [
        ("name", True),
        ("times", False),
    ]
    [done] = greet.events
    assert (done.name, [name for name, _ in done.parameters]) == ("done", ["count", "note"])
    behaviors = list(walk(made.scenarios["main"].body))
    invoked = behaviors[1]
    assert isinstance(invoked, plan.InvokeScenario)
    assert (invoked.label, invoked.scenario, [name for name, _ in invoked.arguments]) == ("a", "greet", ["name"])
    waits = [found.event for found in behaviors if isinstance(found, plan.Wait)]
    assert isinstance(waits[0], plan.Elapsed) and isinstance(waits[0].duration, plan.RangeOf)
    assert isinstance(waits[1], plan.OnEvent) and isinstance(waits[1].event, plan.DeclaredEvent)
    assert isinstance(waits[2], plan.OnEvent) and isinstance(waits[2].event, plan.PhaseEvent)
    assert (waits[2].event.label, waits[2].event.phase) == ("a", plan.Phase.END)
    emitted = next(found for found in walk(greet.body) if isinstance(found, plan.Emit))
    assert [name for name, _ in emitted.arguments] == ["count"]
    assert list(done.all_arguments(emitted.arguments)) == ["note", "count"]


def test_event_objects_are_bound_in_conditions(tmp_path: Path) -> None:
    text = "scenario main:\n    event go(n: int)\n    do wait @go as g if g.n > 2\n"
    body = lower(tmp_path, text).scenarios["main"].body
    assert isinstance(body, plan.Wait) and isinstance(body.event, plan.OnEvent)
    assert body.event.name == "g"
    assert isinstance(body.event.condition, plan.Holds)
    condition = body.event.condition.condition
    assert isinstance(condition, plan.Compare)
    assert isinstance(condition.left, plan.Member) and isinstance(condition.left.base, plan.Binding)


def test_a_scenario_of_an_actor_knows_its_actor(tmp_path: Path) -> None:
    text = """
import osc.helpers

actor cat:
    name: string = "tom"

actor kitten inherits cat

scenario cat.greet:
    other: cat
    do log(actor.name)

scenario cat.greet_twice:
    do greet()

scenario main:
    k: kitten
    do k.greet_twice()
"""
    made = lower(tmp_path, text)
    outer, inner = made.scenarios["main"].body, made.scenarios["cat.greet_twice"].body
    assert isinstance(outer, plan.InvokeScenario) and isinstance(outer.actor, plan.Field)
    assert isinstance(inner, plan.InvokeScenario) and isinstance(inner.actor, plan.Binding)
    other = made.scenarios["cat.greet"].structure.fields["other"]
    assert isinstance(other.type, plan.ActorType) and other.type.name == "cat"


def test_a_scenario_inherits_members(tmp_path: Path) -> None:
    text = """
scenario base:
    n: int = 1
    event go
    do emit go

scenario main inherits base:
    m: int = n + 1
"""
    made = lower(tmp_path, text, scenario="main").scenarios["main"]
    assert list(made.structure.fields) == ["n", "m"]
    assert [event.name for event in made.events] == ["go"]
    assert isinstance(made.body, plan.Emit)


def test_an_action_with_a_behavior_is_a_scenario(tmp_path: Path) -> None:
    text = "import osc.helpers\naction greet:\n    n: int = 1\n    do log('x')\nscenario main:\n    do greet()\n"
    made = lower(tmp_path, text)
    assert list(made.scenarios) == ["main", "greet"]
    assert list(made.actions) == ["log"]


# ---------------------------------------------------------------- values


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("length = 15kph * 3.6s", None),
        ("length = -2km", -2000.0),
        ("length = 5", 5.0),
        ("temperature = -5celsius", 268.15),
        ("float = 3", 3.0),
        ("int = 3", 3),
        ("string = 'a'", "a"),
    ],
)
def test_literals_are_in_si_units_and_of_their_type(text: str, expected: object, tmp_path: Path) -> None:
    found = value(f"import osc.types\nscenario main:\n    x: {text}\n    do emit end\n", tmp_path)
    if expected is None:
        assert isinstance(found, plan.Arithmetic) and found.number is Number.FLOAT
    else:
        assert isinstance(found, plan.Literal)
        assert found.value == expected and type(found.value) is type(expected)


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("7 / 2", "uint"),
        ("7 / a", "int"),
        ("7 / 2.0", "float"),
        ("b / 2", "uint"),
        ("a / b", "int"),
        ("a * 1m", "float"),
    ],
)
def test_arithmetic_has_the_type_of_its_operands(text: str, number: str, tmp_path: Path) -> None:
    fields = "    a: int = 1\n    b: uint = 1\n    c: bool = (X == X)\n"
    source = f"import osc.types\nscenario main:\n{fields}    do emit end\n"
    made = defaults(lower(tmp_path, source.replace("X", text)))["c"]
    assert isinstance(made, plan.Compare) and isinstance(made.left, plan.Arithmetic)
    assert made.left.number.value == number


def test_literals_of_an_int_may_be_subtracted_below_zero(tmp_path: Path) -> None:
    found = value("scenario main:\n    x: int = 2 - 3\n    do emit end\n", tmp_path)
    assert isinstance(found, plan.Arithmetic) and found.number is Number.INT


def test_integers_are_converted_to_expected_floats(tmp_path: Path) -> None:
    fields = "    x: float = n\n    y: list of float = [n, 2]\n    z: range of float = [n..2]\n"
    text = f"scenario main:\n    n: int = 1\n{fields}"
    parameters = defaults(lower(tmp_path, text))
    assert isinstance(parameters["x"], plan.Convert)
    items, window = parameters["y"], parameters["z"]
    assert isinstance(items, plan.ListOf)
    assert isinstance(items.items[0], plan.Convert) and literal(items.items[1]) == 2.0
    assert isinstance(window, plan.RangeOf) and isinstance(window.low, plan.Convert)


def test_members_of_enumerations_have_the_expected_type(tmp_path: Path) -> None:
    text = """
enum ink: [cyan = 1, black, grey = black]
enum rgb: [red, black]

scenario main:
    a: ink = black
    b: rgb = black
    c: bool = (a == black)
    d: bool = a in [cyan, black]
    e: ink = true ? grey : rgb!black == b ? cyan : black
"""
    found = defaults(lower(tmp_path, text))
    assert literal(found["a"]) == plan.EnumValue("ink", "black", 2)
    assert literal(found["b"]) == plan.EnumValue("rgb", "black", 1)
    assert isinstance(found["c"], plan.Compare)
    assert literal(found["c"].right) == plan.EnumValue("ink", "grey", 2)
    assert isinstance(found["d"], plan.Contains)
    assert isinstance(found["e"], plan.Conditional)


# ---------------------------------------------------------------- entry and overrides


@pytest.mark.parametrize(
    ("text", "scenario", "expected"),
    [
        ("scenario only", None, "only"),
        ("scenario a\nscenario main", None, "main"),
        ("scenario a\nscenario main", "a", "a"),
        ("scenario a\nscenario b", None, "E0421"),
        ("scenario a", "b", "E0422"),
        ("struct main", None, "E0420"),
        ("actor c\nscenario c.a", None, "E0423"),
    ],
)
def test_the_entry_scenario_is_chosen_or_an_error(
    text: str, scenario: str | None, expected: str, tmp_path: Path
) -> None:
    checked = check(tmp_path, text + "\n")
    if not expected.startswith("E"):
        assert frontend.lower(checked, scenario).entry == expected
    else:
        with pytest.raises(InvalidScenario) as caught:
            frontend.lower(checked, scenario)
        assert [found.code for found in caught.value.diagnostics] == [expected]


OVERRIDDEN = """
import osc.ros

scenario main:
    robot: differential_drive_robot
    goal: pose_3d = pose_3d(position_3d(x: 1m, y: 2m))
    speed: speed = 1mps
    other: pose_3d = goal
    do robot.nav_to_pose(goal)
"""


def test_an_override_gives_a_missing_value(tmp_path: Path) -> None:
    text = "scenario main:\n    n: int\n    do emit end\n"
    assert [found.span.text for found in lower(tmp_path, text, {"n": "3"}).overrides] == ["n=3"]
    with pytest.raises(InvalidScenario, match="'n' has no value: give it a default or an override"):
        lower(tmp_path, text)


def test_missing_values_of_an_actor_are_listed(tmp_path: Path) -> None:
    text = "import osc.moveit2\nscenario main:\n    a: arm\n    do emit end\n"
    names = ("arm_group", "gripper_group", "end_effector", "base_link")
    with pytest.raises(InvalidScenario, match=r"'a\.arm_group' has no value"):
        lower(tmp_path, text)
    made = lower(tmp_path, text, {f"a.{name}": "'x'" for name in names})
    assert len(made.overrides) == len(names)


@pytest.mark.parametrize(
    ("path", "text", "message"),
    [
        ("gaol", "3", "did you mean `goal`"),
        ("goal.position.w", "3", "unknown parameter `w`"),
        ("speed.x", "3", "has no field `x`"),
        ("speed", "3s", "expected `speed`"),
        ("speed", "'fast'", "expected `speed`"),
        ("speed", "3mps +", "unexpected end of the line"),
        ("speed", "3 4", "unexpected"),
    ],
)
def test_wrong_overrides_are_refused(path: str, text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidScenario, match=message) as caught:
        lower(tmp_path, OVERRIDDEN, {path: text})
    assert caught.value.diagnostics[0].primary.span.file.text == f"{path}={text}"


INVOKING = """
import osc.helpers

scenario greet:
    name: string = "you"
    times: int = 1

scenario main:
    do serial:
        greet()
        parallel:
            last: greet()
            greet()
        log("end")
"""


def test_parameters_of_invocations_are_given_by_label_or_name(tmp_path: Path) -> None:
    overrides = {"greet[1].times": "2", "last.name": "'me'", "log.msg": "'bye'"}
    made = lower(tmp_path, INVOKING, overrides, "main")
    assert not made.overrides
    given = {
        (behavior.label, constraint.condition.span.text)
        for behavior in walk(made.scenarios["main"].body)
        if isinstance(behavior, plan.InvokeAction | plan.InvokeScenario)
        for constraint in behavior.constraints
        if isinstance(constraint, plan.Constraint)
    }
    assert given == {(None, "greet[1].times=2"), ("last", "last.name='me'"), (None, "log.msg='bye'")}


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("last", "it is an invocation"),
        ("last.nam", "did you mean `name`"),
        ("greet.name", r"did you mean `greet\[[01]\]`"),
        ("greet[2].name", "unknown"),
        ("log.msg.x", "has no field `x`"),
    ],
)
def test_wrong_overrides_of_invocations_are_refused(path: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidScenario, match=message):
        lower(tmp_path, INVOKING, {path: "1"}, "main")


def test_constraints_from_outside_come_last(tmp_path: Path) -> None:
    text = "scenario main:\n    n: int\n    m: int = 2\n    do emit end\n"
    made = lower(tmp_path, text, {"m": "3"}, constraints=["n in [1..5]", "n < m and m > 1"])
    assert [found.span.text for found in made.overrides] == ["m=3", "n in [1..5]", "n < m and m > 1"]


def test_a_constraint_from_outside_may_be_about_an_invocation(tmp_path: Path) -> None:
    constraints = ["greet[1].times in [1..3]", "last.name in ['a', 'b'] or not (last.times * 2 > 4)"]
    made = lower(tmp_path, INVOKING, {"greet[1].name": "'x'"}, "main", constraints)
    assert not made.overrides
    given = [
        [constraint.span.text for constraint in behavior.constraints]
        for behavior in walk(made.scenarios["main"].body)
        if isinstance(behavior, plan.InvokeScenario)
    ]
    assert given == [[], [constraints[1]], ["greet[1].name='x'", constraints[0]]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gaol.position.x > 1m", "did you mean `goal`"),
        ("speed in [1m..2m]", "cannot be compared by `in`"),
        ("speed", "expected `bool`"),
        ("speed in [1mps", "`\\[` is not closed"),
        ("other", "expected `bool`"),
    ],
)
def test_wrong_constraints_from_outside_are_refused(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidScenario, match=message) as caught:
        lower(tmp_path, OVERRIDDEN, constraints=[text])
    assert caught.value.diagnostics[0].primary.span.file.text == text


def test_a_scenario_with_errors_is_not_lowered(tmp_path: Path) -> None:
    with pytest.raises(InvalidScenario, match="E0301"):
        lower(tmp_path, "scenario main:\n    n: int = 1.5\n")
