"""Actions of `osc.ros` on topics: publishing, waiting for messages, and copying them into variables."""

from __future__ import annotations

import anyio

from seoro.actions.ros_messages import to_twist
from seoro.actions.ros_support import (
    TOPIC,
    as_action_failure,
    member,
    next_message,
    observed_system,
    store,
    system_of,
    to_members,
)
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import VelocityCommands
from seoro.runtime.contracts.ros2 import ObservedSystem, Ros2System, RosPublisher
from seoro.runtime.execution.background import BackgroundResource
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Variable

MATCH_WITHIN = 1.0  # [s] for the discovery of subscriptions
TRANSIENT = "transient_local"
TWISTS = frozenset({"Twist", "TwistStamped"})


class Publishers:
    """The publishers of a run. They live until its end, so that late subscriptions receive messages."""

    def __init__(self) -> None:
        self._open: dict[tuple[str, str, str], BackgroundResource[RosPublisher]] = {}
        self._opening = anyio.Lock()

    async def find(self, ctx: ActionContext, topic: str, type_name: str, qos: str) -> RosPublisher:
        """Return the publisher of a topic with a type and a QoS, created on the first call."""
        key = (topic, type_name, qos)
        async with self._opening:
            if key not in self._open:
                self._open[key] = await ctx.keep(system_of(ctx).publishing(topic, type_name, qos))
        return self._open[key].value


@action("topic_publish", anywhere=Ros2System | VelocityCommands, ros=TOPIC)
async def topic_publish(
    ctx: ActionContext, topic_name: str, topic_type: str, value: object, qos_profile: EnumValue
) -> None:
    """Publish one message; without a ROS 2 system, a velocity command to a robot of the simulator."""
    if ctx.find(Ros2System) is None:
        await _command(ctx, topic_name, topic_type, value)
        return
    message = to_members(value, f"a message of {topic_name}")
    with as_action_failure():
        publisher = await ctx.shared(Publishers).find(ctx, topic_name, topic_type, qos_profile.member)
        if not await publisher.wait_for_subscription(MATCH_WITHIN) and TRANSIENT not in qos_profile.member:
            ctx.log(f"no subscription to {topic_name}: the message is lost", "warning")
        publisher.publish(message)


async def _command(ctx: ActionContext, topic: str, topic_type: str, value: object) -> None:
    """Send a velocity command to a robot of the simulator."""
    package, _, kind = topic_type.replace("/", ".").rpartition(".")
    if package.partition(".")[0] != "geometry_msgs" or kind not in TWISTS:
        raise ActionFailed(
            f"publishing '{topic_type}' needs a ROS 2 system (`--ros`); robots in a simulator accept "
            "'geometry_msgs.msg.Twist' and 'geometry_msgs.msg.TwistStamped' on their topics /cmd_vel"
        )
    with as_action_failure():
        velocity = to_twist(to_members(value, f"a message of {topic}"))
    robot, _, _ = topic.strip("/").rpartition("/")
    await ctx.ask(ctx.by_name(robot, VelocityCommands).command_velocity(topic, velocity))


@action("wait_for_data", anywhere=ObservedSystem, ros=TOPIC)
async def wait_for_data(ctx: ActionContext, topic_name: str, topic_type: str, qos_profile: EnumValue) -> None:
    """Wait for the next message on a topic."""
    with as_action_failure():
        async with observed_system(ctx).subscribing(topic_name, topic_type, qos_profile.member) as subscription:
            await next_message(ctx, subscription)


@action("topic_monitor", anywhere=ObservedSystem, open_ended=True, ros=TOPIC)
async def topic_monitor(
    ctx: ActionContext,
    topic_name: str,
    topic_type: str,
    target_variable: Variable[object],
    qos_profile: EnumValue,
    member_name: str,
) -> None:
    """Store each message of a topic in a variable, until cancelled."""
    what = f"`{member_name}` of {topic_name}" if member_name else f"a message of {topic_name}"
    with as_action_failure():
        async with observed_system(ctx).subscribing(topic_name, topic_type, qos_profile.member) as subscription:

            def take() -> None:
                while (message := subscription.receive_nowait()) is not None:
                    store(ctx, target_variable, member(message.members, member_name, what), what)

            await ctx.follow(subscription.on_arrival, take)
