"""Makes the convex pieces that come with plannercheck, and the table of them in README.md, by CoACD.

Run: python robots/pieces/make_pieces.py [--again] [ROBOT ...]: an hour or so for all of them. A mesh that CoACD does
not split within the time limit is kept as its hull.
"""

from __future__ import annotations

import argparse
import re
import warnings
from pathlib import Path

import plannercheck as pc
from plannercheck.bodies.convex_decomposition import made_pieces
from plannercheck.bodies.piece_repair import hull_alone
from plannercheck.bodies.pieces import Pieces, mesh_hash, packed
from plannercheck.bodies.shipped_pieces import PIECES, RECIPE, file_name, shipped_pieces
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.robots.decomposed_links import is_concave
from plannercheck.robots.description import description_of
from plannercheck.robots.loading import collision_meshes

FOLDER = Path(__file__).resolve().parent
# Meshes of too many triangles for CoACD, which makes them anew first: the resolution.
REMESHED = {"torso_0": 30}
# So that states take no longer than with the hull.
MOST_PIECES = {"torso_0": 14}
# Concavity that pieces may have where the usual one fills most of what other links reach.
THRESHOLDS = {"j2s6s200_link_2_0": 0.03}
# Bodies that are kept as their hulls: as pieces, 3 to 37 each and most of them of several links, they take away hardly
# anything of what hulls refuse in random states, for two to six times the time.
HULLS = {
    "pr2": (
        "head_pan_link_0",
        "head_tilt_link_0",
        "l_shoulder_lift_link_0",
        "l_upper_arm_roll_link_0",
        "l_elbow_flex_link_0",
        "l_forearm_roll_link_0",
        "l_gripper_l_finger_link_0",
        "l_gripper_l_finger_tip_link_0",
    ),
    "kinova": ("j2s6s200_link_base_0", "j2s6s200_link_finger_1_0", "j2s6s200_link_finger_tip_1_0"),
}
ROBOTS = ("ur3", "ur5", "ur10", "pr2", "kinova", "baxter")
# TIAGo's meshes are under a licence without derived works: of these, make_recipes.py makes recipes.
BY_RECIPE = ("tiago",)
TABLE = re.compile(r"(<!-- table -->\n).*(<!-- end of table -->\n)", re.DOTALL)
HEADER = "| robot | link | mesh | triangles | pieces | out of the mesh, at most | kB |\n| --- " + "| --- " * 6 + "|\n"


def main() -> None:
    """Makes the files that are missing, and the table of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robots", nargs="*", default=ROBOTS)
    parser.add_argument("--again", action="store_true", help="also make files that there are already")
    parser.add_argument("--time-limit", type=float, default=600.0, metavar="S", help="for one mesh; default: 600 s")
    options = parser.parse_args()
    warnings.simplefilter("ignore", RuntimeWarning)  # meshes that CoACD does not split are in the table
    for robot in options.robots:
        for body, (_, _, mesh) in concave_meshes(robot).items():
            file = FOLDER / file_name(robot, body, mesh_hash(mesh))
            if options.again or not file.exists():
                made = None if body in HULLS.get(robot, ()) else split(mesh, body, options.time_limit)
                pieces = hull_alone(mesh) if made is None or len(made.points) == 1 else made
                file.write_bytes(packed(pieces, mesh_hash(mesh)))
                print(file.name, *row(pieces), flush=True)
    write_table()


def split(mesh: TriangleMesh, body: str, time_limit: float) -> Pieces | None:
    """The pieces of a body's mesh; None if CoACD takes too long."""
    usual = pc.Decomposition()
    asked = pc.Decomposition(
        threshold=THRESHOLDS.get(body, usual.threshold), most_pieces=MOST_PIECES.get(body), time_limit=time_limit
    )
    return made_pieces(mesh, asked, body, REMESHED.get(body))


def concave_meshes(robot: str) -> dict[str, tuple[str, str, TriangleMesh]]:
    """A robot's concave and open meshes by name of the body, equal ones once: link, file, mesh."""
    return {body: found for body, found in meshes(robot).items() if is_concave(found[2])}


def meshes(robot: str) -> dict[str, tuple[str, str, TriangleMesh]]:
    """The same of all meshes."""
    loaded, description = pc.Robot.load(robot, geometry="hull"), description_of(robot)
    links = {body.name: str(body.link) for body in loaded.bodies}
    found: dict[bytes, tuple[str, tuple[str, str, TriangleMesh]]] = {}
    for body, each in collision_meshes(description).items():
        mesh = TriangleMesh.of(each.points, each.triangles)
        found.setdefault(mesh_hash(mesh), (body, (links[body], each.path.name, mesh)))
    return dict(found.values())


def write_table() -> None:
    """Writes what the files hold into README.md."""
    lines = []
    for robot in (*ROBOTS, *BY_RECIPE):
        suffix = RECIPE if robot in BY_RECIPE else PIECES
        for body, (link, name, mesh) in meshes(robot).items():
            file = FOLDER / file_name(robot, body, mesh_hash(mesh), suffix)
            pieces = shipped_pieces(mesh) if file.exists() else None
            if pieces is not None:
                cells = (robot, link, name, len(mesh.triangles), *row(pieces), f"{file.stat().st_size / 1000:.1f}")
                lines.append("| " + " | ".join(map(str, cells)) + " |\n")
    readme = FOLDER / "README.md"
    text = readme.read_text(encoding="utf-8")
    table = HEADER + "".join(lines)
    readme.write_text(TABLE.sub(lambda match: match[1] + table + match[2], text), encoding="utf-8")


def row(pieces: Pieces) -> tuple[str, str]:
    """How many pieces, and how far they stick out."""
    count = len(pieces.points)
    return str(count) if count > 1 else "1, the hull", f"{1e3 * pieces.protrusion:.1f} mm"


if __name__ == "__main__":
    main()
