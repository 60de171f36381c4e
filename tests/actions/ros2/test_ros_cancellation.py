"""Actions of `osc.ros` that are cancelled, at any moment, leave nothing behind."""

import asyncio

import pytest

from seoro.bridges.ros2.backend import RosBackend
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import RunRos

SCENARIO = """
action inspect

scenario main:
    robot: differential_drive_robot
    var number: int = 0
    var goals: string = ""
    do serial:
        one_of:
            serial:
                wait elapsed({delay}s)
            parallel:
                wait_for_data("/nothing", "std_msgs/msg/Empty")
                topic_monitor("/count", "std_msgs/msg/Int64", number, member_name: "data")
                check_data("/count", "std_msgs/msg/Int64", "-1", member_name: "data")
                assert_topic_latency("/scan", 60s, topic_type: "sensor_msgs/msg/LaserScan")
                assert_lifecycle_state("/robot", allow_initial_skip: true, fail_on_unexpected: false,
                    state_sequence: [lifecycle_state!unconfigured, lifecycle_state!finalized])
                assert_tf_moving("base_link", timeout: 60s)
                robot.tf_close_to(0.1m, position_3d(x: 100m))
                robot.odometry_distance_traveled(100000m)
                log_check(values: ["never text"])
                wait_for_nodes(["/nobody"])
                service_call("/never", "std_srvs/srv/Empty", "{{}}")
                service_call("/nowhere", "std_srvs/srv/Empty", "{{}}")
                action_call("/fibonacci", "example_interfaces/action/Fibonacci", "{{order: 5000}}")
                action_call("/nowhere", "example_interfaces/action/Fibonacci", "{{order: 5000}}")
        inspect()
        service_call("/goals", "std_srvs/srv/Trigger", "", response_variable: goals,
            response_member_name: "message")
        compare(goals, "==", "0")
"""


@action("inspect", anywhere=Ros2System)
async def inspect(ctx: ActionContext) -> None:
    """Log the remaining endpoints of a run in the ROS 2 system; removing their tokens may take a moment."""
    backend = ctx.anywhere(RosBackend)
    graph, own = backend._node.graph, backend._node.node.session

    def left() -> list[str]:
        places = [endpoint for found in graph._endpoints.values() for endpoint in found.values()]
        ours = [each for each in places if each.session == own and not each.name.startswith("/seoro/")]
        return sorted(f"{each.kind.name} {each.name}" for each in ours)

    for _ in range(100):
        if not left():
            break
        await asyncio.sleep(0.05)
    ctx.log(f"left: {left()}")
    ctx.log(f"tasks: {sorted(task.get_name() for task in asyncio.all_tasks() if 'meanwhile' in repr(task))}")


@pytest.mark.parametrize(
    "delay", [0.0, 0.01, 0.1, *(pytest.param(each, marks=pytest.mark.more) for each in (0.001, 0.003, 0.03, 0.3))]
)
async def test_a_cancelled_action_leaves_no_endpoint(delay: float, run_ros: RunRos) -> None:
    ran = await run_ros(SCENARIO.format(delay=delay), [inspect])
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    texts = [text for _, text in ran.logs]
    assert "left: []" in texts
    assert "tasks: []" in texts
    assert not [record for record in ran.records if record["kind"] == "log" and record["level"] == "warning"]
    assert not any(each.overran for each in ran.verdict.cancelled)
