"""Actions of `osc.ros` on a robot that talks DDS, behind a stand-in for its bridge."""

import struct
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh
from zenoh.handlers import Callback

from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import ran_of, running
from tests.bridges.ros2.fake_bridge import HEADER, FakeBridge
from tests.runtime.conftest import Ran

ADD = "example_interfaces/srv/AddTwoInts"
FIBONACCI = "example_interfaces/action/Fibonacci"
LATCHED = "qos_preset_profiles!system_default_transient_local"
ACCEPTED = HEADER + struct.pack("<?3xiI", True, 0, 0)


class BridgeWithAction(FakeBridge):
    """A bridge before a robot that has the action /fibonacci, too: one that ends at once, with status 4 or 6."""

    def __init__(self, endpoint: str) -> None:
        super().__init__(endpoint)
        self.order = 0
        self._kept.append(self._token("AS/fibonacci/example_interfaces§action§Fibonacci"))
        for name, respond in (("send_goal", self._send), ("get_result", self._result), ("cancel_goal", None)):
            key = f"fibonacci/_action/{name}"

            def take(query: zenoh.Query, key: str = key, respond=respond) -> None:  # type: ignore[no-untyped-def]
                with query:
                    assert query.payload is not None
                    query.reply(key, respond(query.payload.to_bytes()))

            self._kept.append(self._zenoh.declare_queryable(key, Callback(take, indirect=False)))

    def _send(self, payload: bytes) -> bytes:
        (self.order,) = struct.unpack("<i", payload[20:])
        return ACCEPTED

    def _result(self, payload: bytes) -> bytes:
        assert len(payload) == 20
        return HEADER + struct.pack("<b3xI2i", 4 if self.order < 7 else 6, 2, 0, 1)


@pytest.fixture
def bridge(tmp_path: Path) -> Iterator[tuple[BridgeWithAction, str]]:
    endpoint = f"unixsock-stream/{tmp_path}/bridge.sock"
    bridge = BridgeWithAction(endpoint)
    yield bridge, endpoint
    bridge.close()


async def run(folder: Path, endpoint: str, text: str) -> Ran:
    async with running(folder, endpoint, text, dialect=None) as started:
        return await ran_of(started)


async def test_topics_services_and_actions_are_used(tmp_path: Path, bridge: tuple[BridgeWithAction, str]) -> None:
    robot, endpoint = bridge
    robot.robot_latches("cellar")
    ran = await run(
        tmp_path,
        endpoint,
        f"""
scenario main:
    var sum: int = 0
    do serial:
        wait_for_topics(["/cmd_vel", "/chatter"])
        check_data("/map_name", "std_msgs/msg/String", "cellar", member_name: "data", qos_profile: {LATCHED})
        service_call("/add", "{ADD}", "{{a: 2, b: 3}}", response_variable: sum, response_member_name: "sum")
        compare(sum, "==", 5)
        topic_publish("/cmd_vel", "geometry_msgs/msg/Twist", "{{linear: {{x: 0.5}}}}")
        action_call("/fibonacci", "{FIBONACCI}", "{{order: 2}}")
""",
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert robot.order == 2
    [(payload, _)] = robot.arrived
    assert payload == HEADER + struct.pack("<6d", 0.5, 0, 0, 0, 0, 0)


@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        (f'action_call("/fibonacci", "{FIBONACCI}", "{{order: 9}}")', "the goal of /fibonacci was aborted"),
        (
            'wait_for_nodes(["/robot"])',
            "a bridge for DDS robots does not announce nodes; wait for topics or services",
        ),
        ('wait_for_topic_publisher("/chatter", "/robot")', "a bridge for DDS robots does not announce nodes"),
    ],
)
async def test_impossible_actions_are_reported(
    invocation: str, reason: str, tmp_path: Path, bridge: tuple[BridgeWithAction, str]
) -> None:
    ran = await run(tmp_path, bridge[1], f"scenario main:\n    do {invocation}\n")
    assert ran.verdict.status is RunStatus.FAILED
    assert reason in ran.verdict.reason
