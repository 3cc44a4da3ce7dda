"""Proofs of motions of solids: parts of surfaces that cover all pairs of triangles; neither body is in the other."""

import itertools
import json
import warnings
from dataclasses import replace
from fractions import Fraction

import flint
import numpy as np
import pytest
import solid_meshes
from flint import arb_mat
from set_proof_cases import refused, replaced, with_bodies

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common.package_data import shipped_folder
from plannercheck.motions import solid_covers
from plannercheck.motions.proof_model import spatial_order
from plannercheck.proofs import Entry, PosedBody, load_proofs, nesting, save_proofs
from plannercheck.proofs.covers import check_covers
from plannercheck.proofs.entries import EntryChecker
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.nesting import _winding, check_not_nested
from plannercheck.proofs.verify import model_confirmed
from plannercheck.proofs.well_formed import hashes_of

PUZZLES = shipped_folder("configs") / "puzzles"
CUBE = np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
SIDES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]])
SIDES = np.vstack([SIDES, [[0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]])
# Of two cubes, the second one the cavity.
HOLLOW = np.vstack([SIDES, SIDES[:, ::-1] + 8])

CARRIAGE = """<robot name="carriage"><link name="rail"/>
<link name="cube"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="rail"/><child link="cube"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""


def puzzle(robot, scene):
    file = PUZZLES / f"{robot}.yaml"
    return pc.Checker(pc.Robot.load(file), pc.Scene.load(PUZZLES / f"{scene}.yaml", meshes="solid"))


@pytest.fixture(scope="module")
def hook():
    return puzzle("hook", "ring")


@pytest.fixture(scope="module")
def hooks_proof(hook):
    start = hook.scene.start("hook")
    (proof,) = hook.certify_motions(start[None], start[None] + [0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    return proof


def in_parts(proof):
    return sum(bool(entry.first or entry.second) for entry in proof.entries)


@pytest.mark.parametrize("path", ["screw", "slerp"])
@pytest.mark.parametrize(("robot", "scene"), [("hook", "ring"), ("key", "lock")])
def test_motions_of_free_bodies_within_hulls_are_proved(robot, scene, path):
    checker, rng = puzzle(robot, scene), np.random.default_rng(2)
    q0 = np.tile(checker.scene.start(robot), (12, 1))
    q1 = q0.copy()
    q1[:, :3] += 0.03 * rng.normal(size=(12, 3))
    q1[:, 3:] += 0.03 * rng.normal(size=(12, 4))
    q1[:, 3:] /= np.linalg.norm(q1[:, 3:], axis=1)[:, None]
    free = checker.check_motions(q0, q1, path=path)
    assert free.sum() > 3
    proofs = checker.certify_motions(q0, q1, path=path)
    assert [proof is not None for proof in proofs] == free.tolist()
    for proof in proofs:
        assert proof is None or (proof.verify() and in_parts(proof))


def test_motions_of_an_arm_that_hulls_refuse_are_proved():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of open meshes
        checker = pc.Checker(pc.Robot.load("ur10", geometry="solid"))
    start = checker.robot.random_configurations(60, seed=11)
    end = start + 0.1 * np.random.default_rng(1).normal(size=start.shape)
    hulls = pc.Checker(pc.Robot.load("ur10"))
    only_solids = checker.check_motions(start, end) & ~hulls.check_motions(start, end)
    assert only_solids.sum() > 5
    proofs = checker.certify_motions(start[only_solids][:4], end[only_solids][:4])
    assert all(proof.verify() for proof in proofs)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        assert proofs[0].verify("ur10", geometry="solid")
    assert "and none in the files" in proofs[0].verify("ur10").fault
    assert sum(in_parts(proof) > 0 for proof in proofs) >= 2  # of others hulls come within the tolerance


def test_a_proof_is_read_as_it_was_written(hook, hooks_proof, tmp_path):
    for suffix in (".json", ".npz"):
        file = tmp_path / f"hook{suffix}"
        hooks_proof.save(file)
        (again,) = load_proofs(file)
        assert again.entries == hooks_proof.entries
        assert [body.triangles for body in again.model.bodies] == [body.triangles for body in hooks_proof.model.bodies]
        assert again.verify(str(PUZZLES / "hook.yaml"), str(PUZZLES / "ring.yaml"), meshes="solid")
        found = again.verify(str(PUZZLES / "hook.yaml"), str(PUZZLES / "ring.yaml"))
        assert "solids are hook, ring in the proof, and hook in the files" in found.fault


def test_proofs_of_hulls_know_nothing_of_triangles(tmp_path):
    checker = pc.Checker(pc.Robot.load("ur5"), pc.Scene.load("table"))
    q = checker.robot.random_configurations(50, seed=1)
    proof = next(proof for proof in checker.certify_motions(q, q + 0.01) if proof is not None)
    proof.save(tmp_path / "p.json")
    content = json.loads((tmp_path / "p.json").read_text())
    assert all("triangles" not in body for body in content["model"]["bodies"])
    assert all("first" not in entry for entry in content["motions"][0]["entries"])


def test_every_entry_is_needed(hooks_proof):
    for k in range(len(hooks_proof.entries)):
        entries = hooks_proof.entries[:k] + hooks_proof.entries[k + 1 :]
        refused(replaced(hooks_proof, entries=entries), "is not proved on")


def test_parts_that_are_smaller_or_not_there_are_refused(hooks_proof):
    k = next(k for k, entry in enumerate(hooks_proof.entries) if entry.first)
    entry = hooks_proof.entries[k]
    low, high = entry.first
    for part, words in (
        ((low, high - 1), "is not proved on"),
        ((low, 10**6), "is of triangles"),
        ((high, low), "is of triangles"),
        ((low,), "is of triangles"),
    ):
        entries = (*hooks_proof.entries[:k], replace(entry, first=part), *hooks_proof.entries[k + 1 :])
        refused(replaced(hooks_proof, entries=entries), words)
    whole = (*hooks_proof.entries[:k], replace(entry, first=()), *hooks_proof.entries[k + 1 :])
    refused(replaced(hooks_proof, entries=whole), "does not hold")
    balls = (*hooks_proof.entries[:k], replace(entry, by="balls"), *hooks_proof.entries[k + 1 :])
    refused(replaced(hooks_proof, entries=balls), "only planes")


def test_a_part_is_all_of_its_triangles(hooks_proof):
    """Any triangle of a part, moved by itself far to both sides, makes its entry false, and none before or after it."""
    entry = next(e for e in hooks_proof.entries if e.first and e.second and e.first[0] > 0)
    flint.ctx.prec = 64
    assert EntryChecker(hooks_proof).holds(entry)
    for body, (low, high) in zip(hooks_proof.model.pairs[entry.pair], (entry.first, entry.second), strict=True):
        for k in {low, high - 1}:
            assert not all(_holds_with_moved(hooks_proof, entry, body, k, side) for side in (-50.0, 50.0))
    first = hooks_proof.model.pairs[entry.pair][0]
    for k in (entry.first[0] - 1, entry.first[1]):
        assert all(_holds_with_moved(hooks_proof, entry, first, k, side) for side in (-50.0, 50.0))


def _holds_with_moved(proof, entry, body, k, along):
    """Whether an entry holds where a triangle of a body is one of its own, so far along the entry's direction."""
    bodies = list(proof.model.bodies)
    old = bodies[body]
    count = len(old.vertices)
    moved = old.vertices[list(old.triangles[k])] + along * np.array(entry.direction)
    triangles = (*old.triangles[:k], (count, count + 1, count + 2), *old.triangles[k + 1 :])
    bodies[body] = replace(old, vertices=np.vstack([old.vertices, moved]), triangles=triangles)
    return EntryChecker(with_bodies(proof, bodies)).holds(entry)


def test_triangles_are_checked(hooks_proof):
    body = hooks_proof.model.bodies[0]
    beyond = replace(body, triangles=((0, 1, len(body.vertices)), *body.triangles[1:]))
    refused(with_bodies(hooks_proof, [beyond, hooks_proof.model.bodies[1]]), "a corner that there is not")
    twice = replace(body, vertices=np.vstack([body.vertices, body.vertices[:1]]))
    refused(with_bodies(hooks_proof, [twice, hooks_proof.model.bodies[1]]), "has a vertex twice")


def test_changed_planes_are_refused(hooks_proof):
    rng = np.random.default_rng(5)
    for k in rng.permutation(len(hooks_proof.entries))[:12]:
        entry = hooks_proof.entries[k]
        turned = tuple(np.cross(entry.direction, rng.normal(size=3)).tolist())
        for direction in (tuple(-x for x in entry.direction), turned, (0.0, 0.0, 0.0)):
            changed = replace(entry, direction=direction)
            entries = (*hooks_proof.entries[:k], changed, *hooks_proof.entries[k + 1 :])
            refused(replaced(hooks_proof, entries=entries), f"entry {k} does not hold")


def test_swapped_bodies_are_refused(hooks_proof):
    hook, ring = hooks_proof.model.bodies
    swapped = [replace(hook, vertices=ring.vertices, triangles=ring.triangles), ring]
    assert not with_bodies(hooks_proof, swapped).verify()
    model = replace(hooks_proof.model, pairs=tuple((b, a) for a, b in hooks_proof.model.pairs))
    assert not replaced(hooks_proof, model=model, hashes=hashes_of(model)).verify()


def test_bodies_without_some_triangles_are_others(hooks_proof):
    """Under the old hashes the content differs; under its own, the files do."""
    hook, ring = hooks_proof.model.bodies
    for triangles in (ring.triangles[1:], ring.triangles[::-1], ()):
        bodies = (hook, replace(ring, triangles=triangles))
        refused(replaced(hooks_proof, model=replace(hooks_proof.model, bodies=bodies)), "content hashes")
        with_hashes = with_bodies(hooks_proof, bodies)
        found = model_confirmed(with_hashes, str(PUZZLES / "hook.yaml"), str(PUZZLES / "ring.yaml"), "solid")
        assert "has another shape" in found.fault


def test_a_proof_of_another_motion_holds_only_if_that_is_free(hook, hooks_proof):
    """Entries under motions that were not meant: what is verified has no state that collides."""
    rng, seen = np.random.default_rng(8), []
    start, certifier = np.array(hooks_proof.motion.start), hook.motion_certifier
    for _ in range(40):
        end = np.array(hooks_proof.motion.end)
        end[:3] += rng.normal(size=3) * rng.choice([1e-4, 1e-3, 0.02, 0.2])
        motion = replace(hooks_proof.motion, end=tuple(end.tolist()), asked_end=tuple(end.tolist()))
        proved = bool(replaced(hooks_proof, motion=motion).verify())
        free = hook.check_states(certifier.states(start, end, np.linspace(0, 1, 400))).all()
        assert free or not proved
        seen.append((proved, bool(free)))
    assert {(True, True), (False, False)} <= set(seen)


@pytest.fixture
def in_a_cavity(tmp_path):
    """A cube that moves in the cavity of a hollow one."""
    path = tmp_path / "carriage.urdf"
    path.write_text(CARRIAGE)
    (proof,) = carriage_in(HOLLOW, path).certify_motions([[-1.0]], [[1.0]])
    return proof


def carriage_in(triangles, path):
    scene = pc.Scene("shell")
    scene.add("shell", pc.Solid(np.vstack([3 * CUBE, 2 * CUBE]), triangles))
    return pc.Checker(pc.Robot.from_urdf(path), scene)


def test_a_body_in_a_cavity_is_outside(in_a_cavity):
    assert in_a_cavity.verify()
    assert in_parts(in_a_cavity)


@pytest.mark.filterwarnings("ignore:.*open meshes")
@pytest.mark.parametrize("missing", [[0], [0, 1], [12, 17], [0, 1, 12, 13, 20]])
def test_motions_among_capped_solids_are_proved(in_a_cavity, tmp_path, missing):
    """A hollow cube without triangles of its outside or of its cavity; proofs hold the caps, also in files."""
    checker = carriage_in(np.delete(HOLLOW, missing, axis=0), tmp_path / "carriage.urdf")
    (proof,) = checker.certify_motions([[-1.0]], [[1.0]])
    assert in_parts(proof)
    proof.save(tmp_path / "proof.json")
    (again,) = load_proofs(tmp_path / "proof.json")
    assert again.verify()
    checker.scene.save(tmp_path / "shell.yaml")
    assert again.verify(str(tmp_path / "carriage.urdf"), str(tmp_path / "shell.yaml"))
    opened = (tmp_path / "shell.yaml").read_text().replace("triangles:", "open: triangles\n    triangles:", 1)
    (tmp_path / "shell.yaml").write_text(opened)
    assert pc.Scene.load(tmp_path / "shell.yaml").bodies[0].shape.kind == "open"
    found = again.verify(str(tmp_path / "carriage.urdf"), str(tmp_path / "shell.yaml"))
    assert "shell" in found.fault


def test_segments_and_points_wind_about_nothing(in_a_cavity, tmp_path):
    some = [[0, 0, 0], [1, 1, 9], [9, 1, 9], [2, 10, 10]]
    (proof,) = carriage_in(np.vstack([HOLLOW, some]), tmp_path / "carriage.urdf").certify_motions([[-1.0]], [[1.0]])
    assert proof.verify()


@pytest.mark.parametrize(
    ("module", "name", "words"), [(solid_covers, "_MOST_CELLS", "too near to each"), (nesting, "_RAYS", "inside")]
)
def test_pairs_without_a_proof_are_named(in_a_cavity, tmp_path, monkeypatch, module, name, words):
    monkeypatch.setattr(module, name, 0)
    checker = carriage_in(HOLLOW, tmp_path / "carriage.urdf")
    assert checker.check_motion([-1.0], [1.0])
    with pytest.raises(pc.PlannercheckError, match=f"no proof of it was found, since of cube and shell: .*{words}"):
        checker.certify_motions([[-1.0]], [[1.0]])


def test_a_body_inside_is_refused_though_no_surfaces_meet(in_a_cavity):
    """The same surface, the inner part turned over: the body is where it winds twice."""
    rows = [k for k, body in enumerate(in_a_cavity.model.bodies) if body.triangles]
    bodies = list(in_a_cavity.model.bodies)
    shell = bodies[rows[0]]
    inner = {k for t in shell.triangles for k in t if np.abs(shell.vertices[k]).max() < 2.5}
    turned = [t[::-1] if set(t) <= inner else t for t in shell.triangles]
    bodies[rows[0]] = replace(shell, triangles=tuple(turned))
    refused(with_bodies(in_a_cavity, bodies), "is inside 'shell'")


def test_open_surfaces_have_no_inside(in_a_cavity):
    """A cavity without one of its triangles is open."""
    k = next(k for k, body in enumerate(in_a_cavity.model.bodies) if body.triangles)
    shell = in_a_cavity.model.bodies[k]
    some = replace(shell, triangles=shell.triangles[1:])
    identity = arb_mat(4, 4, [int(k % 5 == 0) for k in range(16)])
    check_not_nested(convex_point([0.0, 0.0, 2.5]), identity, some, identity)
    with pytest.raises(UnprovedError, match="inside"):
        check_not_nested(convex_point([0.0, 0.0, 2.5]), identity, shell, identity)


def convex_point(place):
    pose = tuple(float(k % 5 == 0) for k in range(12))
    return PosedBody("point", "point", -1, pose, np.array([place]), 0.0, 0.0, (0.0, 0.0, 0.0), 9.0)


def exact_winding(corners):
    """How often triangles of whole numbers wind about the origin, by an exact ray; None if it meets an edge."""
    ray = [Fraction(3, 7), Fraction(11, 13), Fraction(17, 19)]
    total = 0
    for triangle in corners.tolist():
        a, b, c = ([Fraction(x) for x in row] for row in triangle)
        sides = [determinant(ray, *edge) for edge in ((a, b), (b, c), (c, a))]
        if 0 in sides and not (min(sides) < 0 < max(sides)):
            return None
        if min(sides) > 0 or max(sides) < 0:
            sign = 1 if sides[0] > 0 else -1
            total += sign * (determinant(a, b, c) * sign > 0)
    return total


def determinant(a, b, c):
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])


def test_winding_numbers_are_those_of_fractions():
    points, triangles = solid_meshes.ring(12, 6, 0.3)
    rng, seen = np.random.default_rng(4), set()
    for _ in range(60):
        corners = points[triangles] - rng.uniform(-1.4, 1.4, 3) * [1, 1, 0.3]
        wanted = exact_winding(corners)
        if wanted is not None:
            assert _winding(corners, 1e-12) == wanted
            seen.add(wanted)
    assert len(seen) == 2


def test_points_too_near_to_a_surface_are_not_decided():
    corners = CUBE[SIDES] - [0.999999, 0.1, 0.2]
    assert abs(_winding(corners, 1e-9)) == 1
    with pytest.raises(UnprovedError, match="too near"):
        _winding(corners, 1e-3)


def boxes_of(rng, depth, box):
    """A box cut at random into (start, end, first, second) parts."""
    _, first, second = box
    axes = [0] + [1] * (first[1] - first[0] > 1) + [2] * (second[1] - second[0] > 1)
    if depth == 0 or rng.random() < 0.15:
        return [box]
    axis = int(rng.choice(axes))
    low, high = box[axis]
    cut = (low + high) / 2 if axis == 0 else int(rng.integers(low + 1, high))
    halves = [[*box[:axis], side, *box[axis + 1 :]] for side in ((low, cut), (cut, high))]
    return [part for half in halves for part in boxes_of(rng, depth - 1, half)]


@pytest.mark.parametrize("seed", range(20))
def test_covers_are_those_of_a_grid(seed, hooks_proof):
    """Boxes that tile the whole, some dropped and some made smaller, against a count of what they leave out."""
    rng = np.random.default_rng(seed)
    few = [replace(body, triangles=body.triangles[:8]) for body in hooks_proof.model.bodies]
    model = replace(hooks_proof.model, bodies=tuple(few))
    boxes = boxes_of(rng, 6, [(0.0, 1.0), (0, 8), (0, 8)])
    rng.shuffle(boxes)
    if seed % 2:
        k = int(rng.integers(len(boxes)))
        boxes = boxes[:k] + boxes[k + 1 :] + [boxes[0]]
    boxes += [[(0.25, 0.5), (1, 4), (2, 7)]]
    grid = np.zeros((64, 8, 8), dtype=bool)
    for (start, end), first, second in boxes:
        grid[int(start * 64) : int(end * 64), slice(*first), slice(*second)] = True
    entries = [Entry(0, *time, "plane", -1, (1.0, 0.0, 0.0), first, second) for time, first, second in boxes]
    if grid.all():
        check_covers(model, entries)
    else:
        with pytest.raises(UnprovedError, match="is not proved on"):
            check_covers(model, entries)
    assert grid.all() or seed % 2


def test_halves_of_halves_lie_close_together():
    points, triangles = solid_meshes.ring(32, 12, 0.3)
    triangles = np.random.default_rng(0).permutation(triangles)
    order = spatial_order(points, triangles)
    assert sorted(order.tolist()) == list(range(len(triangles)))
    before, after = (
        [np.ptp(points[part].reshape(-1, 3), axis=0).prod() for part in np.array_split(given, 8)]
        for given in (triangles, triangles[order])
    )
    assert max(after) < 0.3 * min(before)


def test_commands_prove_and_verify_a_puzzle(tmp_path, capsys, hook, hooks_proof):
    where = ["--robot", str(PUZZLES / "hook.yaml"), "--scene", str(PUZZLES / "ring.yaml")]
    solid = ["--scene-meshes", "solid"]
    rows = [list(hooks_proof.motion.start), list(hooks_proof.motion.end)]
    np.save(tmp_path / "path.npy", np.array(rows))
    path = ["--path", str(tmp_path / "path.npy"), "--motion-path", "slerp"]
    assert main(["validate", *where, *solid, *path, "--certify"]) == 0
    file = str(tmp_path / "path.proof.json")
    assert "certified" in capsys.readouterr().out
    assert main(["verify", file]) == 0
    assert main(["verify", file, *where, *solid]) == 0
    assert "confirmed" in capsys.readouterr().out
    assert main(["verify", file, *where]) == 1
    assert main(["verify", file, "--robot", str(PUZZLES / "hook.yaml"), *solid]) == 2
    assert "--scene-meshes counts only with --scene" in capsys.readouterr().err


def test_proofs_of_several_motions_share_their_solids(hook, tmp_path):
    start = hook.scene.start("hook")
    steps = np.arange(3)[:, None] * [0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    proofs = hook.certify_motions(start + steps[:-1], start + steps[1:])
    save_proofs(proofs, tmp_path / "two.json")
    assert all(proof.verify() for proof in load_proofs(tmp_path / "two.json"))
