"""Verdicts of configurations with solids: against coal's meshes, with paddings, at rest, in scenes, after pickling."""

import itertools
import pickle
import warnings

import coal
import numpy as np
import pytest
import trimesh
from pinocchio_geometry import pinocchio_geometry
from poses import at

import plannercheck as pc
from plannercheck.checking.collision_matrix import collision_matrix
from plannercheck.common.core import core
from plannercheck.robots.description import description_of
from plannercheck.validation.fcl_agreement import compare_with_fcl
from plannercheck.validation.fingerprint import content_hash

pytestmark = pytest.mark.filterwarnings("ignore:SRDF", "ignore:.*fixed to the world, touches obstacle")

# Surfaces closer than this to each other are not compared: coal's triangles have tolerances. m.
NEAR = 1e-4
STATES = 1500


def every_link_solid(name):
    links = {str(body.link): "solid" for body in pc.Robot.load(name).bodies}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of open meshes
        return pc.Robot.load(name, geometry=links)


def transform(pose):
    return coal.Transform3s(pose[:3, :3], pose[:3, 3])


@pytest.mark.parametrize("name", ["ur5", "ur10"])
def test_states_against_coals_meshes(name):
    """Surfaces: where one body is wholly inside another, coal says that they are apart."""
    robot, description = every_link_solid(name), description_of(name)
    meshes = [
        each.geometry
        for each in pinocchio_geometry(robot.model, description.urdf, description.package_dirs).geometryObjects
    ]
    checker, hulls = pc.Checker(robot), pc.Checker(pc.Robot.load(name))
    q = robot.random_configurations(STATES, 1)
    ours, poses = checker.colliding_pairs(q), checker.body_poses(q)
    of_hulls = hulls.colliding_pairs(q)
    assert checker.pairs.tolist() == hulls.pairs.tolist()
    assert not (ours & ~of_hulls).any()
    assert (checker.check_states(q) == ~ours.any(axis=1)).all()
    inside = compared = 0
    for row, pair in np.argwhere(of_hulls).tolist():  # where hulls are apart, so are meshes
        a, b = checker.pairs[pair].tolist()
        ends = [transform(poses[row, k]) for k in (a, b)]
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        theirs = bool(coal.collide(meshes[a], ends[0], meshes[b], ends[1], request, result))
        compared += 1
        if theirs != ours[row, pair]:
            first, second = checker.polytopes[a].core, checker.polytopes[b].core
            kind = core.solids_contact(first, poses[row, a], second, poses[row, b])[0]
            assert kind in ("a in b", "b in a") or touch_nearly(meshes, (a, b), ends), (row, pair)
            inside += kind != "apart"
    assert compared > 300
    assert inside > 3
    assert ours.any(axis=1).sum() < 0.9 * of_hulls.any(axis=1).sum()


def touch_nearly(meshes, pair, ends):
    """Whether surfaces are apart, or in each other, by less than NEAR: moved by it along any axis, verdicts differ."""
    verdicts = set()
    for shift in NEAR * np.vstack([np.eye(3), -np.eye(3)]):
        moved = coal.Transform3s(ends[0].getRotation(), ends[0].getTranslation() + shift)
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        verdicts.add(bool(coal.collide(meshes[pair[0]], moved, meshes[pair[1]], ends[1], request, result)))
    return len(verdicts) == 2


# A ball on a rail through a ring whose hull is a disk, in a bowl of a box.
URDF = """<robot name="rail">
  <link name="base"/>
  <link name="ball"><collision><geometry><mesh filename="ball.obj"/></geometry></collision></link>
  <link name="ring"><collision><geometry><mesh filename="ring.obj"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="ball"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="fix" type="fixed"><parent link="base"/><child link="ring"/></joint>
</robot>"""
SRDF = """<robot name="rail"><disable_collisions link1="base" link2="ring" reason="Adjacent"/></robot>"""
RING = trimesh.creation.torus(0.5, 0.2, major_sections=16, minor_sections=8)
ROWS = np.linspace(-1, 1, 201)[:, None]


@pytest.fixture
def rail(tmp_path):
    """A function that makes the robot: a tetrahedron of size 0.1 (its own hull), and a ring."""
    corners = 0.1 * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    ball = trimesh.Trimesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], process=False)
    ball.export(tmp_path / "ball.obj")
    RING.export(tmp_path / "ring.obj")
    (tmp_path / "rail.urdf").write_text(URDF)
    (tmp_path / "rail.srdf").write_text(SRDF)

    def make(geometry="solid"):
        return pc.Robot.from_urdf(tmp_path / "rail.urdf", tmp_path / "rail.srdf", tmp_path, geometry=geometry)

    return make


def test_a_ball_goes_through_the_ring_of_a_solid_only(rail):
    solid, hull = pc.Checker(rail()), pc.Checker(rail("hull"))
    names = [body.name for body in solid.bodies]
    assert solid.polytopes[names.index("ball_0")].solid is None  # it is its hull
    assert solid.polytopes[names.index("ring_0")].solid is not None
    assert solid.check_states([[0], [0.15], [0.5], [0.9]]).tolist() == [True, True, False, True]
    assert not hull.check_states([[0.0]])[0]
    explained = solid.explain([0.5])
    assert [{pair.first, pair.second} for pair in explained.collisions] == [{"ball", "ring"}]
    assert explained.collisions[0].certificate.verify()
    assert solid.first_colliding_pair(ROWS).tolist() == [
        0 if collides else -1 for collides in ~solid.check_states(ROWS)
    ]
    assert [solid.is_valid(row) for row in ROWS] == solid.check_states(ROWS).tolist()


def test_kinematics_of_pinocchio_give_the_same(rail):
    plain = pc.Checker(rail(), kinematics="pinocchio").check_states(ROWS)
    assert plain.tolist() == pc.Checker(rail()).check_states(ROWS).tolist()


def test_switches_do_not_change_verdicts(rail):
    expected = pc.Checker(rail()).check_states(ROWS).tolist()
    for switch in (
        "bounds",
        "boxes",
        "overlaps",
        "learning",
        "reach",
        "static_poses",
        "cached_plane",
        "box_face",
        "trees_first",
    ):
        assert pc.Checker(rail(), tuning=pc.Tuning(**{switch: False})).check_states(ROWS).tolist() == expected
    assert pc.Checker(rail(), tuning=pc.Tuning(method="exact")).check_states(ROWS).tolist() == expected


def test_padding_grows_the_set(rail):
    robot = rail()
    free = [pc.Checker(robot, padding=room).check_states(ROWS) for room in (0.0, 0.02, 0.1)]
    for more, less in itertools.pairwise(free):
        assert not (less & ~more).any()
        assert less.sum() < more.sum()
    assert free[1][100]  # in the middle of the ring
    by_link = pc.Checker(robot, padding={("ball", "ring"): 0.02})
    assert by_link.check_states(ROWS).tolist() == free[1].tolist()


def test_equal_hulls_of_a_solid_and_a_hull_are_prepared_apart(rail):
    scene = pc.Scene("both")
    pose = at(0, 0, 3)
    scene.add("hull", pc.Hull(pc.Solid(RING.vertices, RING.faces).used[0]), pose)  # the very points
    pose[2, 3] = 5
    scene.add("solid", pc.Solid(RING.vertices, RING.faces), pose)
    scene.add("same", pc.Solid(RING.vertices.copy(), RING.faces.copy()), pose)
    checker = pc.Checker(rail(), scene)
    names = [body.name for body in checker.bodies]
    hull, solid, same = (checker.polytopes[names.index(name)] for name in ("hull", "solid", "same"))
    assert hull.solid is None
    assert solid.solid is not None
    assert same is solid


def test_pickled_checkers_keep_their_solids(rail):
    checker = pc.Checker(rail())
    again = pickle.loads(pickle.dumps(checker))
    assert again.check_states(ROWS).tolist() == checker.check_states(ROWS).tolist()
    assert content_hash(again) == content_hash(checker)
    solid, scenes = pc.Solid(RING.vertices, RING.faces), [pc.Scene("same"), pc.Scene("same")]
    scenes[0].add("other", solid)
    scenes[1].add("other", pc.Hull(solid.used[0]))
    assert len({content_hash(pc.Checker(rail("hull"), scene)) for scene in scenes}) == 2


def test_obstacles_that_are_solids(rail):
    scene = pc.Scene("pipe")
    pipe = trimesh.creation.annulus(0.2, 0.3, 4.0)
    turn = trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0])
    scene.add("pipe", pc.Solid(pipe.vertices, pipe.faces), turn)
    robot = rail({"ball": "solid"}).holding({})
    checker = pc.Checker(robot, scene, self_collision=False)
    assert checker.check_states(ROWS).all()  # along the pipe
    scene.move("pipe", np.eye(4))
    assert not checker.with_scene(scene).check_states(ROWS).all()
    filled = pc.Scene("filled")
    filled.add("pipe", pc.Hull(np.asarray(pipe.vertices)), turn)
    assert not pc.Checker(robot, filled, self_collision=False).check_states(ROWS).any()


def test_at_rest_solids_whose_hulls_meet_are_tested(rail):
    """The ring is fixed to the world, and so is an obstacle in its middle."""
    scene = pc.Scene("pin")
    scene.add_sphere("pin", 0.05)
    robots = rail(), rail("hull")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pc.Checker(robots[0], scene)
    with pytest.warns(RuntimeWarning, match="touches obstacle 'pin'"):
        pc.Checker(robots[1], scene)


def test_attached_solids(rail):
    checker = pc.Checker(rail({"ball": "hull"}))
    scene = pc.Scene("carried")
    scene.attach("collar", "ball", None, ("ring",), pc.Solid(RING.vertices, RING.faces))
    pose = np.eye(4)
    scene.add_sphere("post", 0.05, pose)
    carrying = checker.with_scene(scene)
    valid = carrying.check_states(ROWS)
    names = {tuple(sorted(carrying.pair_names(k))) for k in range(len(carrying.pairs))}
    assert ("collar", "post") in names
    column = [k for k in range(len(carrying.pairs)) if set(carrying.pair_names(k)) == {"collar", "post"}]
    collides = carrying.colliding_pairs(ROWS)[:, column].any(axis=1)
    assert not collides[100]  # the post is in the hole
    assert collides[50]
    assert not (valid & collides).any()


def test_solids_inside_one_another_collide(rail):
    """A tetrahedron in the wall of the ring collides, though no surfaces meet."""
    checker = pc.Checker(rail({"ball": "solid", "ring": "solid"}))
    (pair,) = checker.explain(np.array([0.45])).collisions
    assert isinstance(pair.certificate, pc.Enclosure)


def test_matrices_of_pairs_are_of_solids(rail):
    (pair,) = [each for each in collision_matrix(rail(), 300).pairs if {each.link_a, each.link_b} == {"ball", "ring"}]
    (hulls,) = [
        each for each in collision_matrix(rail("hull"), 300).pairs if {each.link_a, each.link_b} == {"ball", "ring"}
    ]
    assert 0 < pair.collisions < hulls.collisions
    assert hulls.at_reference
    assert not pair.at_reference


def test_what_is_not_there_yet_says_so(rail):
    checker = pc.Checker(rail())
    with pytest.raises(pc.PlannercheckError, match=r"FCL is compared with hulls, and 'ring_0' .*something else"):
        compare_with_fcl(checker, ROWS)


def test_pairs_that_trees_decide_are_counted_once(rail):
    for switch in (True, False):
        checker = pc.Checker(rail(), tuning=pc.Tuning(trees_first=switch, bounds=False, boxes=False, overlaps=False))
        checker.check_states(ROWS)
        counted = checker.statistics()
        stages = ("cached_plane", "box_face", "centre_axis", "solver", "nearest_points", "double_double", "exact")
        settled = sum(counted[key] for key in (*stages, "trees", "bounds", "unreachable", "skipped"))
        assert settled == counted["pairs"]
        assert (counted["trees"] > 0) == switch
