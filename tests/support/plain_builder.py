"""Honest proofs in plain JSON, made with nothing of plannercheck: own kinematics, own planes, own hashes.

In: a generator. Out: the document of a proof of a random motion of a random arm among obstacles: hulls, solids and
clouds. A plane is taken where samples keep clear of it by twice what they leave their chord, so that an interval that
is honestly proved is refused only by a fault of the verifier.
"""

import hashlib
import itertools
import struct

import numpy as np

CORNERS = np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
SIDES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
SIDES += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
MARGIN = 1e-9
SAMPLES = 17


def turned(axis, angle):
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def placement(rng, reach):
    axis = rng.normal(size=3)
    pose = np.eye(4)
    pose[:3, :3] = turned(axis / np.linalg.norm(axis), rng.uniform(-3, 3))
    pose[:3, 3] = rng.uniform(-reach, reach, 3)
    return pose


def body(rng, name, link, pose):
    """A box as hull, solid or boxes of a set; or a ball, or a cloud."""
    kind = rng.choice(["hull", "solid", "ball", "balls", "boxes"])
    points, own, radius = CORNERS * rng.uniform(0.03, 0.12, 3), {}, 0.0
    if kind == "solid":
        own["triangles"] = SIDES
    elif kind == "ball":
        points, radius = np.zeros((1, 3)), 0.08
    elif kind == "balls":
        points, own = rng.uniform(-0.1, 0.1, (6, 3)), {"parts": "balls", "radii": rng.uniform(0.01, 0.03, 6).tolist()}
    elif kind == "boxes":
        points, own = np.sort(rng.uniform(-0.1, 0.1, (3, 2, 3)), axis=1).reshape(-1, 3), {"parts": "boxes"}
    reach = float(np.linalg.norm(points, axis=1).max()) * 1.001 + 1e-9
    return {
        "name": name,
        "label": name,
        "link": link,
        "pose": pose[:3].ravel().tolist(),
        "vertices": points.tolist(),
        "radius": radius,
        "padding": 0.0,
        "centre": [0.0] * 3,
        "reach": reach,
        **own,
    }


def poses(model, q):
    """World poses of all bodies and links at a configuration."""
    joints = []
    for joint in model["joints"]:
        pose, value = np.eye(4), q[joint["columns"][0]] * joint["multipliers"][0] + joint["offsets"][0]
        if joint["kind"] == "turn":
            pose[:3, :3] = turned(joint["axis"], value)
        else:
            pose[:3, 3] = value * np.array(joint["axis"])
        above = joints[joint["parent"]] if joint["parent"] >= 0 else np.eye(4)
        joints.append(above @ whole(joint["placement"]) @ pose)
    links = [joints[link["joint"]] @ whole(link["placement"]) for link in model["links"]]
    on = [(links[each["link"]] if each["link"] >= 0 else np.eye(4)) @ whole(each["pose"]) for each in model["bodies"]]
    return on, links


def whole(rows):
    return np.vstack([np.reshape(rows, (3, 4)), [0, 0, 0, 1.0]])


def pieces(each):
    """The convex pieces of a body, as (range, points, radius)."""
    points = np.array(each["vertices"])
    if "triangles" in each:
        return [((k, k + 1), points[face], 0.0) for k, face in enumerate(each["triangles"])]
    if each.get("parts") == "balls":
        return [((k, k + 1), points[k : k + 1], radius) for k, radius in enumerate(each["radii"])]
    if each.get("parts") == "boxes":
        boxes = points.reshape(-1, 2, 3)
        return [((k, k + 1), np.where(CORNERS > 0, high, low), 0.0) for k, (low, high) in enumerate(boxes)]
    return [((), points, 0.0)]


def between(a, b):
    """About the shortest vector from points b to points a, by Gilbert's steps towards the lowest corner."""
    near = a.mean(axis=0) - b.mean(axis=0)
    for _ in range(200):
        corner = a[(a @ near).argmin()] - b[(b @ near).argmax()]
        way = corner - near
        length = way @ way
        if length < 1e-18:
            break
        near = near + np.clip(-(near @ way) / length, 0, 1) * way
    return near


class Motion:
    """A straight motion of a model; `at` has the poses of bodies and links by parameter."""

    def __init__(self, model, start, end):
        self.model, self.start, self.end, self._known = model, start, end, {}

    def at(self, t):
        if t not in self._known:
            self._known[t] = poses(self.model, (1 - t) * self.start + t * self.end)
        return self._known[t]


def entries_of(motion, pair, generator):
    """Entries that keep a pair apart; None if that is not found."""
    a, b = motion.model["pairs"][pair]
    bodies = motion.model["bodies"]
    out = []
    for (one, p, r), (two, q, s) in itertools.product(pieces(bodies[a]), pieces(bodies[b])):
        needed = bodies[a]["radius"] + bodies[b]["radius"] + r + s + MARGIN
        frame = int(generator.choice([-1, bodies[a]["link"], bodies[b]["link"]]))
        cells = [(0.0, 1.0, 0)]
        while cells:
            low, high, depth = cells.pop()
            direction = plane(motion, (a, p), (b, q), needed, frame, (low, high))
            if direction is None and depth >= 9:
                return None
            if direction is None:
                middle = (low + high) / 2
                cells += [(middle, high, depth + 1), (low, middle, depth + 1)]
                continue
            entry = {"pair": pair, "start": low, "end": high, "by": "plane", "frame": frame, "direction": direction}
            out.append({**entry, **({"first": one} if one else {}), **({"second": two} if two else {})})
    return out


def plane(motion, first, second, needed, frame, span):
    """A direction of the frame that keeps pieces apart by twice what samples leave their chord, or None."""
    (a, p), (b, q) = first, second
    seen = []
    for t in np.linspace(*span, SAMPLES):
        on, links = motion.at(t)
        to = np.linalg.inv(links[frame]) if frame >= 0 else np.eye(4)
        seen.append([points @ (to @ on[k])[:3, :3].T + (to @ on[k])[:3, 3] for k, points in ((a, p), (b, q))])
    direction = between(*seen[SAMPLES // 2])
    length = np.linalg.norm(direction)
    if length < 1e-9:
        return None
    direction = direction / length
    heights = [np.array([side @ direction for side in sides]) for sides in zip(*seen, strict=True)]
    part = np.linspace(0, 1, SAMPLES)[:, None]
    off = sum(float(np.abs(h - (1 - part) * h[0] - part * h[-1]).max()) for h in heights)
    gap = float((heights[0].min(axis=1) - heights[1].max(axis=1)).min())
    return direction.tolist() if gap > needed + 2 * off + 1e-6 else None


def document(seed):
    """The document of a proof; None if the motion that was drawn comes too near to something."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 4))
    joints, links, bodies = [], [], []
    for k in range(count):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        joints.append(
            {
                "name": f"j{k}",
                "kind": str(rng.choice(["turn", "turn", "slide"])),
                "parent": k - 1,
                "placement": placement(rng, 0.4)[:3].ravel().tolist(),
                "axis": axis.tolist(),
                "columns": [k],
                "multipliers": [float(rng.choice([1.0, -1.0, 0.5]))],
                "offsets": [float(rng.uniform(-0.5, 0.5))],
            }
        )
        links.append({"name": f"l{k}", "joint": k, "placement": placement(rng, 0.1)[:3].ravel().tolist()})
        bodies.append(body(rng, f"l{k}_0", k, placement(rng, 0.1)))
    bodies += [body(rng, f"o{k}", -1, placement(rng, 0.8)) for k in range(2)]
    pairs = [[a, b] for a in range(count) for b in range(max(a + 2, count), len(bodies))]
    model = {"joints": joints, "links": links, "bodies": bodies, "pairs": pairs, "whole_turns": [], "columns": count}
    start = rng.uniform(-1.5, 1.5, count)
    motion = Motion(model, start, start + rng.uniform(-0.6, 0.6, count))
    entries = []
    for pair in range(len(pairs)):
        found = entries_of(motion, pair, rng)
        if found is None:
            return None
        entries += found
    ends = {"start": start.tolist(), "end": motion.end.tolist(), "asked_end": motion.end.tolist()}
    return {
        "format": "plannercheck motion proof",
        "version": 1,
        "kind": "space",
        "robot": "arm",
        "scene": "plain",
        "hashes": hashes(model),
        "model": model,
        "motions": [{"motion": ends, "margin": MARGIN, "entries": entries}],
    }


# ----- hashes, as the format has them

FIELDS = {
    "Joint": ("name", "kind", "parent", "placement", "axis", "columns", "multipliers", "offsets"),
    "Link": ("name", "joint", "placement"),
    "PosedBody": (
        *("name", "label", "link", "pose", "vertices", "radius", "padding", "centre", "reach"),
        *("triangles", "parts", "radii"),
    ),
    "Model": ("joints", "links", "bodies", "pairs", "whole_turns", "columns"),
}
KINDS = {"joints": "Joint", "links": "Link", "bodies": "PosedBody"}


def packed(value, kind=None, name=None):
    """The bytes of a value that are hashed."""
    if isinstance(value, dict):
        return f"{kind} ".encode() + b"".join(
            packed(value[key], KINDS.get(key), key) for key in FIELDS[kind] if key in value
        )
    if name in ("vertices", "radii"):
        array = np.array(value)
        return f"array {array.shape} ".encode() + array.tobytes()
    if isinstance(value, list):
        return f"list {len(value)} ".encode() + b"".join(packed(part, kind) for part in value)
    if isinstance(value, float):
        return b"float" + struct.pack("<d", value)
    return f"int {value} ".encode() if isinstance(value, int) else f"text {len(value)} {value}".encode()


def hashes(model):
    """The hashes of robot, scene and model."""
    mounted = [each for each in model["bodies"] if each["link"] >= 0]
    standing = [each for each in model["bodies"] if each["link"] < 0]
    robot = packed(model["joints"], "Joint") + packed(model["links"], "Link") + packed(mounted, "PosedBody")
    given = {"robot": robot, "scene": packed(standing, "PosedBody"), "model": packed(model, "Model")}
    return {name: hashlib.sha256(content).hexdigest() for name, content in given.items()}
