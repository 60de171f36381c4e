"""`Channel` and `Subscription` alone: receivers of occurrences, and times of reception."""

from __future__ import annotations

from collections.abc import Callable

from seoro.runtime.kernel.channel import Channel, Occurrence, Subscription
from seoro.runtime.kernel.task import CausalPast, Task
from seoro.runtime.kernel.task_group import TaskGroup
from tests.runtime.kernel.runs import run, scheduler_of


async def receive(task: Task, channel: Channel, count: int = 1) -> list[object]:
    """Receive from a channel; return the numbers with their times of arrival."""
    with channel.subscribe(task) as subscription:
        received: list[object] = []
        for _ in range(count):
            occurrence = await subscription.receive()
            received += [occurrence.fields["number"], task.scheduler.now]
    return received


def send(task: Task, channel: Channel, number: int, key: str = "") -> bool:
    """Send a number; return whether it is a new occurrence."""
    return channel.send({"number": number}, task.past, key) is not None


async def test_a_sent_occurrence_is_received_in_the_same_instant() -> None:
    async def main(task: Task) -> list[object]:
        channel = Channel(scheduler_of(task), "go")
        async with TaskGroup(task) as group:
            receivers = [group.start_soon(receive, channel) for _ in range(2)]
            await task.sleep(1.0)
            send(task, channel, 7)
        return [receiver.outcome for receiver in receivers]

    assert (await run(main)).outcome == [[7, 1.0], [7, 1.0]]


async def test_a_sent_occurrence_is_not_received_in_the_same_cycle() -> None:
    log: list[str] = []

    async def receiving(task: Task, channel: Channel) -> None:
        await receive(task, channel)
        log.append("received")

    async def main(task: Task) -> None:
        channel = Channel(scheduler_of(task), "go")
        async with TaskGroup(task) as group:
            group.start_soon(receiving, channel)
            await task.sleep(1.0)
            send(task, channel, 1)
            log.append("sent")

    await run(main)
    assert log == ["sent", "received"]


async def test_a_subscription_is_an_async_iterator() -> None:
    async def receiving(task: Task, channel: Channel) -> list[int]:
        numbers: list[int] = []
        with channel.subscribe(task) as subscription:
            async for occurrence in subscription:
                numbers.append(occurrence.fields["number"])
                if len(numbers) == 3:
                    break
        return numbers

    async def main(task: Task) -> object:
        channel = Channel(scheduler_of(task), "go")
        async with TaskGroup(task) as group:
            child = group.start_soon(receiving, channel)
            for number in range(3):
                await task.sleep(1.0)
                send(task, channel, number)
        return child.outcome

    assert (await run(main)).outcome == [0, 1, 2]


async def test_occurrences_of_one_instant_are_buffered() -> None:
    async def main(task: Task) -> object:
        channel = Channel(scheduler_of(task), "go")
        async with TaskGroup(task) as group:
            child = group.start_soon(receive, channel, 2)
            await task.sleep(1.0)
            send(task, channel, 1, "a")
            send(task, channel, 2, "b")
        return child.outcome

    assert (await run(main)).outcome == [1, 1.0, 2, 1.0]


async def test_equal_keys_of_an_instant_are_one_occurrence() -> None:
    async def main(task: Task) -> list[bool]:
        channel = Channel(scheduler_of(task), "go")
        found = [send(task, channel, 1, "a"), send(task, channel, 1, "a"), send(task, channel, 2, "b")]
        await task.sleep(1.0)
        return [*found, send(task, channel, 1, "a")]

    assert (await run(main)).outcome == [True, False, True, True]


async def test_a_task_does_not_receive_its_own_occurrences() -> None:
    async def main(task: Task) -> list[object]:
        channel = Channel(scheduler_of(task), "go")
        async with TaskGroup(task) as group:
            with channel.subscribe(task) as subscription:
                send(task, channel, 1)
                await task.sleep(0.0)
                started_after = group.start_soon(receive, channel)
                await task.sleep(1.0)
                received = subscription.received
            send(task, Channel(scheduler_of(task), "other"), 2)
            group.after(0.0, group.cancel_all)
        return [received, started_after.outcome]

    assert (await run(main)).outcome == [False, None]


async def test_a_subscription_with_its_own_past_receives_sends_of_its_task() -> None:
    async def main(task: Task) -> object:
        channel = Channel(scheduler_of(task), "go")
        with channel.subscribe(task, CausalPast()) as subscription:
            send(task, channel, 1)
            return (await subscription.receive()).fields["number"]

    assert (await run(main)).outcome == 1


async def test_a_task_does_not_receive_an_occurrence_twice() -> None:
    async def main(task: Task) -> list[bool]:
        channel = Channel(scheduler_of(task), "go")
        async with TaskGroup(task) as group:
            group.start_soon(send_later, channel)
            with channel.subscribe(task) as subscription:
                await subscription.receive()
        with channel.subscribe(task) as again:
            await task.sleep(1.0)
            return [subscription.received, again.received]

    async def send_later(task: Task, channel: Channel) -> None:
        await task.sleep(1.0)
        send(task, channel, 1)

    assert (await run(main)).outcome == [True, False]


async def test_a_late_subscription_receives_sends_of_this_instant_only() -> None:
    async def late(task: Task, channel: Channel, time: float) -> list[object]:
        await task.sleep_until(time)
        for _ in range(3):
            await task.step()
        return await receive(task, channel)

    async def main(task: Task) -> list[object]:
        channel = Channel(scheduler_of(task), "go")
        async with TaskGroup(task) as group:
            children = [group.start_soon(late, channel, time) for time in (1.0, 1.5)]
            for number in (1, 2):
                await task.sleep(1.0)
                send(task, channel, number)
        return [child.outcome for child in children]

    assert (await run(main)).outcome == [[1, 1.0], [2, 2.0]]


def is_even(log: list[str]) -> Callable[[Occurrence], bool]:
    """Return a filter that counts even numbers only, and logs all."""

    def counts(occurrence: Occurrence) -> bool:
        number = occurrence.fields["number"]
        log.append(f"offered {number}")
        return bool(number % 2 == 0)

    return counts


async def test_filtered_occurrences_take_no_step_and_are_not_in_the_past() -> None:
    log: list[str] = []

    async def main(task: Task) -> list[object]:
        channel, past = Channel(scheduler_of(task), "go"), CausalPast()
        with channel.subscribe(task, past, is_even(log)) as subscription:
            cycle = scheduler_of(task).cycle
            found: list[object] = []
            for number in (1, 2):
                occurrence = channel.send({"number": number}, task.past, str(number))
                assert occurrence is not None
                await task.sleep(0.0)
                found += [subscription.received, past.contains(occurrence.number, 0)]
        return [*found, scheduler_of(task).cycle - cycle]

    assert (await run(main)).outcome == [False, False, True, True, 2]
    assert log == ["offered 1", "offered 2"]


async def test_a_subscription_may_receive_a_single_occurrence() -> None:
    async def receiving(task: Task, channel: Channel) -> list[object]:
        with Subscription(task, once=True) as subscription:
            channel.attach(subscription)
            subscription.on_close(lambda: channel.detach(subscription))
            first = (await subscription.receive()).fields["number"]
        return [first, *await receive(task, channel)]

    async def main(task: Task) -> object:
        channel = Channel(scheduler_of(task), "go")
        async with TaskGroup(task) as group:
            child = group.start_soon(receiving, channel)
            await task.sleep(1.0)
            send(task, channel, 1, "a")
            send(task, channel, 2, "b")
        return child.outcome

    assert (await run(main)).outcome == [1, 2, 1.0]  # the other one is left for the next subscription


async def test_a_closed_subscription_receives_no_more() -> None:
    log: list[str] = []

    async def main(task: Task) -> bool:
        channel = Channel(scheduler_of(task), "go")
        with channel.subscribe(task, CausalPast(), is_even(log)) as subscription:
            subscription.on_close(lambda: log.append("closed"))
        send(task, channel, 2)
        await task.sleep(0.0)
        return subscription.is_closed

    assert (await run(main)).outcome is True
    assert log == ["closed"]


async def test_a_receiver_that_is_detached_receives_no_more() -> None:
    async def main(task: Task) -> bool:
        channel = Channel(scheduler_of(task), "go")
        subscription = Subscription(task, CausalPast())
        channel.attach(subscription)
        channel.detach(subscription)
        send(task, channel, 1)
        await task.sleep(0.0)
        return subscription.received

    assert (await run(main)).outcome is False


async def test_a_receiver_may_detach_another_while_it_receives() -> None:
    async def main(task: Task) -> list[bool]:
        channel = Channel(scheduler_of(task), "go")
        other = Subscription(task, CausalPast())

        def detach_other(_: Occurrence) -> bool:
            channel.detach(other)
            return True

        with channel.subscribe(task, CausalPast(), detach_other) as first:
            channel.attach(other)
            send(task, channel, 1)
            await task.sleep(0.0)
        return [first.received, other.received]

    assert (await run(main)).outcome == [True, False]
