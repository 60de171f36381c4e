from __future__ import annotations

import gc
import io
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from seoro.bridges import wire
from seoro.bridges.wire import Orientation3D, Pose3D, Position3D, ResetScope, Result, SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.geometry import rotation_matrix
from sim_nodes.views import NoRendering, Picture, View
from sim_nodes.worlds.loader import WorldError, parse_world
from tests.sim_nodes.client import BOX, ROBOT, Client, pose
from tests.sim_nodes.engines import needs_pictures

FRONT = f"{ROBOT}/front"
FOV = math.radians(45.0)


def spawn(client: Client, name: str = "eye", at: Pose3D | None = None, fov: float = FOV, width: int = 64) -> str:
    request = wire.SpawnCamera(name=name, pose=at or pose(0.0, -2.0, z=2.0), fov=fov, width=width, height=48)
    return client.ask(wire.SPAWN_CAMERA, request).name


def aim(client: Client, x: float, y: float, z: float, name: str = "eye") -> None:
    client.ask(wire.AIM_CAMERA, wire.AimCamera(name=name, target=Position3D(x=x, y=y, z=z)))


def follow(client: Client, entity: str, offset: Position3D, name: str = "eye") -> None:
    client.ask(wire.FOLLOW_ENTITY, wire.FollowEntity(name=name, entity=entity, offset=offset))


def names(client: Client) -> tuple[str, ...]:
    return client.ask(wire.GET_CAMERAS, wire.Empty()).names


def place(client: Client, name: str = "eye") -> tuple[float, float, float]:
    position = client.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=name)).pose.position
    return round(position.x, 3), round(position.y, 3), round(position.z, 3)


def delete(client: Client, name: str) -> None:
    client.ask(wire.DELETE_ENTITY, wire.EntityName(name=name))


def view(client: Client, name: str = "eye") -> View:
    return client.simulator.simulation.entities.cameras.view(name)


def picture(client: Client, name: str = "eye") -> Picture:
    image = client.ask(wire.GET_CAMERA_IMAGE, wire.EntityName(name=name))
    pixels = np.asarray(Image.open(io.BytesIO(image.data)))
    assert pixels.shape == (image.height, image.width, 3)
    assert image.time == client.simulator.simulation.time
    return pixels


@pytest.mark.parametrize("engine", ENGINES)
def test_a_camera_shows_its_target_in_the_colour_of_its_model(engine: str) -> None:
    needs_pictures(engine)
    client = Client("empty", engine=engine)
    spawn(client)
    aim(client, 0.0, 2.0, 0.15)
    before = picture(client)
    client.spawn("box", pose(0.0, 2.0))
    after = picture(client)
    rows, columns = np.nonzero((before != after).any(axis=2))
    assert 10 < len(rows) < 400
    assert (rows.mean(), columns.mean()) == pytest.approx((24, 32), abs=4)
    red, green, blue = after[24, 32].astype(int)
    assert red > green > blue, "the box is orange"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_camera_looks_ahead(engine: str) -> None:
    needs_pictures(engine)
    client = Client("empty", engine=engine)
    assert names(client) == (FRONT,)
    empty = picture(client, FRONT)
    client.spawn("box", pose(-1.0, 0.0))
    assert (picture(client, FRONT) == empty).mean() > 0.99, "behind it"
    delete(client, "box")
    client.spawn("box", pose(1.0, 0.2))
    _, columns = np.nonzero((picture(client, FRONT) != empty).any(axis=2))
    assert 0 < columns.mean() < empty.shape[1] / 2, "on its left"


def test_a_robot_camera_keeps_its_mount() -> None:
    client = Client("empty")
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(1.0, 2.0, math.pi / 2)))
    assert view(client, FRONT).position == pytest.approx((1.0, 2.11, 0.24), abs=1e-3)
    assert view(client, FRONT).axes[0] == pytest.approx((0.0, 1.0, 0.0), abs=1e-3)
    assert FRONT not in client.ask(wire.GET_ENTITIES, wire.EntityFilter()).names
    with pytest.raises(RequestRefused, match=f"'{FRONT}' is mounted on '{ROBOT}'"):
        aim(client, 1.0, 1.0, 1.0, FRONT)
    with pytest.raises(RequestRefused, match=f"'{FRONT}' is mounted on '{ROBOT}'"):
        follow(client, ROBOT, Position3D(x=1.0), FRONT)
    with pytest.raises(RequestRefused, match="unknown entity"):
        delete(client, FRONT)


def test_an_arm_camera_looks_along_the_tool(tmp_path: Path) -> None:
    world = tmp_path / "cell.yaml"
    world.write_text("name: cell\nextent: [-1.5, -1.5, 1.5, 1.5]\nrobots:\n  - {name: arm, robot: ur10e}\n")
    client = Client(str(world))
    (x, y, z), _ = client.simulator.simulation.engine.link_pose("arm", "tcp")
    seen = view(client, "arm/wrist")
    ahead = rotation_matrix(seen.orientation).T @ np.subtract((x, y, z - 0.3), seen.position)
    assert ahead[0] > 0.3
    assert np.hypot(*ahead[1:]) / ahead[0] < 0.5 * math.tan(seen.lens.fov / 2)


def test_a_free_camera_can_be_moved_and_deleted(empty: Client) -> None:
    assert spawn(empty) == "eye"
    assert names(empty) == ("eye", FRONT)
    assert empty.ask(wire.GET_ENTITIES, wire.EntityFilter()).names == ("eye", ROBOT)
    turned = Pose3D(position=Position3D(x=1.0, z=3.0), orientation=Orientation3D(pitch=0.5, yaw=1.0))
    empty.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="eye", pose=turned))
    found = empty.ask(wire.GET_ENTITY_STATE, wire.EntityName(name="eye")).pose
    assert found.position == turned.position
    assert found.orientation.pitch == pytest.approx(0.5)
    delete(empty, "eye")
    assert names(empty) == (FRONT,)
    with pytest.raises(RequestRefused, match=f"unknown camera 'eye'; cameras: {FRONT}") as refused:
        picture(empty)
    assert refused.value.code == Result.NOT_FOUND


def test_free_cameras_are_listed_as_entities(empty: Client) -> None:
    spawn(empty)
    for name, code in (
        ("eye", SpawnResult.NAME_NOT_UNIQUE),
        (ROBOT, SpawnResult.NAME_NOT_UNIQUE),
        ("map", SpawnResult.NAME_INVALID),
    ):
        with pytest.raises(RequestRefused) as refused:
            spawn(empty, name)
        assert refused.value.code == code
    with pytest.raises(RequestRefused, match="duplicate name 'eye'"):
        empty.spawn("eye", pose(2.0, 2.0))


def test_a_camera_follows_a_robot_until_its_pose_is_set(empty: Client) -> None:
    spawn(empty)
    follow(empty, ROBOT, Position3D(x=-1.0, z=1.0))
    assert place(empty) == pytest.approx((-1.0, 0.0, 1.0), abs=2e-3)
    empty.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(3.0, 1.0, 2.0)))
    assert place(empty) == pytest.approx((2.0, 1.0, 1.0), abs=2e-3)
    ahead, _ = view(empty).axes
    assert ahead == pytest.approx((math.sqrt(0.5), 0.0, -math.sqrt(0.5)), abs=1e-3)
    empty.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="eye", pose=pose(0.0, 0.0, z=1.0)))
    empty.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(-3.0, 1.0)))
    assert place(empty) == (0.0, 0.0, 1.0)


def test_a_camera_stays_in_place_when_its_target_is_deleted(empty: Client) -> None:
    empty.spawn("box", pose(2.0, 2.0))
    spawn(empty)
    follow(empty, "box", Position3D(z=3.0))
    delete(empty, "box")
    assert place(empty) == (2.0, 2.0, 3.0)


def test_a_reset_deletes_spawned_cameras_and_returns_others(tmp_path: Path) -> None:
    world = tmp_path / "world.yaml"
    world.write_text(
        "name: world\nextent: [-5, -5, 5, 5]\n"
        "cameras:\n"
        "  - {name: corner, position: [4, 4, 3], look_at: [0, 0, 0], fov: 1.0, width: 320, height: 200}\n"
    )
    client = Client(str(world))
    assert (view(client, "corner").lens.width, view(client, "corner").lens.fov) == (320, 1.0)
    assert view(client, "corner").axes[0][:2] == pytest.approx(np.array([-4.0, -4.0]) / math.sqrt(41))
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="corner", pose=pose(0.0, 0.0, z=9.0)))
    spawn(client)
    with pytest.raises(RequestRefused, match="'corner' belongs to the world"):
        delete(client, "corner")
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=ResetScope.SPAWNED))
    assert names(client) == ("corner",)
    assert place(client, "corner") == (0.0, 0.0, 9.0)
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=ResetScope.STATE))
    assert place(client, "corner") == (4.0, 4.0, 3.0)
    spawn(client)
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation())
    assert names(client) == ("corner",)


@pytest.mark.parametrize(
    ("camera", "message"),
    [
        ("{name: a, position: [0, 0, 1], look_at: [0, 0, 1]}", "`look_at` of a camera is its own position"),
        ("{name: a, position: [0, 0, 1], look_at: [1, 0, 1], yaw: 1}", "expected either `look_at`"),
        ("{name: a, position: [0, 0, 1], fov: 4.0}", "cameras.0.fov"),
        ("{name: a, position: [0, 0, 1], width: 5000}", "cameras.0.width"),
        ("{name: walls, position: [0, 0, 1]}", "duplicate name 'walls' of a camera"),
        ("{name: a, position: [0, 0, 1], rate: 5}", "cameras.0.rate"),
    ],
)
def test_a_world_file_with_an_invalid_camera_is_refused(camera: str, message: str) -> None:
    with pytest.raises(WorldError, match=message):
        parse_world(f"name: w\nextent: [-5, -5, 5, 5]\ncameras: [{camera}]\n", "w.yaml")


def test_impossible_camera_requests_are_refused(empty: Client) -> None:
    for fov in (0.0, math.pi, math.nan):
        with pytest.raises(RequestRefused, match="expected 1 to 150 degrees"):
            spawn(empty, fov=fov)
    with pytest.raises(RequestRefused, match="invalid image size 4 by 48; expected 16 to 2048 pixels"):
        spawn(empty, width=4)
    with pytest.raises(RequestRefused, match="within 1000 m"):
        spawn(empty, at=pose(math.nan, 0.0))
    spawn(empty)
    with pytest.raises(RequestRefused, match="its own position"):
        aim(empty, 0.0, -2.0, 2.0)
    with pytest.raises(RequestRefused, match="expected up to"):
        aim(empty, math.inf, 0.0, 0.0)
    with pytest.raises(RequestRefused, match="expected an offset"):
        follow(empty, ROBOT, Position3D())
    with pytest.raises(RequestRefused, match="unknown entity 'ghost'"):
        follow(empty, "ghost", Position3D(x=1.0))
    with pytest.raises(RequestRefused, match="cameras follow robots"):
        follow(empty, "eye", Position3D(x=1.0))


def test_the_number_of_cameras_has_a_limit(empty: Client) -> None:
    for index in range(49):
        spawn(empty, f"eye{index}")
    with pytest.raises(RequestRefused, match="too many cameras: 50"):
        spawn(empty)


def test_images_without_rendering_are_refused(empty: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    def blind(self: object, view: View) -> Picture:
        raise NoRendering("the lights are out")

    monkeypatch.setattr(type(empty.simulator.simulation.engine), "render", blind)
    with pytest.raises(RequestRefused, match="cannot render: the lights are out") as refused:
        picture(empty, FRONT)
    assert refused.value.code == Result.FEATURE_UNSUPPORTED


def test_deleting_an_engine_does_not_change_images_of_others() -> None:
    needs_pictures("mujoco")
    clients = [Client("empty") for _ in range(2)]
    for client in clients:
        spawn(client)
    before = picture(clients[0])
    picture(clients[1])
    picture(clients[0])
    del clients[1], client
    gc.collect()
    np.testing.assert_array_equal(picture(clients[0]), before)


def test_cameras_do_not_affect_physics_or_lidars() -> None:
    client, other = Client("empty"), Client("empty")
    for each in (client, other):
        each.localise()
        each.navigate(pose(2.0, 1.0))
    spawn(client, at=pose(1.0, 0.5, z=0.2))
    follow(client, ROBOT, Position3D(x=0.3))
    for each in (client, other):
        each.advance(3.0)
    assert client.truth == other.truth
    assert client.estimate == other.estimate


def test_models_without_a_colour_have_one_derived_from_their_name(empty: Client) -> None:
    plain = BOX.replace("0.85 0.45 0.1 1", "0.2 0.4 0.6")
    empty.spawn("tinted", pose(2.0, 2.0), plain)
    empty.spawn("bare", pose(-2.0, 2.0), plain.replace("<diffuse>0.2 0.4 0.6</diffuse>", ""))
    spawned = empty.simulator.simulation.entities.spawned
    assert spawned["tinted"].model.colour == (0.2, 0.4, 0.6, 1.0)
    assert spawned["bare"].model.colour is None
    with pytest.raises(RequestRefused, match="invalid <diffuse>: '2 0 0'"):
        empty.spawn("loud", pose(0.0, 2.0), plain.replace("0.2 0.4 0.6", "2 0 0"))
