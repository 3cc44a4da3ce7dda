"""Convex polygons in the plane, and planar robots."""

from __future__ import annotations

from plannercheck.planar.certificates import Separation as Separation
from plannercheck.planar.certificates import SharedPoint as SharedPoint
from plannercheck.planar.certificates import certify as certify
from plannercheck.planar.polygons import Counts as Counts
from plannercheck.planar.polygons import Polygons as Polygons
from plannercheck.planar.polygons import count_batch as count_batch
from plannercheck.planar.polygons import intersects as intersects
from plannercheck.planar.polygons import intersects_batch as intersects_batch
