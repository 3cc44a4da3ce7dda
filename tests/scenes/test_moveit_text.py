"""MoveIt's text format of scenes (`.scene`), old and new, is read as MoveIt reads it, and written so that it can.

The format is what MoveIt's own sources have it to be (moveit2, moveit_core/planning_scene/src/planning_scene.cpp):

    out << "* " << id << '\\n';  // New object start
    // Write object pose
    utilities::writePoseToText(out, obj->pose_);
    // Write shapes and shape poses
    out << obj->shapes_.size() << '\\n';  // Number of shapes
    ...  shapes::saveAsText(obj->shapes_[j].get(), out);
         utilities::writePoseToText(out, obj->shape_poses_[j]);
         ...  out << "0 0 0 0" << '\\n';
    // Write subframes
    out << obj->subframe_poses_.size() << '\\n';  // Number of subframes

`writePoseToText` writes "x y z", then "rx ry rz rw". Of the format before: "new format: line specifies position of
object, with spaces as delimiter -> spaces indicate new format; old format: line specifies number of shapes". And
geometric_shapes, src/shape_operations.cpp, `constructShapeFromText`:

    else if (type == Cylinder::STRING_NAME) { double r, l; in >> r >> l; ... }
    else if (type == Cone::STRING_NAME) { double r, l; in >> r >> l; ... }
    else if (type == Mesh::STRING_NAME) { unsigned int v, t; in >> v >> t; ... vertices ... triangles ... }
"""

import warnings

import numpy as np
import pinocchio
import pytest
import yaml

import plannercheck as pc
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, Hull, Sphere
from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError

# MoveIt's own tests have these two (test_planning_scene.cpp, loadGoodSceneGeometryNewFormat and ...OldFormat).
NEW = (
    "foobar_scene\n"
    "* foo\n0 0 0\n0 0 0 1\n1\nbox\n2.58 1.36 0.31\n1.49257 1.00222 0.170051\n0 0 4.16377e-05 1\n0 0 1 0.3\n0\n"
    "* bar\n0 0 0\n0 0 0 1\n1\ncylinder\n0.02 0.0001\n0.453709 0.499136 0.355051\n0 0 4.16377e-05 1\n1 0 0 1\n0\n"
    ".\n"
)
OLD = (
    "foobar_scene\n* foo\n2\nbox\n.77 0.39 0.05\n0 0 0.025\n0 0 0 1\n0.82 0.75 0.60 1\n"
    "box\n.77 0.39 0.05\n0 0 1.445\n0 0 0 1\n0.82 0.75 0.60 1\n.\n"
)
EVERYTHING = """(noname)
* Box on the left
1 2 3
0 0 0.6 0.8
5
box
0.1 0.2 0.3
0.5 0 0
0.6 0 0 0.8
0 0 0 0
sphere
0.25
0 0 1
0 0 0 1
0 0 0 0
cylinder
0.03 0.14
0 0 0
0 0 0 1
0 0 0 0
cone
0.05 0.2
0 1 0
0 0 0 2
0 0 0 0
mesh
5 4
0 0 0
1 0 0
0 1 0
0 0 1
9 9 9
0 2 1
0 1 3
0 3 2
1 2 3
0 0 -1
0 0 0 1
0 0 0 0
1
tip
0 0 0.5
0 0 0 1
.
"""
AT = "0 0 0\n0 0 0 1\n"


@pytest.fixture
def load(tmp_path):
    def loaded(text, name="s.scene"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return pc.Scene.load(path)

    return loaded


def se3(*numbers):
    """A pose as MoveIt writes it: position, then quaternion x, y, z, w, here normalised."""
    position, quaternion = np.array(numbers[:3], dtype=float), np.array(numbers[3:], dtype=float)
    return pinocchio.XYZQUATToSE3(np.concatenate([position, quaternion / np.linalg.norm(quaternion)])).homogeneous


def test_moveits_own_example_of_the_new_format(load):
    scene = load(NEW)
    assert (scene.name, scene.object_names) == ("foobar_scene", ("foo", "bar"))
    assert [body.shape for body in scene.bodies] == [Box((2.58, 1.36, 0.31)), Cylinder(radius=0.02, length=0.0001)]
    assert np.allclose(scene.bodies[1].pose, se3(0.453709, 0.499136, 0.355051, 0, 0, 4.16377e-05, 1), atol=1e-15)


def test_moveits_own_example_of_the_old_format(load):
    scene = load(OLD)
    assert (scene.name, scene.object_names) == ("foobar_scene", ("foo",))
    assert [body.shape for body in scene.bodies] == [Box((0.77, 0.39, 0.05))] * 2
    assert [body.pose[2, 3] for body in scene.bodies] == [0.025, 1.445]
    assert scene.object("foo").subframes == {}


def test_moveits_own_example_of_a_bad_file(load):
    """`loadBadSceneGeometry`: "Only two tokens; should be 3"; numbers of the next lines are taken in their place."""
    bad = NEW.partition("* bar")[0].replace("2.58 1.36 0.31", "2.58 1.36") + ".\n"
    with pytest.raises(PlannercheckError, match=r"'foo': line 12: the number of subframes must be a whole number"):
        load(bad)
    with pytest.raises(PlannercheckError, match=r"s\.scene': line 1: the file ends where '\*' \(an object\) or '\.'"):
        load("")


def test_all_shapes_stand_where_moveit_has_them(load):
    scene = load(EVERYTHING)
    (item,) = scene.objects
    assert item.name == "Box on the left"  # MoveIt takes the rest of the line
    shapes = [body.shape for body in scene.bodies]
    assert shapes[:4] == [Box((0.1, 0.2, 0.3)), Sphere(0.25), Cylinder(0.03, 0.14), Cone(0.05, 0.2)]
    assert shapes[4].vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]  # used by a triangle
    frame = se3(1, 2, 3, 0, 0, 0.6, 0.8)
    placed = [se3(0.5, 0, 0, 0.6, 0, 0, 0.8), *(se3(*p, 0, 0, 0, 1) for p in ((0, 0, 1), (0, 0, 0), (0, 1, 0)))]
    for body, on_object in zip(scene.bodies, placed, strict=False):
        assert np.allclose(body.pose, frame @ on_object, atol=1e-15)
    assert np.allclose(item.pose, frame, atol=1e-15)
    assert np.array_equal(item.subframes["tip"], se3(0, 0, 0.5, 0, 0, 0, 1))


def test_the_message_of_the_same_scene_says_the_same(load):
    """A cylinder's radius comes first in the text, its height in the message (`CYLINDER_HEIGHT` is 0)."""
    message = """
    id: can
    pose: {position: {x: 1, y: 2, z: 3}, orientation: {x: 0, y: 0, z: 0.6, w: 0.8}}
    primitives: [{type: 3, dimensions: [0.14, 0.03]}, {type: 4, dimensions: [0.2, 0.05]}]
    primitive_poses:
      - {position: {x: 0, y: 0, z: 1}, orientation: {x: 0, y: 0, z: 0, w: 1}}
      - {position: {x: 0, y: 1, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
    """
    text = (
        "s\n* can\n1 2 3\n0 0 0.6 0.8\n2\ncylinder\n0.03 0.14\n0 0 1\n0 0 0 1\n0 0 0 0\n"
        "cone\n0.05 0.2\n0 1 0\n0 0 0 1\n0 0 0 0\n0\n.\n"
    )
    for a, b in zip(load(text).bodies, load(message, "m.yaml").bodies, strict=True):
        assert a.shape == b.shape
        assert np.array_equal(a.pose, b.pose)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),  # of Windows
        lambda text: text.replace("box\n0.1 0.2 0.3\n", "box 0.1\n 0.2\t0.3\n\n"),  # C++ reads words, not lines
        lambda text: text + "\n \t\n",
        lambda text: text.replace("(noname)\n", "(noname)\n\n"),
    ],
)
def test_white_space_is_as_in_cpp(load, change):
    expected, found = load(EVERYTHING), load(change(EVERYTHING))
    assert found.name == "(noname)"
    for a, b in zip(expected.bodies, found.bodies, strict=True):
        assert a.name == b.name
        assert np.array_equal(a.pose, b.pose)
        assert a.shape == b.shape or np.array_equal(a.shape.vertices, b.shape.vertices)


def test_a_scene_without_a_name_is_called_as_its_file(load):
    assert load("\n.\n", "shelf.scene").name == "shelf"


def one(shape, pose=AT, colour="0 0 0 0"):
    return f"s\n* can\n{AT}1\n{shape}\n{pose}{colour}\n0\n.\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (one("prism\n1 2 3"), "object 'can': line 6: unknown shape 'prism': valid are sphere, box, cylinder, cone"),
        (one("plane\n0 0 1 0"), "object 'can': line 6: unknown shape 'plane'"),
        (one("box\n1 2 x"), "object 'can': line 7: the size of a box must be a finite number, not 'x'"),
        (one("box\n1 2 nan"), "line 7: the size of a box must be a finite number, not 'nan'"),
        (one("box\n1 2 1_0"), "line 7: the size of a box must be a finite number, not '1_0'"),
        (one("box\n1 2 -3"), "line 7: box size z must be "),
        (one("sphere\n0.1", "0 0 0\n0 0 0 0\n"), "object 'can': line 9: quaternion .* has no direction"),
        (one("sphere\n0.1", colour="red"), "object 'can': line 10: the shape's colour must be a finite number"),
        (one("mesh\n4.5 4"), "line 7: the number of vertices must be a whole number, not '4.5'"),
        (one("mesh\n1 1 0 0 0 0 0 1"), "line 7: triangles use vertices 0 to 1, but there are 1 vertices"),
        (one("mesh\n3 1 0 0 0 1 0 0 0 1 0 0 1 2"), "line 7: hull vertices: a body needs at least 4 points"),
        (one("mesh\n999999999 1"), "line 12: a vertex must be a finite number, not '.'"),
        (one("mesh\n9999999999 1"), "line 7: the number of vertices must be a whole number"),
        (f"s\n* can\n{AT}0\n0\n.\n", "object 'can': line 5: an object needs at least one shape"),
        (f"s\n* \n{AT}1\n.\n", "line 2: an object needs a name"),
        (one("sphere\n1")[:-2] + one("sphere\n1")[2:], "line 12: object 'can' exists already"),
        (one("sphere\n1") * 2, r"line 13: 's' stands after '\.' .the end., where MoveIt reads nothing"),
        (one("sphere\n1")[:-1] + " more", r"line 12: 'more' stands after '\.'"),
        (one("sphere\n1").replace("\n0\n.", f"\n2\ntip\n{AT}tip\n{AT}."), "line 15: subframe 'tip' exists already"),
        (one("sphere\n1")[:-2], "line 12: the file ends where '.' .an object. or '.' .the end. must stand"),
        ("world:\n  collision_objects: []\n", "line 2: '.' .* not 'collision_objects:'; planning scenes in YAML have"),
        (b"s\n* \xff\n", "line 2: this is no text in UTF-8"),
    ],
)
def test_bad_files_name_object_and_line(load, text, message):
    with pytest.raises(PlannercheckError, match=rf"^scene file .*s\.scene': (object 'can': )?{message}"):
        load(text)


def test_what_is_written_is_read_back(tmp_path, load):
    rng = np.random.default_rng(0)
    scene = load(EVERYTHING)
    scene.add_hull("wedge", rng.normal(size=(9, 3)), pinocchio.SE3.Random().homogeneous)
    scene.add_sphere("ball", 0.1 + 0.2, pinocchio.SE3.Random().homogeneous)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.save(tmp_path / "again.scene")
    again = pc.Scene.load(tmp_path / "again.scene")
    assert (again.name, again.object_names) == (scene.name, scene.object_names)
    for a, b in zip(scene.bodies, again.bodies, strict=True):
        if isinstance(a.shape, Hull):
            assert {tuple(p) for p in b.shape.vertices} == {tuple(p) for p in pc.Polytope(a.shape.vertices).vertices}
        else:
            assert a.shape == b.shape
        assert np.abs(a.pose - b.pose).max() < 1e-14
    assert np.abs(again.object("Box on the left").subframes["tip"] - scene.objects[0].subframes["tip"]).max() == 0


def test_what_is_written_is_what_moveit_writes(tmp_path):
    scene = pc.Scene("shelf")
    scene.add_cylinder("can", 0.03, 0.14, se3(1, 2, 3, 0, 0, 1, 0))
    scene.save(tmp_path / "s.scene")
    lines = (tmp_path / "s.scene").read_text().splitlines()
    numbers = [[float(word) for word in line.split()] for line in lines[2:4] + lines[6:9]]
    assert [*lines[:2], *lines[4:6], *lines[9:]] == ["shelf", "* can", "1", "cylinder", "0 0 0 0", "0", "."]
    assert numbers == [[1, 2, 3], [0, 0, 1, 0], [0.03, 0.14], [0, 0, 0], [0, 0, 0, 1]]


def flat(scene):
    scene.add_hull("x", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda scene: scene.add_capsule("x", 0.1, 0.2), "object 'x': MoveIt has no capsule"),
        (flat, "object 'x': a hull without volume has no triangles"),
        (lambda scene: scene.add_box("x\ny", (1, 1, 1)), "its name must be one line"),
        (lambda scene: setattr(scene, "name", " s"), "the scene's name must be one line"),
    ],
)
def test_what_can_not_be_written_is_said_and_nothing_is(tmp_path, change, message):
    scene = pc.Scene("s")
    scene.add_box("a", (1, 1, 1))
    change(scene)
    with pytest.raises(PlannercheckError, match=rf"scene file '.*s\.scene': .*{message}"):
        scene.save(tmp_path / "s.scene")
    assert not (tmp_path / "s.scene").exists()


def test_what_the_format_does_not_hold_is_warned_of(tmp_path):
    scene = pc.Scene("s")
    scene.add_box("a", (1, 1, 1))
    scene.attach("held", "panda_hand", parts=Capsule(0.1, 0.1))
    scene.allow("a", "panda_link0")
    with pytest.warns(UserWarning, match="obstacles alone: the scene's attached objects, allowed collisions are"):
        scene.save(tmp_path / "s.scene")
    assert pc.Scene.load(tmp_path / "s.scene").object_names == ("a",)


@pytest.fixture
def files(tmp_path, monkeypatch):
    """The same box, which the robot is in, as a `.scene`, a world and an object."""
    monkeypatch.chdir(tmp_path)
    scene = pc.Scene("s")
    scene.add_box("post", (0.1, 0.1, 2.0), se3(0.4, 0, 0, 0, 0, 0, 1))
    scene.save("s.scene")
    item = {
        "id": "post",
        "primitives": [{"type": "box", "dimensions": [0.1, 0.1, 2.0]}],
        "primitive_poses": [{"position": [0.4, 0, 0], "orientation": [0, 0, 0, 1]}],
    }
    (tmp_path / "object.yaml").write_text(yaml.safe_dump(item))
    (tmp_path / "world.yaml").write_text(yaml.safe_dump({"collision_objects": [item]}))
    np.save("q.npy", [[0, 0.9, 0, -1.2, 0, 1.571, 0.785], [1.57, -0.785, 0, -2.356, 0, 1.571, 0.785]])
    return tmp_path


@pytest.mark.parametrize("scene", ["s.scene", "world.yaml", "object.yaml"])
@pytest.mark.parametrize(
    ("command", "code"),
    [
        (("validate", "q.npy"), 1),
        (("inspect",), 0),
        (("view", "--html", "page.html"), 0),
        (("plan", "--start=1.57,-0.785,0,-2.356,0,1.571,0.785", "--goal=1.4,-0.785,0,-2.356,0,1.571,0.785"), 0),
    ],
)
def test_every_command_takes_the_file(files, capsys, scene, command, code):
    name, *rest = command
    assert main([name, *rest, "--robot", "panda", "--scene", scene]) == code
    assert "Traceback" not in capsys.readouterr().err


def test_every_command_names_what_is_wrong_in_the_file(files, capsys):
    (files / "bad.scene").write_text(one("prism\n1 2 3"))
    for command in (["inspect"], ["validate", "q.npy"], ["view", "--html", "page.html"]):
        assert main([*command, "--robot", "panda", "--scene", "bad.scene"]) == 2
        assert "scene file 'bad.scene': object 'can': line 6: unknown shape 'prism'" in capsys.readouterr().err


def test_an_absurdly_long_name_is_cut_in_errors(tmp_path):
    path = tmp_path / "a.scene"
    name = "9" * 5000
    path.write_text(f"s\n* {name}\n1\nbox\n1 1 1\n0 0 0\n0 0 0 nan\n0 0 0 0\n0\n.\n")
    with pytest.raises(pc.PlannercheckError) as found:
        pc.Scene.load(path)
    assert "object '999" in str(found.value)
    assert len(str(found.value)) < 500
