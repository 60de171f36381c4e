"""Actions of `osc.ros` that check messages: their values, their latency, and the logs of nodes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from statistics import fmean
from typing import Any, NamedTuple

from seoro.actions.ros_comparison import Operator, compares, difference, read_expected
from seoro.actions.ros_support import TOPIC, as_action_failure, log_missing, member, next_message, observed_system
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Members, ObservedSystem, RosClock, RosMessage, RosSubscription
from seoro.runtime.functions.actions import action

DATA_WITHIN = 1.0  # [s] for the first message, if its absence is a failure
COMPARABLE = 60.0  # [s]; with a larger difference of clocks, the age of a message is unknown
AHEAD = 1.0  # [s] by which the clock of a robot may be ahead
DEFAULT_QOS = "system_default"
LOG_TYPE = "rcl_interfaces/msg/Log"
LOG_QOS = "parameters"  # reliable, with a queue of a thousand: nodes log in bursts


class CheckOptions(NamedTuple):
    """Failure conditions of a check; the parameters of actions have the same names."""

    fail_if_no_data: bool
    fail_if_bad_comparison: bool
    wait_for_first_message: bool


@action("check_data", anywhere=ObservedSystem, ros=TOPIC)
async def check_data(
    ctx: ActionContext,
    topic_name: str,
    topic_type: str,
    expected_value: object,
    eval_expected_value: bool,
    qos_profile: EnumValue,
    member_name: str,
    comparison_operator: Operator,
    fail_if_no_data: bool,
    fail_if_bad_comparison: bool,
    wait_for_first_message: bool,
) -> None:
    """Wait for a message whose value satisfies the comparison."""
    what = f"`{member_name}` of {topic_name}" if member_name else f"a message of {topic_name}"
    expected = read_expected(expected_value, is_text=not eval_expected_value)

    def judge(message: RosMessage) -> str:
        found = member(message.members, member_name, what)
        if compares(found, comparison_operator, expected, what):
            return ""
        return f"{what} {difference(found, comparison_operator, expected)}"

    terms = CheckOptions(fail_if_no_data, fail_if_bad_comparison, wait_for_first_message)
    await check(ctx, topic_name, topic_type, qos_profile.member, judge, terms)


async def check(
    ctx: ActionContext,
    topic: str,
    type_name: str,
    qos: str,
    judge: Callable[[RosMessage], str],
    options: CheckOptions,
) -> None:
    """Wait for a message that passes a check.

    Args:
        ctx: Context of the action.
        topic: Name of the topic.
        type_name: Its type.
        qos: QoS of the subscription.
        judge: Returns the error of a message; empty if the message passes.
        options: Failure conditions.

    Raises:
        ActionFailed: No message in time, or a message failed the check, as `options` demands.
    """
    wrong = f"no message on {topic}"
    limit = DATA_WITHIN if options.fail_if_no_data and not options.wait_for_first_message else None
    with as_action_failure(), log_missing(ctx, lambda: wrong):
        async with observed_system(ctx).subscribing(topic, type_name, qos) as subscription:
            while True:
                message = await _take(ctx, subscription, limit, topic)
                limit = None
                wrong = judge(message)
                if not wrong:
                    return
                if options.fail_if_bad_comparison:
                    raise ActionFailed(wrong)


async def _take(ctx: ActionContext, subscription: RosSubscription, limit: float | None, topic: str) -> RosMessage:
    """Return the next message; fail if it does not arrive within a limit [s], if there is one."""
    try:
        return await next_message(ctx, subscription, limit)
    except TimeoutError:
        raise ActionFailed(f"no message on {topic} within {limit:g} s") from None


# ---------------------------------------------------------------- latency


@action(
    "assert_topic_latency",
    anywhere=ObservedSystem,
    open_ended=True,
    ros=TOPIC,
)
async def assert_topic_latency(
    ctx: ActionContext,
    topic_name: str,
    latency: float,
    comparison_operator: Operator,
    rolling_average_count: int,
    wait_for_first_message: bool,
    topic_type: str,
) -> None:
    """Watch the age of messages at their arrival; the mean of some ages must satisfy the comparison.

    Without a type, the first publisher has it.
    """
    if rolling_average_count < 1:
        raise ActionFailed(f"invalid `rolling_average_count`: expected at least 1, found {rolling_average_count}")
    if not topic_type and not wait_for_first_message:
        raise ActionFailed("missing `topic_type`, which `wait_for_first_message: false` needs")
    limit = None if wait_for_first_message else latency
    system = observed_system(ctx)
    with as_action_failure():
        async with (
            system.clock(lambda text: ctx.relay([text])) as clock,
            system.subscribing(topic_name, topic_type, DEFAULT_QOS) as subscription,
        ):
            ages = _Ages(clock, topic_name, rolling_average_count)
            while True:
                mean = ages.add(await _take(ctx, subscription, limit, topic_name))
                limit = None
                if mean is not None and not compares(mean, comparison_operator, latency, ""):
                    count = rolling_average_count
                    of = f", the mean of {count} messages," if count > 1 else ""
                    raise ActionFailed(
                        f"the latency of {topic_name}{of} is {mean:.6g} s; expected "
                        f"{comparison_operator.value} {latency:g} s"
                    )


class _Ages:
    """Ages of the last messages at their arrival.

    Args:
        clock: Clock of the system.
        topic: Topic of the messages.
        count: Number of messages in the mean.
    """

    def __init__(self, clock: RosClock, topic: str, count: int) -> None:
        self._clock = clock
        self._topic = topic
        self._ages: deque[float] = deque(maxlen=count)
        self._jumps = clock.jumps
        self._has_jumped = False  # and no comparable message has arrived since

    def add(self, message: RosMessage) -> float | None:
        """Add a message and return the mean; None with too few messages.

        Raises:
            ActionFailed: The age is unknown.
        """
        if self._clock.jumps != self._jumps:
            self._jumps, self._has_jumped = self._clock.jumps, True
            self._ages.clear()
        age = _age(message, self._clock, self._topic)
        if -AHEAD < age < COMPARABLE:
            self._has_jumped = False
            self._ages.append(age)
        elif not self._has_jumped:  # otherwise it was stamped before the jump
            raise ActionFailed(
                f"unknown latency of {self._topic}: a stamp differs by {age:.6g} s from the clock of the system "
                "(/clock, or the clock of this machine if /clock is not published)"
            )
        return fmean(self._ages) if len(self._ages) == self._ages.maxlen else None


def _age(message: RosMessage, clock: RosClock, topic: str) -> float:
    """Return the time between the stamp of a message and its arrival [s], on the clock of the system.

    Raises:
        ActionFailed: The age is unknown.
    """
    stamp = _stamp(message.members)
    if stamp is None:
        raise ActionFailed(f"unknown latency of {topic}: its messages have no header with a stamp")
    if stamp == 0.0:
        raise ActionFailed(f"unknown latency of {topic}: the stamps of its messages are 0")
    arrived = clock.at(message.arrived)
    if arrived is None:
        raise ActionFailed(f"unknown latency of {topic}: /clock exists, but has published no time")
    return arrived - stamp


def _stamp(message: Members) -> float | None:
    header: Any = message.get("header")
    stamp = header.get("stamp") if isinstance(header, Mapping) else None
    return stamp["sec"] + stamp["nanosec"] * 1e-9 if isinstance(stamp, Mapping) else None


# ---------------------------------------------------------------- logs


def is_logger_of(logger: str, node: str) -> bool:
    """Whether a logger belongs to a node.

    Args:
        logger: Its name, such as `bot1.robot`.
        node: Full name of the node (`/bot1/robot`), its name without the namespace (`robot`), or the name of the
            logger; empty for any node.
    """
    if not node:
        return True
    name = node.strip("/").replace("/", ".")
    return logger == name or (not node.startswith("/") and logger.endswith(f".{name}"))


@action("log_check", anywhere=ObservedSystem)
async def log_check(ctx: ActionContext, module_name: str, values: Sequence[str]) -> None:
    """Wait until a node logs a message that contains any of the texts."""
    if not values:
        raise ActionFailed("`values` is empty; expected at least one text")

    def judge(message: RosMessage) -> str:
        log = message.members
        if not is_logger_of(log["name"], module_name):
            return f"the logs are from `{log['name']}`, not from `{module_name}`"
        found = any(value in log["msg"] for value in values)
        return "" if found else f"no log contains {' or '.join(f'`{value}`' for value in values)}"

    await check(ctx, "/rosout", LOG_TYPE, LOG_QOS, judge, CheckOptions(False, False, True))
