"""Actions of `osc.ros` that look at what messages say: their values, how old they are, and what nodes log."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from statistics import fmean
from typing import Any, NamedTuple

from seoro.actions.ros_comparison import Operator, compares, difference, read_expected
from seoro.actions.ros_support import failing, member, next_message, system_of, telling
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.runtime.actions import action
from seoro.runtime.context import ActionContext
from seoro.runtime.ros_system import Members, Ros2System, RosClock, RosMessage, RosSubscription

DATA_WITHIN = 1.0  # [s] until there has to be data, if it fails without
COMPARABLE = 60.0  # [s]; clocks that differ by more do not tell how old a message is
AHEAD = 1.0  # [s] that the clock of a robot may be ahead
DEFAULT_QOS = "system_default"
LOG_TYPE = "rcl_interfaces/msg/Log"
LOG_QOS = "parameters"  # reliable, with room for a thousand: nodes log in bursts


class Terms(NamedTuple):
    """When a check of messages fails, as actions have it by the same names."""

    fail_if_no_data: bool
    fail_if_bad_comparison: bool
    wait_for_first_message: bool


@action("check_data", anywhere=Ros2System)
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
    """Wait for a message that compares with a value as it should."""
    what = f"`{member_name}` of {topic_name}" if member_name else f"a message of {topic_name}"
    expected = read_expected(expected_value, is_text=not eval_expected_value)

    def judge(message: RosMessage) -> str:
        found = member(message.members, member_name, what)
        if compares(found, comparison_operator, expected, what):
            return ""
        return f"{what} {difference(found, comparison_operator, expected)}"

    terms = Terms(fail_if_no_data, fail_if_bad_comparison, wait_for_first_message)
    await check(ctx, topic_name, topic_type, qos_profile.member, judge, terms)


async def check(
    ctx: ActionContext, topic: str, type_name: str, qos: str, judge: Callable[[RosMessage], str], terms: Terms
) -> None:
    """Wait for a message that is as it should be.

    Args:
        ctx: Of the action.
        topic: Name of the topic.
        type_name: Its type.
        qos: What is asked for.
        judge: Says what is wrong with a message; nothing if it is as it should be.
        terms: When the action fails.

    Raises:
        ActionFailed: As the terms say.
    """
    wrong = f"nothing has come on {topic}"
    limit = DATA_WITHIN if terms.fail_if_no_data and not terms.wait_for_first_message else None
    with failing(), telling(ctx, lambda: wrong):
        async with system_of(ctx).subscribing(topic, type_name, qos) as subscription:
            while True:
                message = await _take(ctx, subscription, limit, topic)
                limit = None
                wrong = judge(message)
                if not wrong:
                    return
                if terms.fail_if_bad_comparison:
                    raise ActionFailed(wrong)


async def _take(ctx: ActionContext, subscription: RosSubscription, limit: float | None, topic: str) -> RosMessage:
    """The next message, which has to come within a limit [s], if there is one."""
    try:
        return await next_message(ctx, subscription, limit)
    except TimeoutError:
        raise ActionFailed(f"nothing has come on {topic} within {limit:g} s") from None


# ---------------------------------------------------------------- latency


@action("assert_topic_latency", anywhere=Ros2System, open_ended=True)
async def assert_topic_latency(
    ctx: ActionContext,
    topic_name: str,
    latency: float,
    comparison_operator: Operator,
    rolling_average_count: int,
    wait_for_first_message: bool,
    topic_type: str,
) -> None:
    """Watch how old messages are when they arrive; the mean of some ages has to compare as it should."""
    if rolling_average_count < 1:
        raise ActionFailed(f"`rolling_average_count` is at least 1, not {rolling_average_count}")
    limit = None if wait_for_first_message else latency
    system = system_of(ctx)
    with failing():
        async with (
            system.clock(lambda text: ctx.relay([text])) as clock,
            system.subscribing(topic_name, topic_type, DEFAULT_QOS) as subscription,
        ):
            ages = _Ages(clock, topic_name, rolling_average_count)
            while True:
                mean = ages.take(await _take(ctx, subscription, limit, topic_name))
                limit = None
                if mean is not None and not compares(mean, comparison_operator, latency, ""):
                    count = rolling_average_count
                    of = f", the mean of {count} messages," if count > 1 else ""
                    raise ActionFailed(
                        f"the latency of {topic_name}{of} is {mean:.6g} s, which is not "
                        f"{comparison_operator.value} {latency:g} s"
                    )


class _Ages:
    """How old the last messages were when they arrived.

    Args:
        clock: Of the system.
        topic: Of the messages.
        count: Of how many the mean is wanted.
    """

    def __init__(self, clock: RosClock, topic: str, count: int) -> None:
        self._clock = clock
        self._topic = topic
        self._ages: deque[float] = deque(maxlen=count)
        self._jumps = clock.jumps
        self._has_jumped = False  # and nothing that is comparable has come since

    def take(self, message: RosMessage) -> float | None:
        """The mean, with a message that has come; None as long as there are not enough.

        Raises:
            ActionFailed: It cannot be said.
        """
        if self._clock.jumps != self._jumps:
            self._jumps, self._has_jumped = self._clock.jumps, True
            self._ages.clear()
        age = _age(message, self._clock, self._topic)
        if -AHEAD < age < COMPARABLE:
            self._has_jumped = False
            self._ages.append(age)
        elif not self._has_jumped:  # else it was stamped before that
            raise ActionFailed(
                f"the latency of {self._topic} cannot be said: a stamp differs by {age:.6g} s from the clock of "
                "the system, which is that of /clock, or of this machine where nobody publishes that"
            )
        return fmean(self._ages) if len(self._ages) == self._ages.maxlen else None


def _age(message: RosMessage, clock: RosClock, topic: str) -> float:
    """How long before its arrival a message was stamped [s], by the clock of the system.

    Raises:
        ActionFailed: That cannot be said.
    """
    stamp = _stamp(message.members)
    if stamp is None:
        raise ActionFailed(f"the latency of {topic} cannot be said: its messages have no header with a stamp")
    if stamp == 0.0:
        raise ActionFailed(f"the latency of {topic} cannot be said: the stamps of its messages are 0")
    arrived = clock.at(message.arrived)
    if arrived is None:
        raise ActionFailed(f"the latency of {topic} cannot be said: /clock is there, and has told no time")
    return arrived - stamp


def _stamp(message: Members) -> float | None:
    header: Any = message.get("header")
    stamp = header.get("stamp") if isinstance(header, Mapping) else None
    return stamp["sec"] + stamp["nanosec"] * 1e-9 if isinstance(stamp, Mapping) else None


# ---------------------------------------------------------------- logs


def is_logger_of(logger: str, node: str) -> bool:
    """Whether a logger is that of a node.

    Args:
        logger: Its name, such as `bot1.robot`.
        node: The node's full name (`/bot1/robot`), its name without the namespace (`robot`), or the logger's name;
            empty for any node.
    """
    if not node:
        return True
    name = node.strip("/").replace("/", ".")
    return logger == name or (not node.startswith("/") and logger.endswith(f".{name}"))


@action("log_check", anywhere=Ros2System)
async def log_check(ctx: ActionContext, module_name: str, values: Sequence[str]) -> None:
    """Wait until a node logs a message with any of some texts in it."""
    if not values:
        raise ActionFailed("`values` is empty: there is nothing to look for")

    def judge(message: RosMessage) -> str:
        log = message.members
        if not is_logger_of(log["name"], module_name):
            return f"the logs are those of `{log['name']}`, not of `{module_name}`"
        is_it = any(value in log["msg"] for value in values)
        return "" if is_it else f"none of {', '.join(f'`{value}`' for value in values)} in the logs"

    await check(ctx, "/rosout", LOG_TYPE, LOG_QOS, judge, Terms(False, False, True))
