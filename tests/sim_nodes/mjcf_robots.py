"""Small robots in MJCF with the parts that makers use: defaults, actuators, tendons, equalities, keyframes."""

from __future__ import annotations

from pathlib import Path

WORLD = "name: w\nextent: [-4, -4, 4, 4]\nrobots: [{name: mine, robot: robot.yaml}]\n"
SIDES = (("left", 1), ("right", -1))
LEGS = (
    ("front_left", 0.2, 0.12),
    ("front_right", 0.2, -0.12),
    ("hind_left", -0.2, 0.12),
    ("hind_right", -0.2, -0.12),
)


def write_robot(folder: Path, mjcf: str, drive: str, more: str = "") -> str:
    """Write a world with a robot of three lines; returns its path."""
    (folder / "robot.xml").write_text(mjcf)
    (folder / "robot.yaml").write_text(f"model: maker\nurdf: robot.xml\ndrive: {drive}\n{more}")
    (folder / "w.yaml").write_text(WORLD)
    return str(folder / "w.yaml")


def arm(gripper: str, extra: str = "") -> str:
    """Return an arm of four joints that carries a gripper; angles are in degrees, and one body has no name.

    At the keyframe `home` the gripper points down.
    """
    return f"""
<mujoco model="arm">
  <compiler angle="degree" autolimits="true"/>
  <option timestep="0.001" gravity="0 0 -3"/>
  <default>
    <default class="arm">
      <joint axis="0 1 0" range="-160 160" damping="1"/>
      <geom type="capsule" size="0.03" density="300"/>
      <position kp="400" forcerange="-60 60"/>
      <default class="finger"><geom type="box" density="3000" friction="1"/></default>
    </default>
  </default>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="5 5 1"/>
    <body name="base" childclass="arm" euler="0 0 90">
      <geom fromto="0 0 0 0 0 0.2" size="0.05"/>
      <body name="column" pos="0 0 0.25">
        <joint name="turn" axis="0 0 1"/>
        <geom fromto="0 0 0 0 0 0.1"/>
        <body pos="0 0 0.15">
          <joint name="shoulder" ref="10"/>
          <geom fromto="0 0 0 0.3 0 0"/>
          <body name="forearm" pos="0.3 0 0">
            <joint name="elbow"/>
            <geom fromto="0 0 0 0.3 0 0"/>
            <body name="hand" pos="0.3 0 0" euler="0 90 0">
              <joint name="wrist"/>
              <geom type="box" size="0.02 0.06 0.02" pos="0 0 0.03"/>
              <site name="grip" pos="0 0 0.12"/>
              {gripper}
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position class="arm" joint="turn"/><position class="arm" joint="shoulder"/>
    <position class="arm" joint="elbow"/><position class="arm" joint="wrist"/>
  </actuator>
  <sensor><force site="grip"/></sensor>
  {extra}
</mujoco>
"""


def sliding_gripper() -> str:
    """Return an arm whose fingers slide: a tendon drives both, and an equality couples them."""
    fingers = "".join(
        f'<body name="{side}" pos="0 0 0.06" euler="0 0 {90 - 90 * sign}"><joint name="{side}_slide" type="slide" '
        'axis="0 1 0" range="0 0.04"/><geom class="finger" size="0.01 0.005 0.04" pos="0 0.005 0.04"/></body>'
        for side, sign in SIDES
    )
    coupled = """
  <tendon>
    <fixed name="split"><joint joint="left_slide" coef="0.5"/><joint joint="right_slide" coef="0.5"/></fixed>
  </tendon>
  <equality><joint joint1="left_slide" joint2="right_slide"/></equality>
  <actuator>
    <general tendon="split" forcerange="-80 80" gainprm="0.01" biastype="affine" biasprm="0 -100 -10"/>
  </actuator>
  <keyframe><key name="home" qpos="0 0.7 0.9 0 0.04 0.04"/><key name="up" qpos="0 -1 0 0 0.04 0.04"/></keyframe>
"""
    return arm(fingers, coupled)


def linkage_gripper() -> str:
    """Return an arm with a finger on a parallelogram on each side, which a point closes."""
    light = 'armature="0.001" damping="0.001"'
    sides = "".join(
        f'<body name="{side}_crank" pos="0 {0.03 * sign} 0.05" euler="0 0 {90 - 90 * sign}">'
        f'<joint name="{side}_driver" axis="1 0 0" range="0 40" {light}/>'
        '<geom class="finger" size="0.004 0.003 0.02" pos="0 0.01 0.02" euler="-25 0 0"/>'
        f'<body name="{side}_rod" pos="0 0.02 0.04">'
        f'<joint name="{side}_coupler" axis="1 0 0" range="-90 0" {light}/>'
        '<geom class="finger" size="0.004 0.004 0.004"/></body></body>'
        f'<body name="{side}_rocker" pos="0 {0.015 * sign} 0.05" euler="0 0 {90 - 90 * sign}">'
        f'<joint name="{side}_spring" axis="1 0 0" range="-40 60" stiffness="0.02" springref="60" {light}/>'
        '<geom class="finger" size="0.004 0.003 0.02" pos="0 0.01 0.02" euler="-25 0 0"/>'
        f'<body name="{side}_finger" pos="0 0.02 0.04">'
        f'<joint name="{side}_follower" axis="1 0 0" range="-60 60" {light}/>'
        '<geom class="finger" size="0.01 0.005 0.03" pos="0 -0.005 0.03"/></body></body>'
        for side, sign in SIDES
    )
    closed = "".join(
        f'<connect body1="{side}_finger" body2="{side}_rod" anchor="0 0.015 0" solref="0.005 1"/>'
        for side, _ in SIDES
    )
    coupled = f"""
  <equality>{closed}<joint joint1="right_driver" joint2="left_driver"/></equality>
  <actuator>
    <position joint="left_driver" kp="10" forcerange="-1 1"/>
    <position joint="right_driver" kp="10" forcerange="-1 1"/>
  </actuator>
"""
    return arm(sides, coupled)


def two_wheels() -> str:
    """Return a base with two wheels and a ball; its free joint, floor and motors are those of a demonstration."""
    wheels = "".join(
        f'<body name="{side}" pos="0 {0.2 * sign} 0"><joint name="{side}_wheel" axis="0 1 0"/>'
        '<geom type="cylinder" size="0.08 0.02" euler="90 0 0" mass="0.5"/></body>'
        for side, sign in SIDES
    )
    motors = "".join(f'<motor joint="{side}_wheel" ctrlrange="-3 3"/>' for side, _ in SIDES)
    return f"""
<mujoco model="base">
  <compiler autolimits="true"/>
  <worldbody>
    <geom type="plane" size="5 5 1"/>
    <body name="chassis" pos="1 2 0.08"><freejoint/>
      <geom type="box" size="0.2 0.15 0.05" pos="0.05 0 0.05" mass="6"/>
      <geom type="sphere" size="0.03" pos="0.18 0 -0.05" friction="0.01" mass="0.1"/>{wheels}
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>
"""


def four_legs() -> str:
    """Return a body on four legs of two joints, whose masks of contacts know its own floor only."""
    legs = "".join(
        f'<body name="{name}" pos="{x} {y} 0"><joint name="{name}_hip"/><geom size="0.02" fromto="0 0 0 0 0 -0.2" '
        f'mass="0.4"/><body name="{name}_shin" pos="0 0 -0.2"><joint name="{name}_knee"/><geom size="0.02" '
        'fromto="0 0 0 0 0 -0.2" mass="0.3"/></body></body>'
        for name, x, y in LEGS
    )
    motors = "".join(
        f'<position joint="{name}_{joint}" kp="200"/>' for name, *_ in LEGS for joint in ("hip", "knee")
    )
    standing = " ".join(["0.6 -1.2"] * len(LEGS))
    return f"""
<mujoco model="dog">
  <compiler angle="radian" autolimits="true"/>
  <default>
    <joint axis="0 1 0" range="-2 2" actuatorfrcrange="-40 40"/><geom type="capsule" contype="2" conaffinity="4"/>
  </default>
  <worldbody>
    <geom type="plane" size="5 5 1" contype="4" conaffinity="2"/>
    <body name="trunk" pos="0 0 1"><freejoint/><geom type="box" size="0.25 0.1 0.05" mass="8"/>{legs}</body>
  </worldbody>
  <actuator>{motors}</actuator>
  <keyframe><key name="stand" qpos="0 0 1 1 0 0 0 {standing}"/></keyframe>
</mujoco>
"""
