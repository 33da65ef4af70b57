"""What ``<gazebo>`` adds to a URDF: to the whole model, or to the link or joint that it refers to.

Gazebo's own names become the elements of SDF that they stand for. Everything else is SDF already, and moves
as it is into the element that it belongs to.
"""

from __future__ import annotations

from typing import NamedTuple

from lxml import etree

WITHOUT_EFFECT = frozenset(
    {
        "dampingFactor",
        "maxVel",
        "minDepth",
        "fdir1",
        "kp",
        "kd",
        "maxContacts",
        "laserRetro",
        "stopCfm",
        "stopErp",
        "fudgeFactor",
        "provideFeedback",
        "canonicalBody",
        "cfmDamping",
        "implicitSpringDamper",
        "disableFixedJointLumping",
        "preserveFixedJoint",
    }
)
"""Settings of Gazebo's engines, and of how it joins links. They have no meaning here."""
RENAMED = {"selfCollide": "self_collide"}
TRUE, FALSE = ("true", "yes", "1"), ("false", "no", "0")


class Parts(NamedTuple):
    """The model that becomes of a URDF, with its links and its joints by their names."""

    model: etree._Element
    links: dict[str, etree._Element]
    joints: dict[str, etree._Element]


def extend(parts: Parts, extension: etree._Element, name: str) -> list[str]:
    """Add what a ``<gazebo>`` holds. Return what cannot be added. name: stands for the path in sentences."""
    reference = extension.get("reference")
    target = parts.model if not reference else parts.links.get(reference, parts.joints.get(reference))
    if target is None:
        where = f"{name}:{extension.sourceline}"
        return [f'{where}: <gazebo reference="{reference}"> is left out: nothing is called so.']
    for child in list(extension):  # some move
        _add(target, child)
    return []


def _add(target: etree._Element, child: etree._Element) -> None:
    tag, text = str(child.tag), (child.text or "").strip()
    if tag in WITHOUT_EFFECT:
        return
    if tag == "material" and not len(child):
        for visual in target.findall("visual"):
            for own in visual.findall("material"):
                visual.remove(own)
            _path(visual, "material", "script", "name").text = text
    elif tag in ("mu1", "mu2"):
        for collision in target.findall("collision"):
            _path(collision, "surface", "friction", "ode", "mu" if tag == "mu1" else "mu2").text = text
    elif tag == "turnGravityOff":
        _path(target, "gravity").text = "true" if text.lower() in FALSE else "false"
    elif tag in ("static", *RENAMED):
        _path(target, RENAMED.get(tag, tag)).text = "true" if text.lower() in TRUE else "false"
    else:
        target.append(child)


def _path(element: etree._Element, *tags: str) -> etree._Element:
    """Return an element below another one, which is made if it is not there, as those between them."""
    for tag in tags:
        found = element.find(tag)
        if found is None:
            made = etree.SubElement(element, tag)
            made.sourceline = element.sourceline
            found = made
        element = found
    return element
