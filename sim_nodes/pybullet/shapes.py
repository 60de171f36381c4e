"""Links of one shape each.

What Bullet restores of a saved state are the contacts of one pair of shapes for each pair of links. So every other
shape of a link goes into a link of its own, without a mass, that is fixed to it.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

SPECK = "1e-5 1e-5 1e-5"  # [m] edges of what is seen of an added link; without, Bullet draws what collides


def split_links(root: Element) -> dict[str, str]:
    """Give every shape of a URDF that collides a link of its own; returns the links by those that were added."""
    added = {}
    for link in root.findall("link"):
        name = link.get("name", "")
        for index, collision in enumerate(link.findall("collision")[1:], 1):
            part = f"{name}#{index}"
            link.remove(collision)
            _add(root, link, part).append(collision)
            added[part] = name
    return added


def _add(root: Element, link: Element, name: str) -> Element:
    """Fix a link without a mass to another."""
    new = SubElement(root, "link", name=name)
    inertial = SubElement(new, "inertial")
    SubElement(inertial, "mass", value="0")
    SubElement(inertial, "inertia", ixx="0", iyy="0", izz="0", ixy="0", ixz="0", iyz="0")
    if link.find("visual") is not None:
        SubElement(SubElement(SubElement(new, "visual"), "geometry"), "box", size=SPECK)
    joint = SubElement(root, "joint", name=name, type="fixed")
    SubElement(joint, "parent", link=link.get("name", ""))
    SubElement(joint, "child", link=name)
    return new
