"""Convex polygons in the plane, and planar robots among them: the interface of `plannercheck` with one dimension less.

Read `polygons` first (whether two polygons share a point) with `certificates`, then `robot` and `scene` with `links`
and `robot_files`, and `checker` (verdicts on configurations and motions) with `body_tables`, `motion_certifier` and
`motion_sampling`. `curves` takes Dubins and Reeds-Shepp curves apart, and `curve_motions` describes motions on them.
`pieces` and `convexity` split outlines and check them. `proof_builder` makes proofs of motions, and
`proof_confirmation` compares their models with files.
"""

from __future__ import annotations

from plannercheck.planar.certificates import Separation as Separation
from plannercheck.planar.certificates import SharedPoint as SharedPoint
from plannercheck.planar.certificates import certify as certify
from plannercheck.planar.checker import Checker as Checker
from plannercheck.planar.links import Link as Link
from plannercheck.planar.pieces import convex_pieces as convex_pieces
from plannercheck.planar.polygons import Counts as Counts
from plannercheck.planar.polygons import Polygons as Polygons
from plannercheck.planar.polygons import count_batch as count_batch
from plannercheck.planar.polygons import intersects as intersects
from plannercheck.planar.polygons import intersects_batch as intersects_batch
from plannercheck.planar.robot import Robot as Robot
from plannercheck.planar.scene import Scene as Scene
from plannercheck.planar.scene import pose_of as pose_of
