"""Pairs of bodies held against FCL, with exact arithmetic as the judge.

In: how many pairs, a seed. Out: a Tally: how often FCL erred, by size, flatness and gap, and every verdict
of ours that exact arithmetic refutes.

Bodies are drawn from all families at several sizes and scales; poses put a feature of one over a feature of
the other at a known gap, or are random. Exact arithmetic is asked wherever we differ from FCL or from the
sign of the gap, and now and then everywhere near contact, so that a common error would show too.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from contact_differences import differ_from_contact
from solids import dyadic_poses, random_poses, width
from table import ErrorTable

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.fcl_bodies import FclBodies
from plannercheck.bodies.tuning import Method
from plannercheck.evaluation.campaign.pairs import PairCase
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress import contact_poses as contacts
from plannercheck.evaluation.stress.contact_poses import Points, Solid
from plannercheck.evaluation.stress.sample_bodies import Specimen as Body

# Scales in m, about the size of a body; the last two are far below what FCL is made for.
SCALES = (1.0, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-5)
# Vertices a body, and how often: a big body costs FCL and exact arithmetic far more.
SIZES = (8, 16, 32, 100, 300, 1000, 10_000)
SIZE_WEIGHTS = (5.0, 5.0, 5.0, 5.0, 2.0, 1.0, 0.1)
# Gaps relative to the smaller body's size, either sign; the first is 0.
GAPS = (0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2)
CONTACT_POSES, RANDOM_POSES, DYADIC_POSES = 160, 30, 10
# Exact arithmetic decides every so many pairs even if all agree, and of those that should just touch.
SPOT_CHECK, TOUCHING_CHECK = 50, 4
# Every pair is decided by both.
SOLVERS: tuple[Method, ...] = ("oracle", "walk")
# FCL and we may not differ at all if both bodies are wider than this (m) and |gap| is above this part of the
# smaller width.
WIDE, CLEAR = 0.01, 1e-3


@dataclass(frozen=True)
class Specimen:
    """A body, prepared for us and for the contact poses.

    Attributes:
        solid: Its hull as vertices and triangles.
        polytope: The same, prepared.
    """

    solid: Solid
    polytope: pc.Polytope


@dataclass
class Tally:
    """What a run found.

    Attributes:
        pairs: Pairs decided by us and by FCL.
        decided: Pairs decided by exact arithmetic too.
        table: FCL's errors.
        against_us: Cases where exact arithmetic refutes us.
        clear_errors: FCL's errors on wide bodies with a clear gap, as text.
    """

    pairs: int = 0
    decided: int = 0
    table: ErrorTable = field(default_factory=ErrorTable)
    against_us: list[PairCase[Body]] = field(default_factory=list)
    clear_errors: list[str] = field(default_factory=list)


def run(pairs: int, seed: int) -> Tally:
    """Compares verdicts on about `pairs` pairs."""
    rng = np.random.default_rng(seed)
    tally = Tally()
    while tally.pairs < pairs:
        compare_two(random_specimen(rng), random_specimen(rng), rng, tally)
    return tally


def random_specimen(rng: np.random.Generator) -> Specimen:
    """A body of a random family, size and scale."""
    names = [*families.FAMILIES, "mesh"]
    weights = np.array(SIZE_WEIGHTS) / sum(SIZE_WEIGHTS)
    return specimen(str(rng.choice(names)), int(rng.choice(SIZES, p=weights)), float(rng.choice(SCALES)))


@lru_cache(maxsize=512)
def specimen(name: str, n: int, scale: float) -> Specimen:
    """A family's body at a scale, m."""
    if name == "mesh":
        points = families.mesh_points(families.MESHES[n % len(families.MESHES)])
    else:
        points = families.family(name, n, seed=n)
    polytope = pc.Polytope(points * scale)
    label = f"{name} {len(polytope.vertices)} vertices, {scale} m"
    return Specimen(Solid(label, np.asarray(polytope.vertices), np.asarray(polytope.faces, dtype=np.int64)), polytope)


def compare_two(p: Specimen, r: Specimen, rng: np.random.Generator, tally: Tally) -> None:
    """Compares all poses of two bodies."""
    bodies = FclBodies([(p.solid.vertices, p.solid.faces), (r.solid.vertices, r.solid.faces)])
    for pose_p, pose_r, gap in posed(p.solid, r.solid, rng):
        bodies.place(0, pose_p)
        bodies.place(1, pose_r)
        theirs, ours = bodies.collides(0, 1), verdicts(p, r, pose_p, pose_r)
        tally.pairs += 1
        truth = ours[0]
        if len(set(ours)) > 1 or doubtful(truth, theirs, gap, tally):
            truth = judged(kept_case(p.solid, r.solid, pose_p, pose_r), ours, tally)
        tally.table.add(p.solid, r.solid, gap, truth, theirs)
        if theirs != truth and is_clear(p.solid, r.solid, pose_p, pose_r, gap):
            tally.clear_errors.append(f"{p.solid.name} | {r.solid.name} | gap {gap} | collide {truth}")


def posed(p: Solid, r: Solid, rng: np.random.Generator) -> Iterator[tuple[Points, Points, float]]:
    """Poses of both bodies with the gap in m, NaN if not known."""
    gaps = rng.choice([-1, 1], CONTACT_POSES) * rng.choice(GAPS, CONTACT_POSES) * min(p.size, r.size)
    yield from zip(*contacts.contact_poses(p, r, gaps, rng), gaps.tolist(), strict=True)
    yield from zip(*random_poses(p, r, RANDOM_POSES, rng), [math.nan] * RANDOM_POSES, strict=True)
    yield from zip(*dyadic_poses(p, r, DYADIC_POSES, rng), [0.0] * DYADIC_POSES, strict=True)


def doubtful(ours: bool, theirs: bool, gap: float, tally: Tally) -> bool:
    """Whether exact arithmetic has to decide; a gap below 0 need not mean a collision at a sharp vertex."""
    return ours != theirs or (ours and gap > 0) or tally.pairs % (SPOT_CHECK if gap else TOUCHING_CHECK) == 0


def verdicts(p: Specimen, r: Specimen, pose_p: Points, pose_r: Points) -> list[bool]:
    """Our verdicts by both solvers."""
    return [pc.intersects(p.polytope, r.polytope, pose_p, pose_r, method=method) for method in SOLVERS]


def kept_case(p: Solid, r: Solid, pose_p: Points, pose_r: Points) -> PairCase[Body]:
    """Two solids as a case that can be saved."""
    return PairCase(f"{p.name} | {r.name}", Body(p.name, p.vertices), Body(r.name, r.vertices), pose_p, pose_r)


def judged(case: PairCase[Body], ours: list[bool], tally: Tally) -> bool:
    """The exact verdict, noted if it goes against any of ours."""
    question = case.p.points, case.r.points, case.pose_p, case.pose_r
    certificate = exact.decide(*question)
    truth = isinstance(certificate, exact.ExactSharedPoint)
    tally.decided += 1
    if set(ours) != {truth}:
        assert exact.holds(certificate, *question)
        tally.against_us.append(case)
    return truth


def is_clear(p: Solid, r: Solid, pose_p: Points, pose_r: Points, gap: float = math.nan) -> bool:
    """Whether both bodies are wide and the gap between them, or their overlap, is far from 0.

    A known gap below 0 bounds the overlap; one above 0 is the distance.
    """
    clear = CLEAR * min(width(p), width(r))
    if min(width(p), width(r)) <= WIDE or abs(gap) <= clear:
        return False
    return differ_from_contact(p, r, pose_p, pose_r, clear)
