"""Joints of compiled models of MuJoCo that follow others, for engines that know linear couplings only.

Equalities of joints and of fixed tendons are linear. Closed chains, such as four-bar linkages, are moved through
the range of their driven joint, and a line is fitted to the positions of the others.
"""

from __future__ import annotations

import copy
from collections.abc import Collection, Iterator, Mapping
from dataclasses import field
from typing import Any

import mujoco
import numpy as np

from seoro.bridges.wire.refusal import name_list
from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.mujoco.actuation import efforts_of, joints_of_tendon

EQUALITY, JOINT = mujoco.mjtEq, mujoco.mjtJoint
ONE_AXIS = (int(JOINT.mjJNT_HINGE), int(JOINT.mjJNT_SLIDE))
CLOSING = (int(EQUALITY.mjEQ_CONNECT), int(EQUALITY.mjEQ_WELD))
WORLD = 0  # body
ROWS = 9  # of a closed chain
ENDLESS = 1.0  # [rad], [m] motion of a driven joint without limits, to both sides
WAY = 1.0  # [s] for half of the range
HEAVY = 1e3  # [kg m^2], [kg]
FINEST = 1e-3  # [s] time step
LARGEST_ERROR = 0.02  # [rad], [m] of a fitted line without a note


@dataclass(frozen=True)
class Coupling:
    """A joint is at `factor` times the position of its leader plus `offset`, both from their initial positions."""

    leader: int
    factor: float
    offset: float


@dataclass
class Couplings:
    """Couplings by following joint, and notes on couplings that are not linear."""

    of: dict[int, Coupling] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def add(self, follower: int, leader: int, factor: float, offset: float) -> None:
        """Add a coupling; a leader that follows itself is replaced by its own leader."""
        known = self.of.get(leader)
        if known is not None:
            leader, factor, offset = known.leader, factor * known.factor, offset + factor * known.offset
        if follower not in self.of and follower != leader:
            self.of[follower] = Coupling(leader, factor, offset)

    def root(self, joint: int) -> int:
        """Return the joint that a joint follows, or itself."""
        return self.of[joint].leader if joint in self.of else joint


def find_couplings(model: Any) -> Couplings:
    """Return the joints of a model that follow others."""
    found, driven = Couplings(), efforts_of(model)
    for index in range(model.neq):
        if not model.eq_active0[index]:
            continue
        if model.eq_type[index] == EQUALITY.mjEQ_JOINT:
            _add_equality(model, index, found)
        elif model.eq_type[index] == EQUALITY.mjEQ_TENDON:
            _add_tendon(model, index, driven, found)
    _add_closed_chains(model, driven, found)
    return found


def _add_equality(model: Any, index: int, found: Couplings) -> None:
    """Add the equality of two joints."""
    follower, leader = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
    offset, factor, *higher = model.eq_data[index, :5].tolist()
    if leader < 0 or not all(model.jnt_type[each] in ONE_AXIS for each in (follower, leader)):
        return
    if any(higher):
        name = _name(model, follower)
        found.notes.append(f"other engines than MuJoCo couple {name} by a line, not a polynomial")
    found.add(follower, leader, factor, offset)


def _add_tendon(model: Any, index: int, driven: Collection[int], found: Couplings) -> None:
    """Add the constant length of a fixed tendon over two joints."""
    joints = dict(joints_of_tendon(model, int(model.eq_obj1id[index])))
    if model.eq_obj2id[index] >= 0 or len(joints) != 2 or not all(joints.values()):
        return
    leader, follower = sorted(joints, key=lambda joint: joint not in driven)
    offset = float(model.eq_data[index, 0]) / joints[follower]
    found.add(follower, leader, -joints[leader] / joints[follower], offset)


def _add_closed_chains(model: Any, driven: Mapping[int, float], found: Couplings) -> None:
    """Add the couplings of joints in closed chains, which points or frames of two bodies close."""
    chains: dict[int, dict[int, None]] = {}
    for index in range(model.neq):
        if model.eq_type[index] not in CLOSING or not model.eq_active0[index]:
            continue
        joints = _chain(model, index)
        leaders = {joint for joint in joints if joint in driven or joint in found.of}
        if len(leaders) != 1:
            found.notes.append(
                f"only MuJoCo closes the chain of {name_list(_name(model, joint) for joint in joints)}, which has "
                f"{len(leaders)} driven joints; expected one"
            )
            continue
        chains.setdefault(leaders.pop(), {}).update(dict.fromkeys(joints))
    for leader, members in chains.items():
        _fit(model, leader, [each for each in members if each not in found.of and each not in driven], found)


def _chain(model: Any, index: int) -> list[int]:
    """Return the joints between both ends of an equality of bodies."""
    first, second = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
    if model.eq_objtype[index] == mujoco.mjtObj.mjOBJ_SITE:
        first, second = (int(model.site_bodyid[each]) for each in (first, second))
    above, beside = (list(_above(model, each)) for each in (first, second))
    joints = [*(each for each in above if each not in beside), *(each for each in beside if each not in above)]
    return [joint for joint in joints if model.jnt_type[joint] in ONE_AXIS]


def _above(model: Any, body: int) -> Iterator[int]:
    """Yield the joints from a body to the world."""
    while body != WORLD:
        start = int(model.body_jntadr[body])
        yield from range(start, start + int(model.body_jntnum[body]))
        body = int(model.body_parentid[body])


def _fit(model: Any, leader: int, followers: list[int], found: Couplings) -> None:
    """Couple joints of a closed chain to the joint that drives it, by lines of least squares."""
    if not followers:
        return
    positions = _moved(model, found.root(leader), followers, found)
    places = positions[:, leader]
    for follower in followers:
        values = positions[:, follower]
        factor, offset = np.polyfit(places, values, 1).tolist()
        error = float(np.abs(values - factor * places - offset).max())
        found.of[follower] = Coupling(leader, factor, offset)
        if error > LARGEST_ERROR:
            found.notes.append(
                f"other engines than MuJoCo move {_name(model, follower)} in its closed chain by a line, "
                f"{error:.2g} away at most"
            )


def _moved(model: Any, leader: int, free: list[int], found: Couplings) -> Array:
    """Move a driven joint through its range, without weight and contacts.

    Args:
        model: The model.
        leader: The joint.
        free: Joints that give way; all others are too heavy for that.
        found: Known couplings.

    Returns:
        Positions of all joints from their initial ones, shape (n, joints) [rad], [m].
    """
    still = copy.copy(model)
    off = mujoco.mjtDisableBit
    still.opt.disableflags |= off.mjDSBL_GRAVITY | off.mjDSBL_CONTACT | off.mjDSBL_ACTUATION
    heavy = np.ones(model.nv, dtype=bool)
    heavy[model.jnt_dofadr[free]] = False
    still.dof_armature[heavy] = HEAVY
    still.opt.timestep = min(FINEST, still.opt.timestep)
    start = float(model.qpos0[model.jnt_qposadr[leader]])
    low, high = model.jnt_range[leader].tolist() if model.jnt_limited[leader] else (-ENDLESS, ENDLESS)
    rows = np.linspace(low, high, ROWS) - start
    at = {0.0: np.zeros(model.njnt)}
    for side in (rows[rows > 0.0], rows[rows < 0.0][::-1]):
        data = mujoco.MjData(still)
        place = 0.0
        for row in side.tolist():
            for way in np.linspace(place, row, round(2.0 * WAY / ROWS / still.opt.timestep)).tolist():
                _set(still, data, leader, way, found)
                mujoco.mj_step(still, data)
            place = row
            at[row] = data.qpos[model.jnt_qposadr] - model.qpos0[model.jnt_qposadr]
    return np.array([at[place] for place in sorted(at)])


def _set(model: Any, data: Any, leader: int, place: float, found: Couplings) -> None:
    """Set the position of a driven joint and of its followers by equalities."""
    followers = {joint: each for joint, each in found.of.items() if each.leader == leader}
    for joint, position in (
        (leader, place),
        *((joint, each.factor * place + each.offset) for joint, each in followers.items()),
    ):
        address = model.jnt_qposadr[joint]
        data.qpos[address] = model.qpos0[address] + position
        data.qvel[model.jnt_dofadr[joint]] = 0.0


def _name(model: Any, joint: int) -> str:
    return repr(model.joint(joint).name or f"joint_{joint}")
