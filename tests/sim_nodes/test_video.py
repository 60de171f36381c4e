from __future__ import annotations

import io
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seoro.bridges import wire
from seoro.bridges.wire import ResetScope, Result, StartRecording
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import recording as video
from sim_nodes.__main__ import ENGINES
from sim_nodes.recording import Encoder
from sim_nodes.views import Picture
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import needs_pictures

av: Any = pytest.importorskip("av", reason="PyAV is not installed")

SMALL: dict[str, Any] = {"width": 64, "height": 48}


def played(film: bytes) -> tuple[list[float], list[NDArray[np.uint8]]]:
    """Return the times and images of a video, as decoded by a player."""
    with av.open(io.BytesIO(film)) as container:
        frames = list(container.decode(video=0))
    return [round(frame.time, 6) for frame in frames], [frame.to_ndarray(format="rgb24") for frame in frames]


def start(client: Client, **what: Any) -> None:
    client.ask(wire.START_RECORDING, StartRecording(**{**SMALL, **what}))


def stop(client: Client) -> wire.RecordingEnd:
    return client.ask(wire.STOP_RECORDING, wire.Empty())


@pytest.mark.parametrize("engine", ENGINES)
def test_videos_have_images_at_equal_steps_of_simulated_time(engine: str) -> None:
    needs_pictures(engine)
    client = Client("empty", engine=engine)
    start(client, rate=10, follow=ROBOT)
    film = client.advance(1.0).film
    client.spawn("box", pose(0.5, 0.0))
    film += client.advance(2.0).film
    last = stop(client)
    times, pictures = played(film + last.film)
    assert times == pytest.approx(np.arange(21) / 10.0)
    assert pictures[0].shape == (48, 64, 3)
    assert np.abs(pictures[5].astype(int) - pictures[15]).max() > 40, "the box is seen once it is there"
    assert last.error == ""


def test_an_unfinished_video_is_playable() -> None:
    needs_pictures("mujoco")
    client = Client("empty")
    start(client, rate=5)
    times, _ = played(client.advance(2.5).film)
    assert 1.0 <= times[-1] <= 2.5


def test_a_video_continues_without_its_camera_and_through_resets() -> None:
    needs_pictures("mujoco")
    client = Client("empty")
    lens = {"fov": 1.0, "width": 32, "height": 32}
    client.ask(wire.SPAWN_CAMERA, wire.SpawnCamera(name="eye", pose=pose(0.0, 0.0, z=1.0), **lens))
    start(client, camera="eye", rate=5)
    film = client.advance(1.0).film
    client.ask(wire.DELETE_ENTITY, wire.EntityName(name="eye"))
    film += client.advance(2.0).film
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=ResetScope.DEFAULT))
    film += client.advance(1.0).film
    times, pictures = played(film + stop(client).film)
    assert (times[-1], pictures[-1].shape) == (3.0, (32, 32, 3))


def test_a_video_continues_after_a_rewind() -> None:
    needs_pictures("mujoco")
    client = Client("empty")
    start(client, follow=ROBOT, rate=10)
    saved = client.ask(wire.SAVE_STATE, wire.Empty())
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(2.5, 1.2)))
    film = client.advance(0.5).film
    client.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=saved, purpose=wire.Purpose.REWIND))
    film += client.advance(1.0).film
    times, pictures = played(film + stop(client).film)
    assert times[-1] == 1.0
    near, far = (np.abs(pictures[0].astype(int) - pictures[index]).mean() for index in (-1, 4))
    assert near < far, "the robot is followed to where it was"


def test_recording_does_not_change_the_run() -> None:
    needs_pictures("mujoco")
    recorded, other = Client("maze"), Client("maze")
    start(recorded, rate=10)
    for client in (recorded, other):
        client.localise()
        client.navigate(pose(1.5, 1.5))
        client.advance(1.0)
    assert recorded.truth == other.truth
    assert recorded.estimate == other.estimate


def test_an_encoder_error_ends_the_video_but_not_the_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    needs_pictures("mujoco")
    client = Client("empty")
    start(client, rate=5)
    client.advance(0.1)
    monkeypatch.setattr(Encoder, "add", _raise(OSError("the encoder is full")))
    advanced = client.advance(1.0)
    assert (advanced.time, advanced.film_error) == (1.0, "OSError: the encoder is full")
    assert stop(client).error == "OSError: the encoder is full"
    assert client.advance(1.1).film_error == ""


def test_an_uncollected_video_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video, "MAX_KEPT", 1000)
    encoder = Encoder(64, 48, 1)
    noise = np.random.default_rng(0)
    with pytest.raises(OSError, match="were not collected"):
        for _ in range(100):
            encoder.add(noise.integers(0, 255, (48, 64, 3), dtype=np.uint8))


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ({"rate": 24}, "unsupported rate of 24 images per second; expected 1, 2, 5, 10, 25, 50"),
        ({"width": 65}, "odd video size 65 by 48"),
        ({"width": 5000}, "16 to 2048 pixels"),
        ({"follow": "ghost"}, "unknown entity 'ghost'"),
        ({"camera": "ghost"}, "unknown camera 'ghost'"),
        ({"camera": f"{ROBOT}/front", "follow": ROBOT}, "not both"),
    ],
)
def test_invalid_recordings_are_refused(empty: Client, what: dict[str, Any], message: str) -> None:
    with pytest.raises(RequestRefused, match=message):
        start(empty, **what)
    with pytest.raises(RequestRefused, match="no recording is active"):
        stop(empty)


def test_a_second_recording_is_refused(empty: Client) -> None:
    needs_pictures("mujoco")
    start(empty)
    with pytest.raises(RequestRefused, match="a recording is active"):
        start(empty)
    stop(empty)
    start(empty)


def test_a_missing_encoder_is_refused_with_a_hint(empty: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    needs_pictures("mujoco")
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(RequestRefused, match=r"videos need PyAV: pip install 'seoro\[video\]'") as refused:
        start(empty)
    assert refused.value.code == Result.FEATURE_UNSUPPORTED


def _raise(error: Exception) -> Callable[[Encoder, Picture], None]:
    def add(self: Encoder, picture: Picture) -> None:
        raise error

    return add
