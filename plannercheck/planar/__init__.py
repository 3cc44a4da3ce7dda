"""Convex polygons in the plane, and planar robots."""

from __future__ import annotations

from plannercheck.planar.polygons import Counts as Counts
from plannercheck.planar.polygons import count_batch as count_batch
from plannercheck.planar.polygons import intersects as intersects
from plannercheck.planar.polygons import intersects_batch as intersects_batch
