"""Proofs of motions in the plane with one number changed beyond its slack: none is confirmed."""

import math
from dataclasses import replace

import numpy as np
import pytest
from planar_contacts import link_frames
from planar_motions import states_of
from planar_proof_cases import SHIPPED, P, changed, free_motions, kinds, rehashed, shipped


def seen_from(proof, frame, body, q):
    """Vertices (n,) as complex numbers from a frame, by kinematics of our own."""
    given = proof.model.bodies[body]
    points = given.vertices @ [1, 1j]
    if given.link < 0:
        m = np.reshape(given.pose, (2, 3))
        points = (given.vertices @ m[:, :2].T + m[:, 2]) @ [1, 1j]
        turn, origin = 1, 0
    else:
        turn, origin = frames_of(proof, q)[given.link]
    world = origin + turn * points
    if frame < 0:
        return world
    turn, origin = frames_of(proof, q)[frame]
    return (world - origin) / turn


def frames_of(proof, q):
    links = [
        P.Link(
            link.name, [[0, 0]], None if link.parent < 0 else str(link.parent), (link.x, link.y, link.angle), link.joint
        )
        for link in (replace(link, name=str(k)) for k, link in enumerate(proof.model.links))
    ]
    return list(link_frames(links, q).values())


def separates(proof, entry, direction, states):
    """Whether a direction keeps a pair apart at states of the motion."""
    a, b = proof.model.pairs[entry.pair]
    d = complex(*direction).conjugate()
    gaps = [
        (d * seen_from(proof, entry.frame, a, q)).real.min() - (d * seen_from(proof, entry.frame, b, q)).real.max()
        for q in states
    ]
    return min(gaps) > 0


def with_other_direction(proof, generator, checker, states_at):
    rows = [k for k, entry in enumerate(proof.entries) if entry.by == "plane"]
    for _ in range(40):
        k = int(generator.choice(rows))
        entry, axis = proof.entries[k], int(generator.integers(2))
        direction = changed(entry.direction, axis, entry.direction[axis] + float(generator.normal() * 2))
        states = states_at(np.linspace(entry.start, entry.end, 5))
        if not separates(proof, entry, direction, states):
            assert separates(proof, entry, entry.direction, states)
            return replace(proof, entries=changed(proof.entries, k, replace(entry, direction=direction)))
    return None


def with_other_interval(proof, generator, *_):
    k = int(generator.integers(len(proof.entries)))
    entry, side = proof.entries[k], str(generator.choice(["start", "end"]))
    moved = getattr(entry, side) + float(generator.choice([1e-3, -1e-3, 2.0**-50, -(2.0**-50), 1.0]))
    return replace(proof, entries=changed(proof.entries, k, replace(entry, **{side: moved})))


def with_other_frame(proof, generator, *_):
    rows = [k for k, entry in enumerate(proof.entries) if entry.by == "plane"]
    k = int(generator.choice(rows))
    others = [frame for frame in range(-2, len(proof.model.links) + 1) if frame != proof.entries[k].frame]
    entry = replace(proof.entries[k], frame=int(generator.choice(others)))
    return replace(proof, entries=changed(proof.entries, k, entry))


def with_other_pair(proof, generator, *_):
    k = int(generator.integers(len(proof.entries)))
    others = [pair for pair in range(-1, len(proof.model.pairs) + 1) if pair != proof.entries[k].pair]
    return replace(
        proof, entries=changed(proof.entries, k, replace(proof.entries[k], pair=int(generator.choice(others))))
    )


def without_a_pair(proof, generator, *_):
    pair = int(generator.integers(len(proof.model.pairs)))
    return replace(proof, entries=tuple(entry for entry in proof.entries if entry.pair != pair))


def without_an_entry(proof, generator, *_):
    k = int(generator.integers(len(proof.entries)))
    return replace(proof, entries=(*proof.entries[:k], *proof.entries[k + 1 :]))


def with_other_pair_table(proof, generator, *_):
    """Fewer pairs than the hashes say."""
    pairs = proof.model.pairs[:-1]
    entries = tuple(entry for entry in proof.entries if entry.pair < len(pairs))
    return replace(proof, model=replace(proof.model, pairs=pairs), entries=entries)


def with_other_vertex(proof, generator, *_):
    """Unnoticed by the hashes: only these tell."""
    k = int(generator.integers(len(proof.model.bodies)))
    vertices = np.array(proof.model.bodies[k].vertices)
    vertices[tuple(generator.integers(vertices.shape))] += 1e-9
    bodies = changed(proof.model.bodies, k, replace(proof.model.bodies[k], vertices=vertices))
    return replace(proof, model=replace(proof.model, bodies=bodies))


def with_a_vertex_in_another_body(proof, generator, checker, states_at):
    """Model and hashes agree, but two bodies meet on the motion."""
    k = int(generator.integers(len(proof.model.pairs)))
    a, b = proof.model.pairs[k]
    body, (q,) = proof.model.bodies[a], states_at(generator.uniform(0, 1, 1))
    turn, origin = frames_of(proof, q)[body.link]
    point = (seen_from(proof, -1, b, q).mean() - origin) / turn
    vertices = np.vstack([body.vertices, [point.real, point.imag]])
    reach = float(np.hypot(*(vertices - body.centre).T).max()) * (1 + 1e-9)
    bodies = changed(proof.model.bodies, a, replace(body, vertices=vertices, reach=reach))
    return replace(rehashed(proof, replace(proof.model, bodies=bodies)), margin=proof.margin * 100)


def with_a_small_circle(proof, generator, *_):
    k = int(generator.integers(len(proof.model.bodies)))
    body = proof.model.bodies[k]
    smaller = replace(body, reach=body.reach * 0.999) if body.reach > 0 else replace(body, reach=-1.0)
    return rehashed(proof, replace(proof.model, bodies=changed(proof.model.bodies, k, smaller)))


def with_other_end(proof, generator, *_):
    column = int(generator.integers(proof.model.columns))
    value = proof.motion.end[column] + float(generator.choice([1e-6, -1e-3, 0.1, math.pi]))
    return replace(proof, motion=replace(proof.motion, end=changed(proof.motion.end, column, value)))


def with_colliding_start(proof, generator, checker, *_):
    """Another start, from which the motion collides."""
    for _ in range(200):
        column = int(generator.integers(proof.model.columns))
        value = proof.motion.start[column] + float(generator.normal() * 3)
        start = changed(proof.motion.start, column, value)
        parts = np.linspace(0, 1, 101)[:, None]
        states = (1 - parts) * np.array(start) + parts * np.array(proof.motion.end)
        if proof.motion.curve != "straight" or not checker.check_states(states).all():
            return replace(proof, motion=replace(proof.motion, start=start))
    return None


def with_other_margin(proof, generator, *_):
    return replace(proof, margin=float(generator.choice([proof.margin / 4, 0.0, -1.0, 1e3, math.nan, math.inf])))


def with_other_piece(proof, generator, *_):
    if not proof.motion.pieces:
        return None
    k = int(generator.integers(len(proof.motion.pieces)))
    piece = proof.motion.pieces[k]
    name = str(generator.choice(["start", "end", "origin", "way", "heading", "turn", "arm", "slip"]))
    value, by = getattr(piece, name), float(generator.choice([-1, 1]) * 10.0 ** generator.uniform(-2, 0))
    if name == "slip":
        value += 1e3
    elif isinstance(value, tuple):
        axis = int(generator.integers(2))
        value = changed(value, axis, value[axis] + by)
    else:
        value += by
    return replace(
        proof, motion=replace(proof.motion, pieces=changed(proof.motion.pieces, k, replace(piece, **{name: value})))
    )


def with_other_radius(proof, generator, *_):
    radius = proof.motion.turning_radius * 1.001 if proof.motion.pieces else 1.0
    return replace(proof, motion=replace(proof.motion, turning_radius=radius))


MUTATIONS = [
    with_other_direction,
    with_other_interval,
    with_other_frame,
    with_other_pair,
    without_a_pair,
    without_an_entry,
    with_other_pair_table,
    with_other_vertex,
    with_a_vertex_in_another_body,
    with_a_small_circle,
    with_other_end,
    with_colliding_start,
    with_other_margin,
    with_other_piece,
    with_other_radius,
]


@pytest.fixture(scope="module")
def proved():
    """Checkers with proofs of all kinds."""
    out = []
    for robot, scene, radius in SHIPPED:
        checker = shipped(robot, scene)
        for kind in kinds(radius):
            out += [(checker, kind, *case) for case in free_motions(checker, 5, 7, 0.4, **kind)]
    return out


@pytest.mark.parametrize("mutation", MUTATIONS)
def test_a_changed_number_is_refused(proved, mutation):
    generator, refused = np.random.default_rng(8), 0
    for checker, kind, q0, q1, proof in proved:
        how = (kind.get("curve", "straight"), kind.get("turning_radius"))
        mutant = mutation(proof, generator, checker, lambda t, *a: states_of(checker, q0, q1, np.asarray(t), how))  # noqa: B023
        if mutant is None:
            continue
        found = mutant.verify()
        assert not found, (mutation.__name__, how)
        assert found.fault
        refused += 1
    assert refused >= (25 if mutation is with_other_piece else 40)


def test_malformed_proofs_are_refused_not_crashed(proved):
    proof = proved[0][-1]
    entry = proof.entries[0]
    bad = [
        replace(proof, entries=()),
        replace(proof, entries=changed(proof.entries, 0, replace(entry, by="magic"))),
        replace(proof, entries=changed(proof.entries, 0, replace(entry, by="plane", direction=(0.0, 0.0)))),
        replace(proof, entries=changed(proof.entries, 0, replace(entry, by="plane", direction=(math.nan, 1.0)))),
        replace(proof, entries=changed(proof.entries, 0, replace(entry, by="plane", direction=(1.0,)))),
        replace(proof, motion=replace(proof.motion, start=proof.motion.start[:-1])),
        replace(proof, motion=replace(proof.motion, start=(math.inf, *proof.motion.start[1:]))),
        replace(proof, motion=replace(proof.motion, curve="clothoid")),
        rehashed(proof, replace(proof.model, pairs=((0, 0),))),
        rehashed(proof, replace(proof.model, links=())),
        rehashed(proof, replace(proof.model, whole_turns=(0,))),
    ]
    for mutant in bad:
        assert not mutant.verify()
        assert mutant.verify().fault
