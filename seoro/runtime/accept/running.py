"""Instances that run in frames, and environments of their modifications."""

from __future__ import annotations

from bisect import bisect

from seoro.lang.plan import Override
from seoro.runtime.accept.frames import Frame
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.world import World
from seoro.runtime.values.environment import Environment


def running_instance(frame: Frame, world: World) -> Instance | None:
    """Return the instance that runs in a frame: a new one, or the first, made before the modifiers begin."""
    owner = frame.owner
    position = bisect(owner.recorded, frame.start.seq)
    is_inside = position < len(owner.recorded) and owner.recorded[position] < frame.end.seq
    number = owner.instances[position if is_inside else max(position - 1, 0)] if owner.instances else -1
    return world.instances.get(number)


def environment_in(frame: Frame, world: World) -> Environment:
    """Return the environment of modifications of a behavior, with the running instance as `it`."""
    environment = frame.around.environment
    instance = running_instance(frame, world)
    if instance is None:
        return environment
    return environment.bind(it=instance)


def override_scope(override: Override, frame: Frame, world: World) -> Instance:
    """Return the scenario instance whose labels an override names."""
    instance = running_instance(frame, world)
    if instance is not None and any(each is override for each in instance.declaration.modifiers):
        return instance
    return frame.around
