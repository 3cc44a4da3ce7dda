"""Arrays and objects of trimesh, coal and python-fcl are bodies: where their own libraries have them."""

import coal
import fcl
import numpy as np
import pinocchio
import pytest
import trimesh
from poses import at

import plannercheck as pc
from plannercheck.bodies.given_bodies import given_polytope
from plannercheck.bodies.given_shapes import given_shape
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, Hull, Sphere

CUBE = np.indices((2, 2, 2)).reshape(3, 8).T * 1.0
TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])

# Points closer than this to a surface are not compared: libraries differ there by their tolerances, and cylinders and
# cones are the polytopes around them. m.
NEAR = 2e-3


def coal_points(points):
    listed = coal.StdVec_Vec3s()
    for point in points:
        listed.append(point)
    return listed


def coal_hull():
    return coal.Convex.convexHull(coal_points(CUBE), True, "Qt")


COAL = {
    "box": (coal.Box(0.4, 0.6, 0.8), Box((0.4, 0.6, 0.8))),
    "sphere": (coal.Sphere(0.5), Sphere(0.5)),
    "capsule": (coal.Capsule(0.2, 0.6), Capsule(0.2, 0.6)),
    "cylinder": (coal.Cylinder(0.3, 0.8), Cylinder(0.3, 0.8)),
    "cone": (coal.Cone(0.4, 0.8), Cone(0.4, 0.8)),
}
FCL = {
    "box": (fcl.Box(0.4, 0.6, 0.8), Box((0.4, 0.6, 0.8))),
    "sphere": (fcl.Sphere(0.5), Sphere(0.5)),
    "capsule": (fcl.Capsule(0.2, 0.6), Capsule(0.2, 0.6)),
    "cylinder": (fcl.Cylinder(0.3, 0.8), Cylinder(0.3, 0.8)),
    "cone": (fcl.Cone(0.4, 0.8), Cone(0.4, 0.8)),
}


def coal_distance(geometry, point):
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    here, there = coal.Transform3s(), coal.Transform3s()
    there.setTranslation(point)
    return coal.distance(geometry, here, coal.Sphere(1e-9), there, request, result)


def fcl_touches(geometry, point, radius):
    request, result = fcl.CollisionRequest(), fcl.CollisionResult()
    there = fcl.CollisionObject(fcl.Sphere(radius), fcl.Transform(point))
    return fcl.collide(fcl.CollisionObject(geometry), there, request, result) > 0


@pytest.mark.parametrize("name", COAL)
def test_coals_shapes_are_where_coal_has_them(name):
    geometry, shape = COAL[name]
    assert given_shape(geometry, "it") == (shape, None)
    points = np.random.default_rng(0).uniform(-0.7, 0.7, size=(200, 3))
    body, seen = given_polytope(geometry, None, "P")[0], set()
    for point in points:
        far = coal_distance(geometry, point)
        if abs(far) > NEAR:
            seen.add(far < 0)
            assert pc.intersects(body, point[None]) == (far < 0), point
    assert seen == {True, False}


@pytest.mark.parametrize("name", FCL)
def test_fcls_shapes_are_where_fcl_has_them(name):
    geometry, shape = FCL[name]
    assert given_shape(geometry, "it") == (shape, None)
    points = np.random.default_rng(1).uniform(-0.7, 0.7, size=(300, 3))
    body, seen = given_polytope(geometry, None, "P")[0], set()
    for point in points:
        found = pc.distance(body, point[None])
        if abs(found.lower_bound) > NEAR:
            seen.add(inside := found.distance == 0)
            assert fcl_touches(geometry, point, 1e-6) == inside, point
    assert seen == {True, False}


def test_meshes_of_coal_are_their_hulls():
    shape, pose = given_shape(coal_hull(), "it")
    assert pose is None
    assert {tuple(p) for p in shape.vertices} == {tuple(p) for p in CUBE}


def test_a_mesh_file_that_coal_has_loaded_is_its_hull(tmp_path):
    lines = [*("v {} {} {}".format(*p) for p in TETRAHEDRON), "v 9 9 9"]
    lines += ["f {} {} {}".format(*(k + 1 for k in face)) for face in TRIANGLES.tolist()]
    (tmp_path / "t.obj").write_text("\n".join(lines))
    shape, _ = given_shape(coal.MeshLoader().load(str(tmp_path / "t.obj"), np.ones(3)), "it")
    assert {tuple(p) for p in shape.vertices} == {tuple(p) for p in TETRAHEDRON}


def test_coals_collision_objects_bring_their_pose():
    pose = pinocchio.SE3.Random()
    item = coal.CollisionObject(coal.Box(1, 2, 3), coal.Transform3s(pose.rotation, pose.translation))
    scene = pc.Scene()
    scene.add("box", item)
    scene.add("moved", item, pinocchio.SE3(np.eye(3), np.array([1.0, 0, 0])).homogeneous)
    scene.add("parts", [pc.Part(item), pc.Part(coal.Sphere(1.0)), pc.Box((1, 1, 1))])
    box, moved, *parts = scene.bodies
    assert box.shape == moved.shape == parts[0].shape == Box((1, 2, 3))
    assert np.array_equal(box.pose, pose.homogeneous)
    assert np.allclose(moved.pose, pose.homogeneous + np.eye(4)[:, :1] * [0, 0, 0, 1], atol=1e-15)
    assert np.array_equal(parts[0].pose, pose.homogeneous)
    assert [part.shape for part in parts[1:]] == [Sphere(1.0), Box((1, 1, 1))]
    point = pose.act(np.array([0.4, 0.9, 1.4]))
    assert pc.intersects(item, point[None])
    assert not pc.intersects(item, pose.act(np.array([0.6, 0.9, 1.4]))[None])


def test_coals_swept_spheres_are_honoured_or_refused():
    ball, box = coal.Sphere(0.5), coal.Box(1, 1, 1)
    ball.setSweptSphereRadius(0.25)
    box.setSweptSphereRadius(0.25)
    assert given_shape(ball, "it") == (Sphere(0.75), None)
    with pytest.raises(pc.PlannercheckError, match=r"it: coal's swept_sphere_radius 0.25 is not supported"):
        given_shape(box, "it")


def test_meshes_of_trimesh_are_the_hulls_of_what_their_triangles_use():
    mesh = trimesh.Trimesh(np.vstack([TETRAHEDRON, [[9.0, 9, 9]]]), TRIANGLES, process=False)
    assert len(mesh.vertices) == 5
    shape, pose = given_shape(mesh, "it")
    assert (pose, {tuple(p) for p in shape.vertices}) == (None, {tuple(p) for p in TETRAHEDRON})
    torus = trimesh.creation.torus(1.0, 0.25)  # concave: its hole is filled, as for mesh files
    assert pc.intersects(torus, [[0, 0, 0.1]])
    hull, rng, body = torus.convex_hull, np.random.default_rng(2), given_polytope(torus, None, "P")[0]
    for point in rng.uniform(-1.5, 1.5, size=(100, 3)):
        out = np.einsum("ij,ij->i", hull.face_normals, point - hull.triangles[:, 0]).max()
        if abs(out) > NEAR:
            assert pc.intersects(body, point[None]) == (out < 0)


@pytest.mark.parametrize(
    ("make", "shape"),
    [
        (lambda pose: trimesh.primitives.Box(extents=[1, 2, 3], transform=pose), Box((1, 2, 3))),
        (lambda pose: trimesh.primitives.Cylinder(radius=1, height=3, transform=pose), Cylinder(1, 3)),
        (lambda pose: trimesh.primitives.Capsule(radius=1, height=3, transform=pose), Capsule(1, 3)),
        (lambda pose: trimesh.primitives.Sphere(radius=2, transform=pose), Sphere(2)),
    ],
)
def test_primitives_of_trimesh_are_exact_and_stand_where_their_meshes_do(make, shape):
    pose = pinocchio.SE3.Random().homogeneous
    primitive = make(pose)
    scene = pc.Scene()
    scene.add("it", primitive)
    (body,) = scene.bodies
    assert body.shape == shape
    assert np.allclose(body.pose[:3, 3], primitive.centroid, atol=1e-9)
    # No vertex of its mesh, which lies within the primitive, is off the body by more than rounding.
    prepared, placed = given_polytope(primitive, None, "P")
    for vertex in np.asarray(primitive.vertices)[:50]:
        assert pc.distance(prepared, vertex[None], placed).distance < 1e-9


def test_an_extrusion_of_trimesh_is_its_mesh():
    mesh = trimesh.creation.icosahedron()
    assert isinstance(given_shape(mesh, "it")[0], Hull)


def test_arrays_are_bodies():
    assert pc.intersects(CUBE, CUBE + np.array([1, 0, 0]))
    assert not pc.intersects(CUBE, CUBE + np.array([1.0000001, 0, 0]))
    assert pc.intersects(CUBE.tolist(), [[0.5, 0.5, 0.5]])  # a point is a body, too
    assert pc.intersects(CUBE.astype(np.float32), np.array(CUBE, dtype=int))
    apart = at(3.0)
    assert pc.distance(CUBE, CUBE, pose_r=apart).distance == pytest.approx(2.0)
    assert pc.certify(CUBE, CUBE, apart).verify()
    assert pc.depth(CUBE, CUBE + np.array([0.75, 0, 0])).depth == pytest.approx(0.25)
    assert pc.intersects(Sphere(1.0), pc.Polytope([[1.0, 0, 0]]))
    assert not pc.intersects(Sphere(1.0), [[1.0, 1e-7, 0]])


class Tensor:
    """What torch and JAX offer."""

    def __init__(self, values):
        self._values = values

    def __array__(self, dtype=None, copy=None):
        return np.asarray(self._values, dtype=dtype)

    def __iter__(self):
        raise AssertionError("rows are not asked for one by one")


class Named(np.ndarray):
    """A subclass as libraries of units and of caches have it."""


@pytest.mark.parametrize("kind", [trimesh.caching.TrackedArray, np.matrix, Named])
def test_subclasses_of_arrays_are_arrays(kind):
    points, far, pose = (array.view(kind) for array in (TETRAHEDRON, TETRAHEDRON + 5, np.eye(4)))
    assert pc.intersects(points, points, pose, pose)
    assert not pc.intersects(points, far)
    assert pc.certify(points, far).verify()
    assert pc.distance(points, far).distance == pc.distance(TETRAHEDRON, TETRAHEDRON + 5).distance
    assert pc.Polytope(points, TRIANGLES.view(kind)).faces.shape == (4, 3)
    assert pc.Solid(points, TRIANGLES.view(kind)).kind == "closed"
    assert pc.PointCloud(points, 0.1).count == 4
    scene = pc.Scene()
    scene.add("points", points, pose)
    assert np.array_equal(scene.bodies[0].shape.vertices, TETRAHEDRON)
    robot = pc.Robot.load("panda")
    q = robot.random_configurations(4, 0)
    assert np.array_equal(pc.Checker(robot).check_states(q.view(kind)), pc.Checker(robot).check_states(q))


def test_vertices_of_a_mesh_are_points():
    mesh = trimesh.Trimesh(TETRAHEDRON, TRIANGLES)
    assert pc.intersects(mesh.vertices, mesh.vertices + 0.1)
    assert not pc.intersects(mesh.vertices, mesh.vertices + 1)


def test_scenes_take_arrays_and_meshes():
    scene = pc.Scene()
    scene.add("array", CUBE)
    scene.add("list", CUBE.tolist(), np.eye(4))
    scene.add("tensor", Tensor(CUBE))
    scene.add("mesh", trimesh.Trimesh(TETRAHEDRON, TRIANGLES))
    scene.add("meshes", [trimesh.Trimesh(TETRAHEDRON, TRIANGLES), coal.Sphere(0.1), pc.Part(CUBE)])
    scene.attach("held", "panda_hand", parts=TETRAHEDRON)
    assert [len(item.parts) for item in scene.objects] == [1, 1, 1, 1, 3]
    for name in ("array", "list", "tensor"):
        assert np.array_equal(scene.object(name).parts[0].shape.vertices, CUBE)
    assert len(scene.attached[0].parts[0].shape.vertices) == 4


def test_scenes_of_such_shapes_are_saved_and_checked(tmp_path):
    scene = pc.Scene("s")
    ball = trimesh.creation.icosphere(2, 0.2)
    scene.add("mesh", ball, pinocchio.SE3(np.eye(3), np.array([0.5, 0, 0.5])).homogeneous)
    scene.add("post", fcl.Cylinder(0.05, 2.0), pinocchio.SE3(np.eye(3), np.array([0.0, 0.4, 0])).homogeneous)
    scene.save(tmp_path / "s.yaml")
    robot = pc.Robot.load("panda")
    q = robot.random_configurations(300, 0)
    valid = pc.Checker(robot, scene).check_states(q)
    assert (valid != pc.Checker(robot).check_states(q)).sum() > 0
    assert np.array_equal(pc.Checker(robot, pc.Scene.load(tmp_path / "s.yaml")).check_states(q), valid)
    by_hand = pc.Scene()
    by_hand.add_hull("mesh", ball.vertices, scene.bodies[0].pose)
    by_hand.add_cylinder("post", 0.05, 2.0, scene.bodies[1].pose)
    assert np.array_equal(pc.Checker(robot, by_hand).check_states(q), valid)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (
            "box.stl",
            "must be a shape such as Box, points .* not str 'box.stl'; pc.Solid.load and Scene.add_mesh read files",
        ),
        (None, "not NoneType None"),
        (7.0, r"points of a body must have shape \(n, 3\), not \(\)"),
        (np.zeros((4, 2)), r"points of a body must have shape \(n, 3\), not \(4, 2\)"),
        (CUBE * 1j, "a body must be a shape such as Box, points"),
        ([["0", "0", "0"]], "a body must be a shape such as Box, points"),
        ([[0, 0, 0], [1, 1]], "a body must be a shape such as Box, points"),
        (CUBE * np.nan, "must be finite"),
        (coal.Plane(np.array([0, 0, 1.0]), 0.0), "not coal's Plane"),
        (fcl.BVHModel(), "python-fcl does not tell the points of a BVHModel: give the points themselves"),
        (fcl.CollisionObject(fcl.Box(1, 2, 3)), "what a CollisionObject holds: give its geometry and pose"),
        (fcl.Plane(np.array([0, 0, 1.0]), 0.0), "not python-fcl's Plane"),
        (trimesh.Scene(), r"of trimesh, meshes are known, not Scene: give each mesh, as scene.dump\(\) lists them"),
        (trimesh.Trimesh(), "at least"),
        (trimesh.Trimesh(TETRAHEDRON, [[0, 1, 7]], process=False), "triangles use vertices 0 to 7"),
    ],
)
def test_what_is_no_body_is_named(value, message):
    with pytest.raises(pc.PlannercheckError, match=f"^R: .*{message}|^R.*{message}"):
        pc.intersects(CUBE, value)
    with pytest.raises(pc.PlannercheckError, match=f"^object 'x': .*{message}|needs at least"):
        pc.Scene().add("x", value)
    scene = pc.Scene()
    with pytest.raises(pc.PlannercheckError, match="object 'x'"):
        scene.add("x", [pc.Part(value)])
    assert not scene.objects


def test_poses_of_given_bodies_are_checked():
    with pytest.raises(pc.PlannercheckError, match="pose of pose_r must be a homogeneous matrix"):
        pc.intersects(CUBE, CUBE, pose_r=np.eye(3))


def test_polytopes_of_other_libraries_bodies():
    """`Polytope` takes what `intersects` does; faces, a radius and a pose of their own have no place there."""
    mesh = trimesh.Trimesh(TETRAHEDRON, TRIANGLES, process=False)
    assert {tuple(p) for p in pc.Polytope(mesh).vertices} == {tuple(p) for p in TETRAHEDRON}
    assert np.ptp(pc.Polytope(coal.Box(1, 2, 3)).vertices, axis=0).tolist() == [1, 2, 3]
    assert np.ptp(pc.Polytope(Box((1.0, 2.0, 3.0))).vertices, axis=0).tolist() == [1, 2, 3]
    ball = pc.Polytope(coal.Sphere(0.5))
    assert (ball.vertices.tolist(), ball.inflation_radius) == ([[0, 0, 0]], 0.5)
    posed = coal.CollisionObject(coal.Box(1, 1, 1), np.eye(3), np.array([1.0, 0, 0]))
    with pytest.raises(pc.PlannercheckError, match="can has a pose of its own, and a Polytope has none"):
        pc.Polytope(posed, name="can")
    for options in ({"faces": [[0, 1, 2]]}, {"inflation_radius": 0.1}):
        with pytest.raises(pc.PlannercheckError, match="can is a Sphere, which has its own faces and radius"):
            pc.Polytope(coal.Sphere(0.5), name="can", **options)
