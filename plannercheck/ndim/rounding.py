"""Constants of rounding, with their reasons."""

from __future__ import annotations

# Half a unit in the last place of 1.
UNIT = 2.0**-53
# The largest loss to underflow in a filter: entries are at most 1e50, so every lost product is far below.
UNDERFLOW = 1e-250
# Relative sizes below which doubles don't tell a side of a rounded plane; guides only.
FLAT = 1e-13
