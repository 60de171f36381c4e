"""MuJoCo specifications of scenes and bodies, and their appearance, which does not affect physics.

Added to URDF are the free joint, motors, friction, and groups of shapes that lidar rays may hit.
"""

from __future__ import annotations

import math
from typing import Any, assert_never

import mujoco
from defusedxml import ElementTree

from sim_nodes.geometry import quaternion
from sim_nodes.inertia import part_masses
from sim_nodes.mujoco.arm import add_arm, configure_grip_contacts
from sim_nodes.mujoco.files import attach_file, share_options, urdf_spec
from sim_nodes.mujoco.groups import HIDDEN_GROUP, SOLID_GROUP
from sim_nodes.mujoco.native import native_spec
from sim_nodes.mujoco.planar import add_planar_drive
from sim_nodes.mujoco.stepping import add_counters
from sim_nodes.mujoco.terrain import LOOSE_PRIORITY, ROLLING, TERRAIN_BODY, TORSIONAL, add_terrain, ground_priority
from sim_nodes.mujoco.work import add_work_sensors
from sim_nodes.physics import (
    FLOOR,
    BodyModel,
    BodyState,
    Box,
    Capsule,
    Cylinder,
    Hull,
    PlacedRobot,
    Scene,
    Shape,
    Sphere,
    Wall,
)
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.drive_declaration import DifferentialDrive, PlanarDrive
from sim_nodes.robots.sensor_declarations import ForceTorqueDeclaration
from sim_nodes.terrain.ground import FLOOR_FRICTION
from sim_nodes.views import FLOOR_TILES, TILE, WALL, Light, colour_of

FLOOR_MATERIAL = "floor"
SUN_DISTANCE = 20.0  # [m]; shadows are sharp about the point where its rays meet the floor
SHADOW_REACH = 0.6  # share of the diagonal of the floor
SHADOW_SIZE = 1024  # [pixels]; MuJoCo's 4096 more than doubles the time of software rendering


AMBIENT, HEADLIGHT, SUN = 0.4, 0.2, 0.5  # usual ambient light, diffuse light of the camera and of the sun


def add_appearance(spec: Any, extent: tuple[float, float, float, float], sun: Light) -> None:
    """Add floor, sky and light to a scene; `extent` is that of the floor [m]."""
    left, bottom, right, top = extent
    centre = ((left + right) / 2, (bottom + top) / 2, 0.0)
    quality, light = spec.visual.quality, spec.visual.headlight
    quality.shadowsize, quality.offsamples = SHADOW_SIZE, 0
    # Limits shadows, beyond which floors have artefacts; MuJoCo's own estimate ignores floors.
    spec.stat.extent, spec.stat.center = SHADOW_REACH * math.hypot(right - left, top - bottom), centre
    ambient, diffuse = sun.ambient * sun.brightness, sun.diffuse * sun.brightness
    light.ambient, light.diffuse = [AMBIENT * ambient] * 3, [HEADLIGHT * diffuse] * 3
    light.specular = [0.0] * 3
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        dir=sun.direction,
        pos=[at - SUN_DISTANCE * along for at, along in zip(centre, sun.direction, strict=True)],
        diffuse=[SUN * diffuse] * 3,
        specular=[0.0] * 3,
    )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=sun.sky[:3],
        rgb2=sun.sky[:3],
        width=8,
        height=8,
    )
    first, second = FLOOR_TILES
    spec.add_texture(
        name=FLOOR_MATERIAL,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=first[:3],
        rgb2=second[:3],
        width=256,
        height=256,
    )
    textures = [""] * mujoco.mjtTextureRole.mjNTEXROLE.value
    textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = FLOOR_MATERIAL
    repeat = 1.0 / TILE
    spec.add_material(name=FLOOR_MATERIAL, textures=textures, texuniform=True, texrepeat=[repeat, repeat])


def hide_collision_shapes(robot: Any) -> None:
    """Hide the collision shapes of links that have visuals."""
    for body in robot.bodies:
        geoms = list(body.geoms)
        if any(not geom.contype for geom in geoms):
            for geom in geoms:
                if geom.contype:
                    geom.group = HIDDEN_GROUP


TIMESTEP = 0.004  # [s]; the wheels of our robots are stable up to 5 ms
WALL_PREFIX = "wall/"
WORLD = "world"  # MuJoCo's name of the body of walls and floor
FOOTING = (
    500.0  # [kg], [kg m^2] added to the inertia of driven bodies, which stand on no floor that would hold them
)


def scene_spec(scene: Scene) -> Any:
    """Return the specification of a scene."""
    spec = mujoco.MjSpec()
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    add_appearance(spec, scene.extent, scene.light)
    left, bottom, right, top = scene.extent
    spec.worldbody.add_geom(
        name=FLOOR,
        material=FLOOR_MATERIAL,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=[(left + right) / 2, (bottom + top) / 2, 0.0],
        size=[(right - left) / 2, (top - bottom) / 2, 0.1],
        friction=[scene.ground.friction, TORSIONAL, ROLLING],
        priority=ground_priority(scene.ground.friction),
    )
    add_terrain(spec, scene.ground)
    for index, wall in enumerate(scene.walls):
        _add_wall(spec, index, wall)
    for robot in scene.robots:
        _add_robot(spec, robot, scene.ground.friction)
    if any(robot.declaration.arm is not None for robot in scene.robots):
        configure_grip_contacts(spec)
    add_work_sensors(spec)
    add_counters(spec, has_terrain=not scene.ground.is_flat)
    return spec


def _add_wall(spec: Any, index: int, wall: Wall) -> None:
    spec.worldbody.add_geom(
        name=f"{WALL_PREFIX}{wall.name}/{index}",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[wall.x, wall.y, wall.z + wall.height / 2],
        quat=quaternion(0.0, 0.0, wall.yaw),
        size=[wall.length / 2, wall.thickness / 2, wall.height / 2],
        rgba=WALL,
    )


def _add_robot(spec: Any, robot: PlacedRobot, floor_friction: float) -> None:
    frame = spec.worldbody.add_frame(pos=robot.state.position, quat=robot.state.orientation)
    child = robot_spec(robot.declaration, floor_friction)
    if robot.declaration.native is not None:
        share_options(child, spec)
    spec.attach(child, prefix=f"{robot.name}/", frame=frame)


def robot_spec(declaration: RobotDeclaration, floor_friction: float = FLOOR_FRICTION) -> Any:
    """Return the specification of a robot: its URDF or MJCF with a free joint and motors, for a floor."""
    if declaration.native is None:
        spec = urdf_spec(ElementTree.fromstring(declaration.urdf), dict(declaration.meshes))
    else:
        spec = native_spec(declaration, declaration.native)
    base = spec.body(declaration.base_link)
    if not declaration.fixed:
        base.add_freejoint()
    for geom in _solids(base):
        geom.friction = [declaration.body_friction, TORSIONAL, ROLLING]
    for link in declaration.low_friction_links:
        for geom in _solids(spec.body(link)):
            # Without priority, a contact has the larger friction of the two, which would be the floor's.
            geom.condim, geom.priority = 1, LOOSE_PRIORITY
    match declaration.mobile.drive if declaration.mobile is not None else None:
        case DifferentialDrive() as drive:
            _add_drive(spec, drive)
        case PlanarDrive() as drive:
            add_planar_drive(spec, declaration, drive, floor_friction)
    if declaration.arm is not None:
        add_arm(spec, declaration.arm, fixed=declaration.fixed)
    for sensor in declaration.sensors:
        if isinstance(sensor, ForceTorqueDeclaration):
            _add_load_sensors(spec, sensor.link)
    hide_collision_shapes(spec)
    return spec


def load_sensors(link: str) -> tuple[str, str]:
    """Return the names of the MuJoCo sensors of the force and the torque at the joint of a link."""
    return f"{link}/force", f"{link}/torque"


def _add_load_sensors(spec: Any, link: str) -> None:
    """Add the sensors of the load at the joint of a link, once."""
    kinds = (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE)
    site = f"{link}/load"
    if spec.site(site) is None:
        spec.body(link).add_site(name=site)
        for name, kind in zip(load_sensors(link), kinds, strict=True):
            spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=site)


def _add_drive(spec: Any, drive: DifferentialDrive) -> None:
    """Add motors to the wheels of a robot."""
    for name in (drive.left_joint, drive.right_joint):
        joint = spec.joint(name)
        joint.armature = drive.armature
        for geom in _solids(joint.parent):
            geom.friction = [drive.wheel_friction, TORSIONAL, ROLLING]
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_velocity(kv=drive.motor_gain)
        motor.forcelimited = True
        motor.forcerange = [-drive.motor_torque, drive.motor_torque]


def _solids(body: Any) -> list[Any]:
    return [geom for geom in body.geoms if geom.contype]


def add_body(spec: Any, name: str, model: BodyModel, state: BodyState) -> None:
    """Add a body to a specification; a static one is a mocap body, whose pose can be set."""
    body = spec.worldbody.add_body(name=name, pos=state.position, quat=state.orientation, mocap=model.static)
    if model.driven:
        body.add_joint(type=mujoco.mjtJoint.mjJNT_FREE, armature=0.0 if model.yields else FOOTING)
    elif not model.static:
        body.add_freejoint()
    if model.built_in:
        body.gravcomp = 1.0
        for fixed in (WORLD, TERRAIN_BODY):
            if spec.body(fixed) is not None:
                spec.add_exclude(name=f"{name}/{fixed}", bodyname1=name, bodyname2=fixed)
    if model.urdf is not None:
        attach_file(spec, body, name, model)
        return
    for part, mass in zip(model.parts, part_masses(model), strict=True):
        kind, size = _geom(part.shape)
        body.add_geom(
            type=kind,
            size=size,
            pos=part.position,
            quat=part.orientation,
            mass=mass,
            friction=[model.friction, TORSIONAL, ROLLING],
            group=SOLID_GROUP,
            rgba=colour_of(name, model.colour),
        )


def _geom(shape: Shape) -> tuple[Any, list[float]]:
    match shape:
        case Box(size=(x, y, z)):
            return mujoco.mjtGeom.mjGEOM_BOX, [x / 2, y / 2, z / 2]
        case Cylinder(radius=radius, length=length):
            return mujoco.mjtGeom.mjGEOM_CYLINDER, [radius, length / 2, 0.0]
        case Sphere(radius=radius):
            return mujoco.mjtGeom.mjGEOM_SPHERE, [radius, 0.0, 0.0]
        case Capsule(radius=radius, length=length):
            return mujoco.mjtGeom.mjGEOM_CAPSULE, [radius, length / 2, 0.0]
        case Hull():
            raise AssertionError("hulls are parts of files, which are attached")
        case _:
            assert_never(shape)
