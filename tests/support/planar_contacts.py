"""Planar motions with contact by construction: the state is chosen first, then something is placed where it touches.

In: a random generator. Out: robots of random trees, a motion, and an obstacle or a second branch that a vertex of the
robot touches at a state on the motion. Poses are computed here, by complex numbers, apart from what is tested.
"""

import cmath
import math
from dataclasses import dataclass

import numpy as np

import plannercheck as pc

P = pc.planar


@dataclass
class Contact:
    """A motion q0 to q1 (nq,) during which two bodies touch at parameter t."""

    robot: P.Robot
    scene: P.Scene
    q0: np.ndarray
    q1: np.ndarray
    t: float


def link_frames(links, q):
    """Per link its turn and place as complex numbers, at a configuration."""
    frames, column = {}, 0
    for link in links:
        x, y, angle = link.anchor
        turn, place = frames[link.parent] if link.parent is not None else (1 + 0j, 0j)
        place, turn = place + turn * complex(x, y), turn * cmath.exp(1j * angle)
        if link.joint == "revolute":
            turn *= cmath.exp(1j * q[column])
        if link.joint == "free":
            place += complex(q[0], q[1])
            turn *= cmath.exp(1j * q[2])
        column += {"fixed": 0, "revolute": 1, "free": 3}[link.joint]
        frames[link.name] = turn, place
    return frames


def posed_vertex(links, link, vertex, q):
    turn, place = link_frames(links, q)[link]
    return place + turn * complex(*vertex)


def some_footprint(generator, size, offset):
    """A triangle or a bar of a size in m, somewhere within an offset of its link's frame."""
    centre = generator.uniform(-offset, offset, 2)
    if generator.random() < 0.5:
        return centre + size * np.array([[-1, -0.02], [1, -0.02], [1, 0.02], [-1, 0.02]])
    return centre + size * np.array([[0, 0], [1, 0.1], [0.3, 0.9]])


def some_tree(generator, size, offset):
    """Links parents first: a root of any kind, then two to four links that hang on any before them."""
    root = str(generator.choice(["free", "free", "revolute", "fixed"]))
    anchor = tuple(generator.uniform(-1, 1, 3)) if generator.random() < 0.7 else (0.0, 0.0, 0.0)
    links = [P.Link("l0", some_footprint(generator, size, offset), anchor=anchor, joint=root)]
    for k in range(1, int(generator.integers(2, 5))):
        parent = f"l{generator.integers(k)}"
        joint = "revolute" if generator.random() < 0.8 else "fixed"
        anchor = tuple(generator.uniform(-2, 2, 3))
        links.append(P.Link(f"l{k}", some_footprint(generator, size, offset), parent, anchor, joint))
    return links


def small_body(at, generator):
    """A triangle with a vertex at a complex point, on a random side of it."""
    size = 10.0 ** generator.uniform(-4, -1)
    way = cmath.exp(1j * generator.uniform(0, 2 * math.pi)) * size
    points = [at, at + way, at + way * (0.6 + 0.5j)]
    return [[p.real, p.imag] for p in points]


def long_bar(at, generator):
    """A bar along an axis, a side or an end of which holds a complex point."""
    length, width = 10.0 ** generator.uniform(-1, 1), 10.0 ** generator.uniform(-4, -1)
    low, high = generator.uniform(0, length), width * float(generator.choice([0, 0, 1]))
    x, y = (-low, length - low), (-high, width - high)
    corners = [complex(x[0], y[0]), complex(x[1], y[0]), complex(x[1], y[1]), complex(x[0], y[1])]
    if generator.random() < 0.5:
        corners = [z.imag + 1j * z.real for z in corners]
    return [[(at + z).real, (at + z).imag] for z in corners]


def grazing_wedge(here, before, after, generator):
    """A wedge beside a vertex's way, on the side to which that bulges; it just holds the place between the others."""
    bend, way = before + after - 2 * here, after - before
    across = way / abs(way) * 1j
    across = -across if (bend * across.conjugate()).real > 0 else across
    thin = 10.0 ** generator.uniform(-4, -1)
    depth = thin * 10.0 ** generator.uniform(-5, -1)
    along = way / abs(way) * 10.0 ** generator.uniform(-4, 0)
    side = here - across * depth
    points = [side, side + along + across * thin, side - along + across * thin]
    return [[p.real, p.imag] for p in points]


def contact_with_obstacle(generator, size, offset, turns):
    """The robot's vertex touches an obstacle at t."""
    links = some_tree(generator, size, offset)
    robot = P.Robot(links)
    moving = [k for k, link in enumerate(links) if moves(links, link)]
    if not moving or robot.nq == 0:
        return None
    q0 = generator.uniform(-1, 1, robot.nq)
    q1 = q0 + generator.normal(size=robot.nq) * turns
    t = float(generator.uniform(0.05, 0.95))
    link = links[int(generator.choice(moving))]
    vertex = np.asarray(link.footprint)[int(generator.integers(len(np.asarray(link.footprint))))]
    here, before, after = (
        posed_vertex(links, link.name, vertex, (1 - s) * q0 + s * q1) for s in (t, t - 1e-5, t + 1e-5)
    )
    scene = P.Scene()
    kind = generator.random()
    if kind < 0.3:
        scene.add_polygon("post", long_bar(here, generator))
    elif abs(after - before) < 1e-12 or kind < 0.6:
        scene.add_polygon("post", small_body(here, generator))
    else:
        scene.add_polygon("post", grazing_wedge(here, before, after, generator))
    return Contact(robot, scene, q0, q1, t)


def moves(links, link):
    """Whether any joint moves a link."""
    by_name = {other.name: other for other in links}
    while link is not None:
        if link.joint != "fixed":
            return True
        link = None if link.parent is None else by_name[link.parent]
    return False


def contact_of_branches(generator, size, offset, turns):
    """A body on a second branch is placed so that it touches the first branch's vertex at t."""
    links = some_tree(generator, size, offset)
    base = links[0].name
    links = [
        *links,
        P.Link("arm", [[5e3, 5e3]], base, tuple(generator.uniform(-1, 1, 3)), "revolute"),
        P.Link("hand", [[5e3, 5e3]], "arm", tuple(generator.uniform(-1, 1, 3)), "revolute"),
    ]
    q_count = sum({"fixed": 0, "revolute": 1, "free": 3}[link.joint] for link in links)
    q0 = generator.uniform(-1, 1, q_count)
    q1 = q0 + generator.normal(size=q_count) * turns
    t = float(generator.uniform(0.05, 0.95))
    q = (1 - t) * q0 + t * q1
    link = links[int(generator.integers(len(links) - 2))]
    outline = np.asarray(link.footprint)
    here = posed_vertex(links, link.name, outline[int(generator.integers(len(outline)))], q)
    turn, place = link_frames(links, q)["hand"]
    seen = (here - place) / turn
    body = np.array(small_body(seen, generator))
    links[-1] = P.Link("hand", body, links[-1].parent, links[-1].anchor, "revolute")
    robot = P.Robot(links)
    first, last = robot.link_index(link.name), robot.link_index("hand")
    if (first, last) not in [(robot.bodies[a].link, robot.bodies[b].link) for a, b in robot.self_pairs()]:
        return None
    return Contact(robot, P.Scene(), q0, q1, t)
