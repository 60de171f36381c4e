"""Actions of `osc.ros` on topics: publishing, waiting for messages, and variables that follow them."""

from __future__ import annotations

import anyio

from seoro.actions.ros_messages import to_twist
from seoro.actions.ros_support import failing, member, next_message, store, system_of, to_members
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.runtime.actions import action
from seoro.runtime.capabilities import DrivenRobots
from seoro.runtime.context import ActionContext
from seoro.runtime.lasting import Kept
from seoro.runtime.ros_system import Ros2System, RosPublisher
from seoro.runtime.values import Variable

MATCH_WITHIN = 1.0  # [s] until what is published reaches those who have subscribed
TRANSIENT = "transient_local"
TWISTS = frozenset({"Twist", "TwistStamped"})


class Publishers:
    """The publishers of a run: they last as long as it, so that late subscriptions get what was published."""

    def __init__(self) -> None:
        self._open: dict[tuple[str, str, str], Kept[RosPublisher]] = {}
        self._opening = anyio.Lock()

    async def find(self, ctx: ActionContext, topic: str, type_name: str, qos: str) -> RosPublisher:
        """The publisher of a topic, with a type and a QoS."""
        key = (topic, type_name, qos)
        async with self._opening:
            if key not in self._open:
                self._open[key] = await ctx.keep(system_of(ctx).publishing(topic, type_name, qos))
        return self._open[key].value


@action("topic_publish", anywhere=Ros2System | DrivenRobots)
async def topic_publish(
    ctx: ActionContext, topic_name: str, topic_type: str, value: object, qos_profile: EnumValue
) -> None:
    """Publish one message; without a ROS 2 system, commands of velocity to robots of the simulator."""
    if ctx.find(Ros2System) is None:
        await _command(ctx, topic_name, topic_type, value)
        return
    message = to_members(value, f"a message of {topic_name}")
    with failing():
        publisher = await ctx.shared(Publishers).find(ctx, topic_name, topic_type, qos_profile.member)
        if not await publisher.wait_for_subscription(MATCH_WITHIN) and TRANSIENT not in qos_profile.member:
            ctx.log(f"nobody subscribes to {topic_name}: the message reaches nobody", "warning")
        publisher.publish(message)


async def _command(ctx: ActionContext, topic: str, topic_type: str, value: object) -> None:
    """A command of velocity to a robot of the simulator, on whose way nothing gets lost."""
    package, _, kind = topic_type.replace("/", ".").rpartition(".")
    if package.partition(".")[0] != "geometry_msgs" or kind not in TWISTS:
        raise ActionFailed(
            f"a message of type '{topic_type}' can be published on a ROS 2 system only, which `--ros` reaches; "
            "robots in a simulator take 'geometry_msgs.msg.Twist' and 'geometry_msgs.msg.TwistStamped' on their "
            "topics /cmd_vel"
        )
    with failing():
        velocity = to_twist(to_members(value, f"a message of {topic}"))
    robot, _, _ = topic.strip("/").rpartition("/")
    await ctx.ask(ctx.by_name(robot, DrivenRobots).command_velocity(topic, velocity))


@action("wait_for_data", anywhere=Ros2System)
async def wait_for_data(ctx: ActionContext, topic_name: str, topic_type: str, qos_profile: EnumValue) -> None:
    """Wait for the next message on a topic."""
    with failing():
        async with system_of(ctx).subscribing(topic_name, topic_type, qos_profile.member) as subscription:
            await next_message(ctx, subscription)


@action("topic_monitor", anywhere=Ros2System, open_ended=True)
async def topic_monitor(
    ctx: ActionContext,
    topic_name: str,
    topic_type: str,
    target_variable: Variable[object],
    qos_profile: EnumValue,
    member_name: str,
) -> None:
    """Let a variable hold what each message on a topic says, until this is ended."""
    what = f"`{member_name}` of {topic_name}" if member_name else f"a message of {topic_name}"
    with failing():
        async with system_of(ctx).subscribing(topic_name, topic_type, qos_profile.member) as subscription:

            def take() -> None:
                while (message := subscription.take_now()) is not None:
                    store(ctx, target_variable, member(message.members, member_name, what), what)

            await ctx.follow(subscription.when_arrived, take)
