"""Exact collision verdicts for motion planning, for any robot with a URDF.

Convex hulls of links and obstacles are preprocessed once into the hierarchies of Barba and Langerman ("Optimal
detection of intersections between convex polyhedra"); every verdict is that of the given numbers.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from plannercheck.errors import PlannercheckError

if TYPE_CHECKING:
    import plannercheck.ndim as ndim
    import plannercheck.ompl as ompl
    import plannercheck.planar as planar
    import plannercheck.view as view
    from plannercheck.certificates import Separation as Separation
    from plannercheck.certificates import SharedPoint as SharedPoint
    from plannercheck.checker import Checker as Checker
    from plannercheck.decomposition import Decomposition as Decomposition
    from plannercheck.depths import Depth as Depth
    from plannercheck.depths import depth as depth
    from plannercheck.distances import Distance as Distance
    from plannercheck.distances import distance as distance
    from plannercheck.hull import Polytope as Polytope
    from plannercheck.pair import certify as certify
    from plannercheck.pair import intersects as intersects
    from plannercheck.report import ValidityReport as ValidityReport
    from plannercheck.report import Verdict as Verdict
    from plannercheck.robot import Robot as Robot
    from plannercheck.scene import Scene as Scene
    from plannercheck.scene_objects import Part as Part
    from plannercheck.shapes import Box as Box
    from plannercheck.shapes import Capsule as Capsule
    from plannercheck.shapes import Cone as Cone
    from plannercheck.shapes import Cylinder as Cylinder
    from plannercheck.shapes import Hull as Hull
    from plannercheck.shapes import Sphere as Sphere

__version__ = "0.1.0"

# Loaded on first use, so that `import plannercheck` costs nothing that is not needed.
_HOMES = {
    "Box": "shapes",
    "Capsule": "shapes",
    "Checker": "checker",
    "Depth": "depths",
    "Cone": "shapes",
    "Cylinder": "shapes",
    "Decomposition": "decomposition",
    "Distance": "distances",
    "Hull": "shapes",
    "Part": "scene_objects",
    "Polytope": "hull",
    "Robot": "robot",
    "Scene": "scene",
    "Separation": "certificates",
    "SharedPoint": "certificates",
    "Sphere": "shapes",
    "ValidityReport": "report",
    "Verdict": "report",
    "certify": "pair",
    "depth": "depths",
    "distance": "distances",
    "intersects": "pair",
}
_MODULES = ("ndim", "ompl", "planar", "view")

__all__ = [
    "Box",
    "Capsule",
    "Checker",
    "Cone",
    "Cylinder",
    "Decomposition",
    "Depth",
    "Distance",
    "Hull",
    "Part",
    "PlannercheckError",
    "Polytope",
    "Robot",
    "Scene",
    "Separation",
    "SharedPoint",
    "Sphere",
    "ValidityReport",
    "Verdict",
    "__version__",
    "certify",
    "depth",
    "distance",
    "intersects",
    "ndim",
    "ompl",
    "planar",
    "view",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"plannercheck.{name}")
    if name in _HOMES:
        return getattr(importlib.import_module(f"plannercheck.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'plannercheck' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
