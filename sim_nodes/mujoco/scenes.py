"""Splits MJCF files with several bodies at the top: each free body apart, and the rest on the world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

import mujoco

from seoro.deferred import dataclass
from sim_nodes.geometry import Frame, Quaternion, vector
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.scenes import MAX_BODIES
from sim_nodes.mujoco.specs import WORLD, compile_mjcf, compile_spec
from sim_nodes.mujoco.to_urdf import is_free, shapes_of_world, tops_of
from sim_nodes.physics import Mjcf

BASE = "scene"  # name of the part that is fixed to the world
EQUALITY, WRAP = mujoco.mjtEq, mujoco.mjtWrap
LOST = "without effect: {count} equalities or tendons between bodies that move apart"


@dataclass(frozen=True)
class Piece:
    """A part of an MJCF file that is a body of its own.

    Attributes:
        name: Name of its body, perhaps empty, or `BASE`.
        mjcf: The part as a file.
        model: MuJoCo's model of it.
        frame: Frame of the body in that of the file.
        notes: Parts of the file without effect.
    """

    name: str
    mjcf: Mjcf
    model: Any
    frame: Frame
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Group:
    """Bodies at the top, by number, that are one piece; the base has the shapes of the world, too."""

    tops: tuple[int, ...]
    is_base: bool = False


def split_mjcf(mjcf: Mjcf, *, apart: bool) -> list[Piece]:
    """Split an MJCF file; bodies without shapes are left out.

    Args:
        mjcf: The file.
        apart: Whether bodies at the top with joints to the world are pieces, too; else they are parts of the base.

    Raises:
        RequestRefused: The file is invalid.
    """
    model = compile_mjcf(mjcf)
    groups = _groups(model, apart=apart)
    if len(groups) == 1 and list(groups[0].tops) == tops_of(model):
        return [Piece(_name(model, groups[0]), mjcf, model, xml.ORIGIN)]
    if len(groups) > MAX_BODIES:
        raise xml.invalid(f"found {len(groups)} bodies in the file that move; expected at most {MAX_BODIES}")
    lost = _connections_between(model, groups)
    notes = (LOST.format(count=lost),) if lost else ()
    return [_piece(mjcf, model, group, notes if index == 0 else ()) for index, group in enumerate(groups)]


def _name(model: Any, group: _Group) -> str:
    return BASE if group.is_base else str(model.body(group.tops[0]).name)


def _groups(model: Any, *, apart: bool) -> list[_Group]:
    """Return the pieces of a model, the base first."""
    tops = tops_of(model)
    held = [top for top in tops if not is_free(model, top)]
    joined = _joined(model, held) if apart else [held]
    moving = [group for group in joined if apart and all(_has_joints(model, top) for top in group)]
    base = tuple(sorted({*held} - {top for group in moving for top in group}))
    groups = [_Group((top,)) for top in tops if is_free(model, top)] + [_Group(tuple(group)) for group in moving]
    groups = [group for group in groups if _has_shapes(model, group.tops)]
    groups.sort(key=lambda group: group.tops)
    if shapes_of_world(model) or _has_shapes(model, base):
        groups.insert(0, _Group(base, is_base=True))
    return groups


def _has_joints(model: Any, top: int) -> bool:
    return any(model.body_rootid[body] == top for body in model.jnt_bodyid)


def _has_shapes(model: Any, tops: Sequence[int]) -> bool:
    return any(int(model.body_rootid[body]) in tops for body in model.geom_bodyid)


def _joined(model: Any, tops: Sequence[int]) -> list[list[int]]:
    """Return bodies at the top in groups that equalities and tendons connect."""
    groups = [[top] for top in tops]
    for connected in _connections(model):
        touched = [group for group in groups if connected.intersection(group)]
        if len(touched) > 1:
            groups = [group for group in groups if group not in touched]
            groups.append(sorted(chain.from_iterable(touched)))
    return groups


def _connections(model: Any) -> Iterator[set[int]]:
    """Yield the bodies at the top that each equality and each tendon connects."""
    tendons = [{int(model.body_rootid[body]) for body in _on_tendon(model, t)} for t in range(model.ntendon)]
    yield from tendons
    for index in range(model.neq):
        ends = [int(end[index]) for end in (model.eq_obj1id, model.eq_obj2id) if end[index] >= 0]
        match model.eq_type[index]:
            case EQUALITY.mjEQ_TENDON:
                yield set().union(*(tendons[end] for end in ends))
                continue
            case EQUALITY.mjEQ_JOINT:
                bodies = [model.jnt_bodyid[end] for end in ends]
            case EQUALITY.mjEQ_CONNECT | EQUALITY.mjEQ_WELD:
                is_site = model.eq_objtype[index] == mujoco.mjtObj.mjOBJ_SITE
                bodies = [model.site_bodyid[end] for end in ends] if is_site else ends
            case _:
                continue
        yield {int(model.body_rootid[body]) for body in bodies} - {WORLD}


def _on_tendon(model: Any, tendon: int) -> Iterator[int]:
    start = int(model.tendon_adr[tendon])
    for wrap in range(start, start + int(model.tendon_num[tendon])):
        index = int(model.wrap_objid[wrap])
        match model.wrap_type[wrap]:
            case WRAP.mjWRAP_JOINT:
                yield int(model.jnt_bodyid[index])
            case WRAP.mjWRAP_SITE:
                yield int(model.site_bodyid[index])
            case WRAP.mjWRAP_SPHERE | WRAP.mjWRAP_CYLINDER:
                yield int(model.geom_bodyid[index])


def _connections_between(model: Any, groups: Sequence[_Group]) -> int:
    return sum(
        sum(bool(connected.intersection(group.tops)) for group in groups) > 1 for connected in _connections(model)
    )


def _piece(mjcf: Mjcf, model: Any, group: _Group, notes: tuple[str, ...]) -> Piece:
    spec = mujoco.MjSpec.from_string(mjcf.text, assets=dict(mjcf.assets))
    compile_spec(spec)  # numbers the bodies
    world = spec.worldbody
    unwanted = [body for body in world.bodies if body.id not in group.tops]
    if not group.is_base:
        unwanted += [*world.geoms, *world.sites]
    for element in [*unwanted, *spec.keys, *spec.cameras, *spec.lights]:  # these may look at other bodies
        spec.delete(element)
    names = {body.name for body in spec.bodies}
    for skin in list(spec.skins):
        if skin.file or not names.issuperset(skin.bodyname):  # a file may name any body
            spec.delete(skin)
    _delete_unused_assets(spec)
    frame = xml.ORIGIN
    if len(group.tops) == 1 and not group.is_base:
        [top] = group.tops
        orientation: Quaternion = tuple(model.body_quat[top].tolist())
        frame = (vector(model.body_pos[top]), orientation)
        _centre(next(iter(world.bodies)))
    compiled = compile_spec(spec)
    text = spec.to_xml()
    assets = {name: data for name, data in mjcf.assets.items() if f'"{name}"' in text}
    return Piece(_name(model, group), Mjcf(text, assets), compiled, frame, notes)


def _centre(body: Any) -> None:
    """Move a body at the top to the origin."""
    body.pos, body.quat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    if body.frame is not None:
        body.set_frame(body.parent.add_frame())


def _delete_unused_assets(spec: Any) -> None:
    """Delete meshes, height fields, materials and textures that nothing names any more."""
    geoms = spec.geoms
    used: Mapping[str, set[str]] = {
        "meshes": {geom.meshname for geom in geoms},
        "hfields": {geom.hfieldname for geom in geoms},
        "materials": {each.material for kind in (geoms, spec.sites, spec.tendons, spec.skins) for each in kind},
    }
    for kind, names in used.items():
        for asset in [asset for asset in getattr(spec, kind) if asset.name not in names]:
            spec.delete(asset)
    textures = {name for material in spec.materials for name in material.textures}
    for texture in [texture for texture in spec.textures if texture.name not in textures]:
        spec.delete(texture)
