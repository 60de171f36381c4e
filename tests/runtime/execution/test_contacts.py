from __future__ import annotations

from contextlib import ExitStack
from typing import Any, cast

import pytest

from seoro.runtime.contracts.backends import Backend
from seoro.runtime.execution.assignment import Home
from seoro.runtime.execution.contacts import Contacts


class Sensing:
    name = "a simulator"

    def senses_contacts(self, robot: str) -> bool:
        return robot != "old"


class Blind:
    name = "a bridge"


SIMULATOR, BRIDGE = cast("Backend", Sensing()), cast("Backend", Blind())
ROBOT, OTHER = Home(SIMULATOR, "robot"), Home(SIMULATOR, "other")


def contact(first: str, second: str, *strikers: str, **more: Any) -> dict[str, Any]:
    return {"first": first, "second": second, "time": 1.5, "strikers": strikers, **more}


@pytest.fixture
def warnings() -> list[str]:
    return []


@pytest.fixture
def unobserved() -> dict[str, None]:
    return {}


@pytest.fixture
def contacts(unobserved: dict[str, None], warnings: list[str]) -> Contacts:
    return Contacts(unobserved, warnings.append)


def guarded(contacts: Contacts, fields: dict[str, Any], *may_touch: str, home: Home = ROBOT) -> list[str]:
    found: list[str] = []
    with contacts.guard((0, 1), home, frozenset(may_touch), found.append):
        contacts.report(SIMULATOR, fields)
    contacts.report(SIMULATOR, fields)
    return found


def test_contacts_of_an_action_are_reported_while_it_runs(contacts: Contacts) -> None:
    fields = contact("box", "robot", "robot", position=(1.0, 2.0, 0.25))
    assert guarded(contacts, fields) == [
        "robot moved into 'box' at (1.000, 2.000, 0.250) m, 1.500 s after the start; `allow_contact` of `osc.sim` "
        "allows contacts"
    ]
    assert guarded(contacts, fields, "box") == []
    assert guarded(contacts, contact("box", "robot", "box")) == [], "it was struck"
    assert guarded(contacts, contact("box", "other", "other")) == [], "another robot"
    assert guarded(contacts, fields, home=Home(BRIDGE, "robot")) == [], "a robot of that name elsewhere"


def test_a_contact_without_a_known_cause_is_reported(contacts: Contacts) -> None:
    assert guarded(contacts, {"first": "box", "second": "robot", "time": 1.5})


def test_contacts_of_a_held_object_belong_to_the_robot(contacts: Contacts) -> None:
    [reason] = guarded(contacts, contact("cube", "post", "robot", held={"cube": "robot"}))
    assert "robot, which holds 'cube', moved into 'post'" in reason
    assert guarded(contacts, contact("cube", "robot", "robot", held={"cube": "robot"})) == []
    assert guarded(contacts, contact("cube", "post", held={"cube": "robot"})) == [], "it was set down"


def test_contacts_allowed_around_an_action_are_not_reported(contacts: Contacts) -> None:
    fields = contact("box", "robot", "robot")
    for position, allowed in (((), True), ((0,), True), ((0, 1), True), ((0, 2), False), ((0, 1, 3), False)):
        with contacts.allow(position, None, frozenset({"box"})):
            assert guarded(contacts, fields) == [] if allowed else guarded(contacts, fields), position
    with contacts.allow((), OTHER, None):
        assert guarded(contacts, fields)


def test_contacts_allowed_within_a_forbidding_block_are_not_reported(contacts: Contacts) -> None:
    fields, found = contact("box", "robot", "robot"), list[str]()
    with ExitStack() as stack:
        stack.enter_context(contacts.forbid((0,), (ROBOT, OTHER), found.append, also_struck=False))
        contacts.report(SIMULATOR, contact("box", "robot", "box"))
        assert found == []
        with contacts.allow((0, 1), None, frozenset({"box"})):
            contacts.report(SIMULATOR, fields)
        assert found == []
        with contacts.allow((1,), None, frozenset({"box"})):
            contacts.report(SIMULATOR, fields)
        assert len(found) == 1


def test_a_struck_robot_is_reported_on_request(contacts: Contacts) -> None:
    found = list[str]()
    with contacts.forbid((), (ROBOT,), found.append, also_struck=True):
        contacts.report(SIMULATOR, contact("box", "robot", "box"))
    assert "robot was struck by 'box'" in found[0]


@pytest.mark.parametrize("home", [Home(BRIDGE, "real"), Home(SIMULATOR, "old")])
def test_robots_without_contact_sensing_are_unobserved(
    contacts: Contacts, unobserved: dict[str, None], warnings: list[str], home: Home
) -> None:
    for _ in range(2):
        guarded(contacts, contact("box", "robot", "robot"), home=home)
    called = f"{home.name} of {home.backend.name}"
    assert list(unobserved) == [called]
    assert warnings == [f"contacts of {called} are not reported: its actions do not fail on contacts"]
