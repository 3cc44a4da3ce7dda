"""The examples run, small."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_convex_regions():
    command = [sys.executable, str(ROOT / "docs/examples/convex_regions.py")]
    small = ["--scene", "empty", "--regions", "4", "--samples", "100", "--check", "200"]
    done = subprocess.run([*command, *small], check=True, capture_output=True, text=True, cwd=ROOT)
    lines = done.stdout.splitlines()
    assert lines[0].split() == ["region", "halfspaces", "colliding", "samples"]
    assert any("pairs share a point" in line for line in lines)
