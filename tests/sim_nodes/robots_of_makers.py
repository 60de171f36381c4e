"""Robots as makers describe them, with frames, axes and meshes that a simulation must adapt."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sim_nodes.models.meshes import Mesh, hull, to_stl

WORLD = "name: w\nextent: [-4, -4, 4, 4]\nrobots: [{name: mine, robot: robot.yaml, pose: {x: 1.0}}]\n"
INERTIA = '<inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/>'
RADIUS, HALF_TRACK, AXLE, HEIGHT = 0.08, 0.2, -0.1, 0.15  # [m] of the wheels, and where the axle is below the root
LIDAR = (
    '<gazebo reference="top"><sensor type="ray" name="s"><update_rate>20</update_rate><ray><scan><horizontal>'
    "<samples>181</samples><min_angle>-1.5707963</min_angle><max_angle>1.5707963</max_angle></horizontal></scan>"
    "<range><min>0.2</min><max>8</max></range></ray></sensor></gazebo>"
)


def two_wheels(*, wheel: str = '<mesh filename="wheel.stl"/>', extra: str = "") -> str:
    """Return the URDF of a robot whose root is in the middle of its body, with mesh wheels that turn backwards."""
    sides = "".join(
        f'<link name="{side}"><inertial><mass value="0.5"/>{INERTIA.format(0.002)}</inertial><collision>'
        f'<geometry>{wheel}</geometry></collision></link><joint name="{side}_joint" type="continuous">'
        f'<origin xyz="{AXLE} {y} {RADIUS - HEIGHT}"/><parent link="chassis"/><child link="{side}"/>'
        '<axis xyz="0 -1 0"/><limit effort="3" velocity="10"/></joint>'
        for side, y in (("left", HALF_TRACK), ("right", -HALF_TRACK))
    )
    return (
        f'<robot name="maker"><link name="chassis"><inertial><mass value="8"/>{INERTIA.format(0.2)}</inertial>'
        '<collision><geometry><box size="0.5 0.3 0.1"/></geometry></collision></link>'
        '<link name="caster"><collision><geometry><sphere radius="0.03"/></geometry></collision></link>'
        f'<joint name="swivel" type="continuous"><origin xyz="0.2 0 {0.03 - HEIGHT}"/><parent link="chassis"/>'
        '<child link="caster"/><axis xyz="0 0 1"/></joint>'
        '<link name="top"/><joint name="top_joint" type="fixed"><origin xyz="0.1 0 0.1"/><parent link="chassis"/>'
        f'<child link="top"/></joint>{sides}{extra}</robot>'
    )


def write_robot(folder: Path, urdf: str, drive: str, more: str = "") -> str:
    """Write a world with a robot of three lines; returns its path."""
    (folder / "robot.urdf").write_text(urdf)
    (folder / "robot.yaml").write_text(f"model: maker\nurdf: robot.urdf\ndrive: {drive}\n{more}")
    (folder / "w.yaml").write_text(WORLD)
    (folder / "wheel.stl").write_bytes(to_stl(hull(Mesh(_round_points(), np.zeros((0, 3), int)))))
    return str(folder / "w.yaml")


def _round_points() -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    x, z = RADIUS * np.cos(angles), RADIUS * np.sin(angles)
    return np.vstack([np.column_stack([x, np.full(12, y), z]) for y in (-0.02, 0.02)])
