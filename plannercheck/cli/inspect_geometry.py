"""How many random configurations are valid by a robot's hulls, convex pieces and meshes: `inspect --fidelity`.

In: what the command is asked for. Out: a table. If a state is valid by the meshes and not by other bodies, these bodies
fill hollows. A state that is valid by pieces may collide by the meshes, if a body is within another mesh but between
its pieces, which hold only its triangles. Verdicts by meshes are exact. Caps close open meshes; one more row takes open
meshes as their triangles alone. Pieces are taken only if they come with plannercheck or are cached: CoACD is not run.
"""

from __future__ import annotations

import argparse
import warnings

from plannercheck.bodies.solids import Solid, open_meshes
from plannercheck.cli.common import padding_of, percentage, scene_of, table
from plannercheck.cli.robot_options import described
from plannercheck.motions.checker import Checker
from plannercheck.robots.geometry_choices import of_hulls, of_known_pieces, of_meshes, of_triangles
from plannercheck.robots.robot import Robot


def show_geometries(options: argparse.Namespace) -> None:
    """Prints the table; `options` are those of `inspect`."""
    description = described(options)
    pieces, unknown = of_known_pieces(description)
    robots = {"hulls": of_hulls(description), "pieces": pieces, "meshes": of_meshes(description)}
    if not pieces.pieces:
        del robots["pieces"]
    if robots["meshes"].open_links:
        robots["triangles"] = of_triangles(description)
    checkers = {name: _checker(robot, options) for name, robot in robots.items()}
    q = robots["hulls"].random_configurations(options.states, options.seed)
    valid = {name: checker.check_states(q) for name, checker in checkers.items()}
    rows = []
    for name, by in valid.items():
        counts = (by, valid["meshes"] & ~by, by & ~valid["meshes"])
        rows.append((name, len(checkers[name].pairs), *(percentage(int(each.sum()), len(q)) for each in counts)))
    print(f"\nof {len(q)} random configurations:")
    print(table(("links are", "pairs", "valid", "refused by filling alone", "valid, but meshes collide"), rows))
    if unknown:
        names = ", ".join(unknown)
        print(
            f"as pieces, {names} keep their hulls: their pieces are not shipped, --geometry pieces makes them by CoACD"
        )
    solids = {body.name: body.shape for body in robots["meshes"].bodies if isinstance(body.shape, Solid)}
    if words := open_meshes(solids):
        print(f"as meshes, {words}")
    if (valid["meshes"] & ~valid["hulls"]).any():
        print("--geometry solid takes meshes as they are, --geometry pieces is closer than hulls")


def _checker(robot: Robot, options: argparse.Namespace) -> Checker:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # the checker that is shown has said them
        scene = scene_of(options)
        return Checker(robot, scene, self_collision=not options.no_self_collision, padding=padding_of(options, scene))
