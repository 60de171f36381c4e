"""Actions of `osc.ros` that send requests: services, actions, parameters."""

import json
from pathlib import Path

import pytest

from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import RunRos, expect_failure, run_with_a_robot_that_dies

ADD = "example_interfaces.srv.AddTwoInts"
FIBONACCI = "example_interfaces/action/Fibonacci"


async def test_a_service_is_called_and_its_response_kept(run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    var sum: int = 0
    var whole: string = ""
    do serial:
        service_call("/add", "{ADD}", "{{a: 3, b: 4}}", response_variable: sum, response_member_name: "sum")
        service_call("add", "{ADD}", "{{a: 5}}", response_variable: whole)
        compare(sum, "==", 7)
        log(whole)
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert json.loads(ran.logs[-1][1]) == {"sum": 5}


@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        (f'service_call("/add", "{ADD}", "{{c: 1}}")', "unknown member `c` of"),
        ('service_call("/add", "std_srvs/srv/Empty", "{}")', "/add is of type example_interfaces/srv/AddTwoInts"),
        ('service_call("/fail", "std_srvs/srv/Empty", "")', "the server of /fail failed: the gripper is stuck"),
        (f'service_call("/add", "{ADD}", "[1]")', r"a request to /add needs members"),
        (
            f'service_call("/add", "{ADD}", "{{}}", response_member_name: "sum")',
            "no variable given for `sum` of the response of /add",
        ),
        (
            f'action_call("/fibonacci", "{FIBONACCI}", "{{order: 13}}")',
            "the server of /fibonacci rejects the goal",
        ),
        (
            f'action_call("/fibonacci", "{FIBONACCI}", "{{order: 7}}")',
            r'the goal of /fibonacci was aborted; the result of /fibonacci: {"sequence": \[0, 1, 1, 2, 3, 5, 8\]}',
        ),
        (f'action_call("/fibonacci", "{FIBONACCI}", "{{size: 7}}")', "its members are `order`"),
        ('action_call("/fibonacci", "nav2_msgs/action/Spin", "{}")', "/fibonacci.* is of type example_interfaces"),
        ('set_node_parameter("/robot", "speed", "2.5")', "/robot rejects `2.5` for `speed`: a speed is"),
        ('set_node_parameter("/robot", "speed", "fast")', "/robot rejects `fast` for `speed`: a speed is"),
        ('set_node_parameter("robot", "weight", "1")', "rejects `1` for `weight`: it has not been declared"),
        ('set_node_parameter("robot", "speed", "{a: 1}")', "`{a: 1}` is an invalid parameter value"),
    ],
)
async def test_rejected_requests_fail_with_the_reason(invocation: str, reason: str, run_ros: RunRos) -> None:
    ran = await run_ros(f"scenario main:\n    do {invocation} with:\n        timeout(20s)\n")
    expect_failure(ran.verdict, reason)


async def test_a_missing_server_is_awaited_and_reported(run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    do service_call("/addd", "{ADD}", "{{a: 1}}") with:
        timeout(0.2s)
"""
    )
    assert "timeout: still running after 0.2 s" in ran.verdict.reason
    assert [text for _, text in ran.logs] == ["waiting for the service /addd (similar: /add)"]


async def test_a_server_that_never_answers_times_out(run_ros: RunRos) -> None:
    ran = await run_ros(
        """
scenario main:
    do service_call("/never", "std_srvs/srv/Empty", "{}") with:
        timeout(0.3s)
"""
    )
    assert "timeout: still running after 0.3 s" in ran.verdict.reason
    assert ran.verdict.duration < 5.0


async def test_a_server_that_dies_ends_the_call(tmp_path: Path, router: str) -> None:
    text = """
scenario main:
    do parallel:
        service_call("/never", "std_srvs/srv/Empty", "{}")
        serial:
            check_data("/echo", "std_msgs/msg/String", "asked", member_name: "data",
                qos_profile: qos_preset_profiles!system_default_transient_local)
            log("now")
"""
    verdict = await run_with_a_robot_that_dies(tmp_path, router, text)
    expect_failure(verdict, "the server of /never disappeared")
    assert verdict.duration < 10.0


async def test_a_goal_succeeds_with_feedback_in_the_trace(run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    var last: int = 0
    do serial:
        action_call("/fibonacci", "{FIBONACCI}", "{{order: 5}}",
            result_variable: last, result_member_name: "sequence.4")
        compare(last, "==", 3)
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert [text for _, text in ran.logs] == ['feedback of /fibonacci: {"sequence": [0, 1, 1]}']


async def test_a_cancelled_goal_is_canceled_at_the_robot(run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    do parallel:
        check_data("/echo", "std_msgs/msg/String", "goal canceled", member_name: "data")
        serial:
            one_of:
                action_call("/fibonacci", "{FIBONACCI}", "{{order: 1000}}")
                wait elapsed(0.3s)
            log("canceled")
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert ran.ends["action_call"] == "cancelled"
    assert ran.verdict.duration < 10.0


async def test_a_goal_without_a_wait_for_its_end_has_no_result(run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    var result: string = ""
    do action_call("/fibonacci", "{FIBONACCI}", "{{order: 5}}", success_on_acceptance: true,
        result_variable: result)
"""
    )
    expect_failure(ran.verdict, "`success_on_acceptance` excludes `result_variable`")


async def test_an_accepted_goal_is_canceled_at_the_end_of_the_run(run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    do serial:
        action_call("/fibonacci", "{FIBONACCI}", "{{order: 1001}}", success_on_acceptance: true)
        log("accepted")
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert ran.verdict.duration < 5.0
    again = await run_ros(
        """
scenario main:
    do check_data("/echo", "std_msgs/msg/String", "goal canceled", member_name: "data",
        qos_profile: qos_preset_profiles!system_default_transient_local) with:
        timeout(20s)
"""
    )
    assert again.verdict.status is RunStatus.PASSED, again.verdict.reason


@pytest.mark.parametrize("arguments", ["", ", success_on_acceptance: true"])
async def test_a_goal_that_cannot_be_canceled_is_reported(arguments: str, run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    event accepted
    do parallel:
        one_of:
            serial:
                action_call("/fibonacci", "{FIBONACCI}", "{{order: 10}}"{arguments})
                wait elapsed(20s)
            serial:
                wait @accepted
                wait elapsed(0.15s)
        serial:
            check_data("/echo", "std_msgs/msg/String", "goal accepted", member_name: "data",
                qos_profile: qos_preset_profiles!system_default_transient_local)
            emit accepted
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    warnings = [r["message"] for r in ran.records if r["kind"] == "log" and r["level"] == "warning"]
    assert len(warnings) == 1
    assert "its server rejects to cancel it (return code 1)" in warnings[0]


async def test_a_robot_that_dies_in_the_middle_of_a_goal_ends_it(tmp_path: Path, router: str) -> None:
    text = f'scenario main:\n    do action_call("/fibonacci", "{FIBONACCI}", "{{order: 1000}}")\n'
    verdict = await run_with_a_robot_that_dies(tmp_path, router, text)
    expect_failure(verdict, "/fibonacci/_action/get_result disappeared")
    assert verdict.duration < 10.0


@pytest.mark.parametrize("value", ["0.75", "1"])
async def test_a_parameter_is_set_with_the_type_of_the_node(value: str, run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    var speed: string = ""
    do serial:
        set_node_parameter("/robot", "speed", "{value}")
        service_call("/robot/get_parameters", "rcl_interfaces/srv/GetParameters", "{{names: [speed]}}",
            response_variable: speed, response_member_name: "values.0.double_value")
        log(speed)
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert float(ran.logs[-1][1]) == float(value)
