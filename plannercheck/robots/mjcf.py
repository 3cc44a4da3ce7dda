"""Reads a robot from an MJCF file (MuJoCo's format) through Pinocchio's own parser.

In: a path and the XML's root. Out: a Pinocchio model, its collision geometries, the pairs of bodies that the file
excludes, and those of geometries that their masks keep apart. Pinocchio decides which geoms collide at all (those whose
contype or conaffinity is not 0). What is fixed to the worldbody is an obstacle, not the robot: it is left out, with a
warning. What Pinocchio 4.1 gets wrong is mended or refused: it takes the ranges of sliding joints for degrees, forgets
where a root without joints is, and passes over all roots but the first and over elements that stand for bodies.
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.srdf import DisabledPair

# Elements that stand for bodies or files, and that Pinocchio passes over.
_PASSED_OVER = ("include", "frame", "replicate", "composite", "flexcomp", "attach")

# Joints of one number that slide, by the beginning of Pinocchio's names.
_SLIDING = "JointModelP"


def mjcf_model(path: Path, root: Element, floating: bool) -> pin.Model:
    """Pinocchio's model of an MJCF file; errors name the file."""
    if floating:
        raise PlannercheckError(f"MJCF {path}: give the root body a <freejoint/> for a root that floats")
    with error_context(f"MJCF {path}"):
        _check_elements(root)
        place = _root_placement(root)
        model = _read(path)
        _check_joints(model)
        _mend_ranges(model, root)
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = place * model.jointPlacements[joint]
    for frame in list(model.frames)[1:]:
        if frame.parentJoint == 0:
            frame.placement = place * frame.placement
    return model


def _read(path: Path) -> pin.Model:
    try:
        return pin.buildModelFromMJCF(str(path))
    except Exception as error:  # of several unrelated types
        raise PlannercheckError(f"can't be read: {' '.join(str(error).split()):.400}") from None


def mjcf_geometry(model: pin.Model, path: Path, root: Element) -> pin.GeometryModel:
    """The collision geometries of an MJCF file's bodies, without pairs."""
    place = _root_placement(root)
    try:
        found = pin.buildGeomFromMJCF(_read(path), str(path), pin.COLLISION)
    except Exception as error:  # of several unrelated types
        raise PlannercheckError(f"MJCF {path}: a geom can't be read: {' '.join(str(error).split()):.400}") from None
    kept, of_world = pin.GeometryModel(), []
    for each in found.geometryObjects:
        if model.frames[each.parentFrame].type == pin.FrameType.BODY:
            if each.parentJoint == 0:
                each.placement = place * each.placement
            kept.addGeometryObject(each)
        else:
            of_world.append(each.name)
    if not len(kept.geometryObjects):
        warnings.warn(f"MJCF {path} has no geoms that collide: nothing will ever", RuntimeWarning, stacklevel=6)
    if of_world:
        warnings.warn(
            f"MJCF {path}: {', '.join(of_world)} of the worldbody: left out, since obstacles belong into a scene",
            RuntimeWarning,
            stacklevel=6,
        )
    return kept


def excluded_pairs(root: Element) -> list[DisabledPair]:
    """The pairs of bodies that <contact> excludes."""
    excludes = root.iterfind("contact/exclude")
    return [DisabledPair(each.get("body1", ""), each.get("body2", ""), "excluded by the MJCF") for each in excludes]


def of_meeting_masks(
    pairs: NDArray[np.int64], model: pin.Model, geometry: pin.GeometryModel, root: Element
) -> NDArray[np.int64]:
    """Those of pairs (k, 2) of geometries whose masks meet: one's contype has a bit of the other one's conaffinity.

    Masks count where the file tells them of each geometry of a body; where it does not (an <include>), all bits are
    set, so that more is tested.
    """
    masks = _masks(model, geometry, _Defaults(root))
    first, second = masks[pairs[:, 0]], masks[pairs[:, 1]]
    meet = (first[:, 0] & second[:, 1]) | (second[:, 0] & first[:, 1])
    return np.asarray(pairs[meet != 0])


def _masks(model: pin.Model, geometry: pin.GeometryModel, defaults: _Defaults) -> NDArray[np.int64]:
    """(n, 2) contype and conaffinity of each geometry."""
    masks = np.full((len(geometry.geometryObjects), 2), -1, dtype=np.int64)
    of_body: dict[str, list[int]] = {}
    for k, each in enumerate(geometry.geometryObjects):
        of_body.setdefault(model.frames[each.parentFrame].name, []).append(k)
    for body in defaults.root.iter("body"):
        own = [
            [_bits(defaults.value(geom, key)) for key in ("contype", "conaffinity")] for geom in body.iterfind("geom")
        ]
        colliding = [mask for mask in own if any(mask)]
        places = of_body.get(body.get("name", ""), [])
        if len(places) == len(colliding):
            masks[places] = np.reshape(colliding, (-1, 2))
    return masks


def _bits(text: str | None) -> int:
    """A mask, 1 by default; all bits if it is no number."""
    return 1 if text is None else int(text) if text.strip().isdigit() else -1


def _check_elements(root: Element) -> None:
    """Raises for what Pinocchio passes over without a word."""
    passed_over = next((each.tag for each in root.iter() if each.tag in _PASSED_OVER), None)
    if passed_over is not None:
        raise PlannercheckError(
            f"<{passed_over}> is not read: save the model as MuJoCo has compiled it (mj_saveLastXML)"
        )
    roots = [each.get("name", "") for each in root.iterfind("worldbody/body")]
    if len(roots) != 1:
        raise PlannercheckError(
            f"the worldbody has {len(roots)} bodies ({', '.join(roots)}), of which one would be read: give each robot "
            "a file of its own, and put objects into a scene"
        )


def _root_placement(root: Element) -> pin.SE3:
    """Where the root body is, if no joint moves it: else Pinocchio knows."""
    body = root.find("worldbody/body")
    if body is None or body.find("joint") is not None or body.find("freejoint") is not None:
        return pin.SE3.Identity()
    turned = [key for key in ("euler", "axisangle", "xyaxes", "zaxis") if body.get(key) is not None]
    if turned:
        raise PlannercheckError(f"root body {body.get('name', '')!r}: give its orientation as quat=, not {turned[0]}=")
    try:
        place = np.array((body.get("pos") or "0 0 0").split(), dtype=np.float64).reshape(3)
        w, x, y, z = np.array((body.get("quat") or "1 0 0 0").split(), dtype=np.float64)
    except ValueError:
        raise PlannercheckError(f"root body {body.get('name', '')!r}: pos= needs 3 numbers, quat= 4") from None
    return pin.SE3(pin.Quaternion(w, x, y, z).normalized().toRotationMatrix(), place)


def _check_joints(model: pin.Model) -> None:
    """Raises for joints of one body, taken together, that have a quaternion among their numbers."""
    for name, joint in list(zip(model.names, model.joints, strict=True))[1:]:
        if joint.shortname() == "JointModelComposite" and joint.nq != joint.nv:
            raise PlannercheckError(f"{name!r} holds a ball joint beside others: give it a body of its own")


def _mend_ranges(model: pin.Model, root: Element) -> None:
    """Takes the ranges of sliding joints as lengths, if Pinocchio has taken them for degrees."""
    defaults = _Defaults(root)
    ranges = {joint.get("name", ""): _range(defaults.value(joint, "range")) for joint in root.iter("joint")}
    for joint in list(model.joints)[1:]:
        given = ranges.get(model.names[joint.id])
        if given is None or joint.nq != 1 or not joint.shortname().startswith(_SLIDING):
            continue
        for limits, value in zip((model.lowerPositionLimit, model.upperPositionLimit), given, strict=True):
            if math.isclose(limits[joint.idx_q], math.radians(value), rel_tol=1e-12):
                limits[joint.idx_q] = value


def _range(text: str | None) -> tuple[float, float] | None:
    """Two numbers; None if there are not two."""
    try:
        lower, upper = map(float, (text or "").split())
    except ValueError:
        return None
    return lower, upper


class _Defaults:
    """What elements say themselves, or what their classes say."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self._classes = {each.get("class", "main"): each for each in root.iter("default")}
        self._parents = {child: parent for parent in root.iter() for child in parent}

    def value(self, element: Element, key: str) -> str | None:
        """An attribute of an element; None if nothing gives it."""
        if element.get(key) is not None:
            return element.get(key)
        group: Element | None = self._classes.get(self._class(element), self._classes.get("main"))
        while group is not None and group.tag == "default":
            own = group.find(element.tag)
            if own is not None and own.get(key) is not None:
                return own.get(key)
            group = self._parents.get(group)
        return None

    def _class(self, element: Element) -> str:
        """The element's class, or that of the bodies around it."""
        name, holder = element.get("class"), self._parents.get(element)
        while name is None and holder is not None:
            name, holder = holder.get("childclass"), self._parents.get(holder)
        return name or "main"
