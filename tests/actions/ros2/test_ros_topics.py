"""Actions of `osc.ros` on topics, with a robot in another process."""

import json
from pathlib import Path

import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import RunRos, expect_failure, run_with_a_robot_that_dies, running
from tests.bridges.ros2.systems import with_another_string


async def test_published_messages_are_received(run_ros: RunRos) -> None:
    ran = await run_ros(
        """
scenario main:
    do parallel:
        check_data("/echo", "std_msgs.msg.String", "hello", member_name: "data",
            qos_profile: qos_preset_profiles!system_default_transient_local)
        serial:
            topic_publish("/texts", "std_msgs.msg.String", "{data: hello}")
            log("published")
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert [text for _, text in ran.logs] == ["published"]


async def test_structs_are_published_as_messages_of_geometry(run_ros: RunRos) -> None:
    ran = await run_ros(
        """
scenario main:
    pose: pose_3d = pose_3d(position: position_3d(x: 2m), orientation: orientation_3d(yaw: 180deg))
    speed: velocity_6d = velocity_6d(translational: translational_velocity_3d(x: 0.5mps))
    do parallel:
        check_data("/pose", "geometry_msgs/msg/Pose", "{position: {x: 2}, orientation: {z: 1.0, y: 0}}",
            qos_profile: qos_preset_profiles!system_default_transient_local)
        check_data("/speed", "geometry_msgs/msg/Twist", "0.5", member_name: "linear.x",
            qos_profile: qos_preset_profiles!system_default_transient_local)
        topic_publish("/pose", "geometry_msgs/msg/Pose", pose,
            qos_profile: qos_preset_profiles!system_default_transient_local)
        topic_publish("/speed", "geometry_msgs/msg/Twist", speed,
            qos_profile: qos_preset_profiles!system_default_transient_local)
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


async def test_late_subscriptions_receive_latched_messages_of_a_run(run_ros: RunRos) -> None:
    ran = await run_ros(
        """
scenario main:
    do serial:
        topic_publish("/map_name", "std_msgs/msg/String", "{data: hall}",
            qos_profile: qos_preset_profiles!system_default_transient_local)
        wait_for_data("/map_name", "std_msgs/msg/String", qos_preset_profiles!system_default_transient_local)
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


async def test_a_message_without_subscribers_is_reported(run_ros: RunRos) -> None:
    ran = await run_ros('scenario main:\n    do topic_publish("/deaf", "std_msgs/msg/Empty", "{}")\n')
    assert ran.verdict.status is RunStatus.PASSED
    assert [text for _, text in ran.logs] == ["no subscription to /deaf: the message is lost"]


@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        (
            'topic_publish("/a", "std_msgs/msg/Strin", "{}")',
            "`std_msgs` has no `msg/Strin`.*did you mean `std_msgs/msg/String`",
        ),
        ('topic_publish("/a", "std_msgs/msg/String", "{dat: x}")', "`dat`.*did you mean `data`"),
        (
            'topic_publish("/a", "std_msgs/msg/String", "hello")',
            "needs members, as in `{data: 1}`; found `hello`",
        ),
        ('topic_publish("/a", "std_msgs/msg/Int64", "{data: [}")', "cannot read the message"),
        ('topic_publish("/a b", "std_msgs/msg/Int64", "{data: 1}")', "'/a b'"),
        ('topic_publish("/texts", "std_msgs/msg/Int64", "{data: 1}")', "/texts is of type std_msgs/msg/String"),
        ('wait_for_data("/count", "std_msgs/msg/String")', "/count is of type std_msgs/msg/Int64, not std_msgs"),
    ],
)
async def test_invalid_topics_and_types_are_reported(invocation: str, reason: str, run_ros: RunRos) -> None:
    ran = await run_ros(f"scenario main:\n    do {invocation}\n")
    expect_failure(ran.verdict, reason)


async def test_a_variable_follows_a_topic(run_ros: RunRos) -> None:
    ran = await run_ros(
        """
scenario main:
    var number: int = -1
    var place: string = ""
    event seen
    do parallel:
        serial:
            wait number > 0
            wait number > 2 and place != ""
            log(place)
            emit seen
        topic_monitor("/count", "std_msgs.msg.Int64", number, member_name: "data") with:
            until @seen
        topic_monitor("/odom", "nav_msgs/msg/Odometry", place, member_name: "pose.pose.position") with:
            until @seen
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    [(_, place)] = ran.logs
    assert json.loads(place).keys() == {"x", "y", "z"}
    numbers = [r["value"] for r in ran.records if r["kind"] == "variable" and r["path"].endswith("number")]
    assert numbers == sorted(numbers)


@pytest.mark.parametrize(
    ("variable", "member", "reason"),
    [
        ("bool = false", "data", "cannot store `data` of /count, `.*`, in `.*` of the type bool"),
        ("int = 0", "dat", "unknown member 'dat' in 'dat'"),
    ],
)
async def test_a_variable_that_cannot_hold_a_member_is_reported(
    variable: str, member: str, reason: str, run_ros: RunRos
) -> None:
    ran = await run_ros(
        f"""
scenario main:
    var it_is: {variable}
    do topic_monitor("/count", "std_msgs.msg.Int64", it_is, member_name: "{member}")
"""
    )
    expect_failure(ran.verdict, reason)


async def test_an_unknown_definition_of_the_robot_is_reported(tmp_path: Path, router: str) -> None:
    types = with_another_string(TypeStore.bundled(), tmp_path / "theirs")
    text = 'scenario main:\n    do wait_for_data("/odd", "std_msgs/msg/String")\n'
    async with (
        connect(router, types=types, dialect=RmwZenoh()) as system,
        system.node("odd") as node,
        node.publishing("/odd", "std_msgs/msg/String") as odd,
        running(tmp_path, router, text) as run,
    ):
        await odd.wait_for_subscription(20.0)
        odd.publish({"data": "x", "priority": 3})
        verdict = await run.result()
    assert verdict.status is RunStatus.FAILED
    assert (
        "/odd: the robot and seoro have different definitions of std_msgs/msg/String (robot RIHS01_"
        in verdict.reason
    )


async def test_a_dead_publisher_is_awaited(tmp_path: Path, router: str) -> None:
    text = """
scenario main:
    do serial:
        wait_for_data("/count", "std_msgs/msg/Int64")
        log("there")
        wait_for_topic_publisher("/gone", "") with:
            timeout(0.5s)
"""
    verdict = await run_with_a_robot_that_dies(tmp_path, router, text)
    expect_failure(verdict, "timeout: still running after 0.5 s")
