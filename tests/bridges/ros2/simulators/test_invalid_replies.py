"""ROS simulators with invalid states, or with services of other types."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, connect_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.simulators.interfaces import PAUSED, PLAYING
from seoro.bridges.ros2.simulators.node import serving_simulator
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.session import AsyncSession, open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.bridges.wire.keys import NAMESPACE
from seoro.errors import BackendRefused, UsageError

UPRIGHT = {"w": 1.0}
STEP = 0.01  # [s]


@dataclass(frozen=True)
class Mistaken:
    """A simulator with entities `a` and `b`; `b` has a configurable pose."""

    orientation: dict[str, float]
    x: float = 0.0
    states: int = 2
    resets: bool = True
    states_of_time: list[int] = field(default_factory=lambda: [PAUSED])
    world: str = "simulation_interfaces/srv/GetCurrentWorld"


WELL = Mistaken(UPRIGHT)


@asynccontextmanager
async def simulated(made: Mistaken, router: str, types: TypeStore, folder: Path) -> AsyncIterator[AsyncSession]:
    """Yield a session to the simulator as a node."""
    steps = 0

    async def features(_: Any) -> dict[str, Any]:
        return {}

    async def states(_: Any) -> dict[str, Any]:
        header = {"stamp": {"nanosec": round(steps * STEP * 1e9)}}
        first = {"header": header, "pose": {"orientation": UPRIGHT}}
        second = {"header": header, "pose": {"position": {"x": made.x}, "orientation": made.orientation}}
        return done() | {"entities": ["a", "b"], "states": [first, second][: made.states]}

    async def step(request: Any) -> dict[str, Any]:
        nonlocal steps
        steps += request.steps
        return done()

    async def state(_: Any) -> dict[str, Any]:
        return done() | {"state": {"state": made.states_of_time[-1]}}

    async def set_state(request: Any) -> dict[str, Any]:
        made.states_of_time.append(request.state.state)
        return done()

    async def reset(_: Any) -> dict[str, Any]:
        return done() if made.resets else {"result": {"result": 0, "error_message": "not here"}}

    async def world(_: Any) -> dict[str, Any]:
        return done() | {"world": {"name": "w"}} if "World" in made.world else {}

    services: dict[str, tuple[str, Callable[[Any], Awaitable[dict[str, Any]]]]] = {
        "get_simulator_features": ("GetSimulatorFeatures", features),
        "get_entities_states": ("GetEntitiesStates", states),
        "step_simulation": ("StepSimulation", step),
        "get_simulation_state": ("GetSimulationState", state),
        "set_simulation_state": ("SetSimulationState", set_state),
        "reset_simulation": ("ResetSimulation", reset),
    }
    endpoint = f"unixsock-stream/{folder}/ros"
    async with (
        connect(router, types=types, dialect=RmwZenoh()) as theirs,
        theirs.node("simulator") as node,
        node.serving("get_current_world", made.world, world),
        AsyncExitStack() as stack,
    ):
        for name, (kind, handler) in services.items():
            await stack.enter_async_context(node.serving(name, f"simulation_interfaces/srv/{kind}", handler))
        async with (
            connect(router, types=types, dialect=RmwZenoh()) as system,
            open_session(listen=endpoint, gossip=True) as hub,
            serving_simulator(hub, "ros", system),
            open_session(connect=endpoint) as session,
        ):
            yield session


def done() -> dict[str, Any]:
    return {"result": {"result": 1}}


async def place_of(session: AsyncSession, entity: str) -> wire.EntityState:
    return await ask(NodeAddress(session, NAMESPACE, "ros"), wire.GET_ENTITY_STATE, wire.EntityName(name=entity))


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (
            replace(WELL, orientation={"w": 0.0}),
            "invalid state of the entity 'b': invalid orientation",
        ),
        (replace(WELL, x=float("nan")), "invalid state of the entity 'b' .*; expected finite numbers"),
    ],
)
async def test_an_invalid_state_is_refused_with_its_entity(
    made: Mistaken, words: str, router: str, types: TypeStore, tmp_path: Path
) -> None:
    async with simulated(made, router, types, tmp_path) as session:
        with pytest.raises(BackendRefused, match=words):
            await place_of(session, "b")
        assert await place_of(session, "a") == wire.EntityState()


async def test_missing_entity_states_are_refused(router: str, types: TypeStore, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="`get_entities_states` returns 2 entities and 1 states"):
        async with simulated(replace(WELL, states=1), router, types, tmp_path):
            pass


async def test_a_service_of_another_type_is_refused(
    router: str, types: TypeStore, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made = replace(WELL, world="std_srvs/srv/Trigger")
    async with simulated(made, router, types, tmp_path) as session:
        with pytest.raises(BackendRefused, match=r"^/get_current_world is of type std_srvs/srv/Trigger, not"):
            await ask(NodeAddress(session, NAMESPACE, "ros"), wire.GET_SIMULATOR_FEATURES, wire.Empty())
    assert not caplog.records


async def test_a_refused_reset_is_reported(router: str, types: TypeStore, tmp_path: Path) -> None:
    async with simulated(replace(WELL, resets=False), router, types, tmp_path):
        with pytest.raises(
            UsageError, match="'ros' cannot restart: the simulator refuses `reset_simulation`: not here"
        ) as no:
            async with connect_simulator(
                f"unixsock-stream/{tmp_path}/ros", SimulatorOptions(None, 3, ModelPath())
            ):
                pass
        assert "`--world` loads a world instead" in no.value.help


async def test_a_playing_simulator_resumes_if_no_run_has_started(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    unmeasured, unused, used, paused = (
        replace(WELL, states_of_time=[state], states=states)
        for state, states in ((PLAYING, 1), (PLAYING, 2), (PLAYING, 2), (PAUSED, 2))
    )
    with pytest.raises(UsageError, match="and 1 states"):
        async with simulated(unmeasured, router, types, tmp_path):
            pass
    for made in (unused, paused, used):
        async with simulated(made, router, types, tmp_path) as session:
            if made is used:
                await ask(NodeAddress(session, NAMESPACE, "ros"), wire.ADVANCE, wire.Advance(until=1.0))
    assert unmeasured.states_of_time == unused.states_of_time == [PLAYING, PAUSED, PLAYING]
    assert used.states_of_time == [PLAYING, PAUSED]
    assert paused.states_of_time == [PAUSED]
