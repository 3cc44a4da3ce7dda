"""What users get wrong: each mistake gets a message that says what is wrong, and what to do.

Fatal ones are a PlannercheckError in Python, and one line and exit code 2 on the command line; input that can be judged
but is hardly meant is judged, with a warning.
"""

import re
from urllib.parse import quote

import numpy as np
import pytest
import yaml

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common.package_data import shipped_folder

SAMPLES = np.load(shipped_folder("configs") / "bookshelf_panda.npy")[:60]
PANDA = ("--robot", "panda", "--scene", "bookshelf")
READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
JOINTS = [f"panda_joint{k}" for k in range(1, 8)]

BOX = '<collision><geometry><box size="0.1 0.1 0.2"/></geometry></collision>'
MESH = '<collision><geometry><mesh filename="%s"/></geometry></collision>'
TETRAHEDRON = [[0, 0, 0], [100, 0, 0], [0, 100, 0], [0, 0, 300]]  # mm


def urdf(geometry=BOX):
    """Two links that a joint connects, each with the same geometry."""
    return (
        f'<robot name="arm"><link name="base">{geometry}</link><link name="tip">{geometry}</link>'
        '<joint name="hinge" type="revolute"><parent link="base"/><child link="tip"/><origin xyz="0 0 0.3"/>'
        '<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>'
    )


def stl(points):
    faces = [[points[k] for k in face] for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))]
    corners = ["".join("vertex {} {} {}\n".format(*p) for p in face) for face in faces]
    loops = "".join(f"facet normal 0 0 0\nouter loop\n{c}endloop\nendfacet\n" for c in corners)
    return f"solid mesh\n{loops}endsolid mesh\n"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Mistakes happen in an empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def said(capsys, *arguments, code=2):
    """What the command line says on the error stream."""
    assert main([str(argument) for argument in arguments]) == code
    printed = capsys.readouterr()
    assert "Traceback" not in printed.err
    if code == 2:
        assert printed.out == ""
    return printed.err


# ---- configurations ------------------------------------------------------------------------------------------------

SETS = {
    "degrees": (np.degrees(SAMPLES), 1, "'panda', and as degrees they would not be: .* convert them by numpy.radians"),
    "reverse order": (SAMPLES[:, ::-1], 1, "in reverse order they would not be: columns have to be panda_joint1, "),
    "some other order": (np.roll(SAMPLES, 3, axis=1), 1, "beyond the limits .* columns have to be panda_joint1, panda"),
    "transposed": (SAMPLES.T, 2, r"must have shape \(n, 7\), not \(7, 60\); it looks transposed"),
    "with the fingers": (np.ones((5, 9)), 2, r"\(n, 7\), not \(5, 9\); the joints are panda_joint1, .* panda_joint7$"),
    "one NaN": (np.where(np.arange(420).reshape(60, 7) == 30, np.nan, SAMPLES), 2, "row 4 is not finite"),
    "texts": (np.array([["a"] * 7]), 2, "must hold real numbers"),
    "objects": (np.array([[None] * 7]), 2, "no whole npy file of numbers"),
}


@pytest.mark.parametrize("name", SETS)
def test_sets(name, folder, capsys):
    rows, code, message = SETS[name]
    np.save(folder / "q.npy", rows, allow_pickle=True)
    (line,) = said(capsys, "validate", *PANDA, "q.npy", code=code).splitlines()
    assert re.search(message, line)


def test_a_good_set_gets_no_warning(folder, capsys):
    np.save(folder / "q.npy", SAMPLES)
    assert said(capsys, "validate", *PANDA, "q.npy", code=1) == ""


def test_files_of_sets(folder, capsys):
    np.save(folder / "q.npy", SAMPLES)
    (folder / "cut.npy").write_bytes((folder / "q.npy").read_bytes()[:-99])
    (folder / "q.txt").write_text("0 0 0 0 0 0 0\n")
    (folder / "comma.csv").write_text("0,1;0,2;0,3;0,4;0,5;0,6;0,7\n")
    (folder / "short.csv").write_text("0,0,0,0,0,0,0\n0,0,0\n")
    (folder / "names.csv").write_text(",".join(["panda_joint_1", *JOINTS[1:]]) + "\n0,0,0,0,0,0,0\n")
    for file, message in (
        ("missing.npy", "'missing.npy': does not exist"),
        ("cut.npy", "'cut.npy': is no whole npy file of numbers, cut short perhaps"),
        ("q.txt", "must be one of .npy, .npz, .csv"),
        ("comma.csv", "write decimal points, not commas"),
        ("short.csv", "row 1 must have 7 numbers, not '0,0,0'"),
        ("names.csv", "no column for joint 'panda_joint1'; its header is panda_joint_1"),
    ):
        assert message in said(capsys, "validate", *PANDA, file)


def test_one_configuration(checker):
    for q, message in (
        (SAMPLES[:2], r"one configuration must have shape \(7,\), not \(2, 7\)"),
        ([0.0] * 6, r"not \(6,\); the joints are panda_joint1"),
        ([np.nan] * 7, "must be finite"),
    ):
        with pytest.raises(pc.PlannercheckError, match=message):
            checker.is_valid(q)


def test_arguments_of_a_checker(checker):
    for arguments, message in (
        (("panda", "bookshelf"), r"Checker\(Robot.load\('panda'\), Scene.load\('bookshelf'\)\)"),
        ((checker.scene, checker.robot), "not Scene and Robot"),
    ):
        with pytest.raises(pc.PlannercheckError, match=message):
            pc.Checker(*arguments)
    with pytest.raises(pc.PlannercheckError, match="did you mean 'panda_hand'"):
        pc.Checker(checker.robot, padding={"panda_hnd": 0.01})
    for options, message in (
        ({"padding": -1}, "at least 0, not -1"),
        ({"padding": 10**400}, "padding must be a length in m"),
        ({"self_collision": "no"}, "self_collision must be True or False, not 'no'"),
        ({"self_collision": None}, "self_collision must be True or False, not None"),
        ({"excess": -1}, r"excess must be within \(0, 1\], a part of the radius, not -1"),
        ({"excess": "fine"}, "excess must be within"),
    ):
        with pytest.raises(pc.PlannercheckError, match=message):
            pc.Checker(checker.robot, **options)


def test_rows_of_pairs(checker):
    for row in (-1, len(checker.pairs), 0.0):  # -1 is the row of no pair
        for ask in (checker.pair_names, lambda k: checker.explain_pair(k, SAMPLES[0])):
            with pytest.raises(pc.PlannercheckError, match="row must be one of"):
                ask(row)


COMPLEX = np.eye(4) + 1j * np.diag([0, 0, 0, 1])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda r: pc.Sphere("0.5"), "sphere radius must be a number in m, not '0.5'"),
        (lambda r: pc.Sphere(np.complex128(1 + 2j)), "sphere radius must be a number in m, not"),
        (lambda r: pc.Checker(r, padding=np.complex128(1 + 2j)), "padding must be a length in m of at least 0"),
        (lambda r: pc.Robot.together({"one": r}).join(None), "join takes configurations by robot"),
        (lambda r: pc.Sphere(True), "sphere radius must be a number in m, not True"),
        (lambda r: pc.Box(["1", "1", "1"]), "must be an array of numbers: an array of dtype <U1 holds no real"),
        (lambda r: pc.Hull(np.eye(4, 3) * 1j), "vertices must be an array of numbers: an array of dtype complex128"),
        (lambda r: pc.HalfSpace([0, 0, 1], "1"), "offset of a half-space must be a number, not '1'"),
        (lambda r: pc.Scene().add_sphere("ball", 1.0, COMPLEX), "pose of object 'ball' must be an array of numbers"),
        (lambda r: pc.Moving.along(None, "hand", r, "3"), "start_time must be a number of seconds, not '3'"),
        (lambda r: r.holding({"panda_finger_joint1": "0.04"}), "'panda_finger_joint1' needs 1 finite value .* '0.04'"),
        (lambda r: r.holding({"panda_finger_joint1": np.array([0.04j])}), "needs 1 finite value"),
        (lambda r: r.holding({"panda_finger_joint1": np.ma.masked_array([0.04], [1])}), "needs 1 finite value"),
        (lambda r: r.holding({"panda_finger_joint1": 1e300}), r"needs 1 finite value \(at most 1e\+15\)"),
        (lambda r: r.holding([0.04, 0.04]), "held values are by joint name"),
        (lambda r: r.with_group("panda_joint1"), "a group is a list of names of joints, not 'panda_joint1'"),
        (lambda r: r.with_group([["panda_joint1"]]), "a group is a list of names of joints"),
        (lambda r: r.random_configurations(1, "seed"), "seed must be a whole number of at least 0"),
        (lambda r: r.link_index(["panda_hand"]), "unknown link"),
        (lambda r: pc.Robot.together({"one": r}, ["one"]), "unknown group of the cell"),
        (lambda r: pc.Robot.load(None), "a robot is loaded by its name or from a file, not None"),
        (lambda r: pc.Scene.load(3), "a scene is loaded by its name or from a file, not 3"),
        (lambda r: pc.Robot.load("panda", "fine"), "decomposition must be a pc.Decomposition, not 'fine'"),
        (lambda r: pc.distances_along(pc.Checker(r), r.reference, [0.0]), "distances_along takes a pc.Trajectory"),
    ],
)
def test_what_is_no_number_or_name_is_not_read_as_one(checker, make, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        make(checker.robot)


def test_a_reference_array_has_cosines_and_sines(folder):
    (folder / "arm.urdf").write_text(urdf().replace("revolute", "continuous"))
    assert pc.Robot.from_urdf("arm.urdf", reference=[0.6, 0.8]).reference == pytest.approx([0.6, 0.8], abs=1e-15)
    for array, message in (
        ([0.0, 0.0], "'hinge' is no cosine and sine"),
        ([["a"]], "a reference array must be numbers"),
    ):
        with pytest.raises(pc.PlannercheckError, match=message):
            pc.Robot.from_urdf("arm.urdf", reference=array)


# ---- names ---------------------------------------------------------------------------------------------------------


def test_misspelt_names(capsys):
    q = ("validate", "q.npy")
    assert "did you mean 'panda'? valid are" in said(capsys, *q, "--robot", "pnada")
    assert "did you mean 'bookshelf'? valid are" in said(capsys, *q, "--robot", "panda", "--scene", "bokshelf")
    assert "scene file 'cell.yaml' does not exist" in said(capsys, *q, "--robot", "panda", "--scene", "cell.yaml")
    assert "robot file arm.urdf does not exist" in said(capsys, *q, "--robot", "arm.urdf")
    assert "must be a shipped robot's name, a YAML or a URDF file" in said(capsys, *q, "--robot", "arm.stl")
    assert "is a scene, not a robot" in said(capsys, *q, "--robot", shipped_folder("configs") / "table.yaml")
    robot = shipped_folder("robots") / "panda.yaml"
    assert "is a robot, not a scene" in said(capsys, *q, "--robot", "panda", "--scene", robot)
    assert "did you mean 'RRTConnect'" in said(capsys, "plan", *PANDA, "--planner", "RRT-Connect")
    assert "invalid choice: 'valdate' (choose from" in said(capsys, "valdate")


def test_groups(folder):
    (folder / "arm.urdf").write_text(urdf())
    (folder / "arm.srdf").write_text('<robot name="arm"><group name="all"><joint name="hinge"/></group></robot>')
    for srdf, group, message in (
        (None, "all", "without an SRDF, a group must be a list of joints, some of hinge"),
        (None, ["hnge"], "unknown joint 'hnge': did you mean 'hinge'"),
        ("arm.srdf", "al", "unknown planning group 'al': did you mean 'all'"),
        ("other.srdf", "all", "SRDF other.srdf does not exist"),
    ):
        with pytest.raises(pc.PlannercheckError, match=message):
            pc.Robot.from_urdf("arm.urdf", srdf, group=group)


# ---- robots --------------------------------------------------------------------------------------------------------


def test_the_srdf_of_another_robot(folder):
    (folder / "arm.urdf").write_text(urdf())
    (folder / "other.srdf").write_text('<robot name="b"><disable_collisions link1="hand" link2="foot"/></robot>')
    with pytest.warns(RuntimeWarning, match="disables no pair of links of this robot, but of hand, foot"):
        pc.Robot.from_urdf("arm.urdf", "other.srdf")


def test_a_missing_package(folder, capsys):
    (folder / "arm.urdf").write_text(urdf(MESH % "package://my_arm/meshes/link.stl"))
    message = r"package://NAME/... needs the folder that contains NAME, or a folder whose package.xml calls it so"
    with pytest.raises(pc.PlannercheckError, match=rf"none given\), ROS_PACKAGE_PATH .*{message}"):
        pc.Robot.from_urdf("arm.urdf")
    assert "needs the folder that contains NAME" in said(capsys, "inspect", "--robot", "arm.urdf")


def test_meshes_are_found_beside_the_urdf_and_in_its_package(folder, monkeypatch):
    package = folder / "ws" / "my_arm"
    (package / "urdf").mkdir(parents=True)
    small = stl((np.array(TETRAHEDRON) * 0.001).tolist())
    (package / "link.stl").write_text(small)
    (package / "urdf" / "link.stl").write_text(small)
    for name in ("package://my_arm/link.stl", "link.stl"):
        (package / "urdf" / "arm.urdf").write_text(urdf(MESH % name))
        assert len(pc.Robot.from_urdf(package / "urdf" / "arm.urdf").bodies) == 2


def addresses(path):
    """What RFC 8089 and RFC 3986 take as the address of a file."""
    encoded = quote(str(path))
    whole = "".join(f"%{byte:02x}" if byte not in b"/" else "/" for byte in str(path).encode())
    return [f"file:{encoded}", f"file://{encoded}", f"file://localhost{encoded}", f"file://{whole}", str(path)]


@pytest.mark.parametrize("name", ["link.stl", "my link.stl", "glied ä.stl", "100%.stl", "100%41.stl", "a#b.stl"])
def test_meshes_by_uris(name, folder):
    (folder / "arm" / "meshes").mkdir(parents=True)
    path = folder / "arm" / "meshes" / name
    path.write_text(stl((np.array(TETRAHEDRON) * 0.001).tolist()))
    relative = f"meshes/{name}"
    packaged = [f"package://arm/{quote(relative)}", f"model://arm/{quote(relative)}", f"package://arm/{relative}"]
    if "%41" in name:  # a URI that is not encoded means another name
        packaged.pop()
    for address in [*addresses(path), *packaged, f"file:{quote(relative)}", f"file://{quote(relative)}", relative]:
        (folder / "arm" / "arm.urdf").write_text(urdf(MESH % address))
        assert len(pc.Robot.from_urdf(folder / "arm" / "arm.urdf").bodies) == 2, address
        scene = f"objects: [{{name: part, mesh: {{file: '{address}'}}}}]"
        (folder / "arm" / "scene.yaml").write_text(scene, encoding="utf-8")
        assert pc.Scene.load(folder / "arm" / "scene.yaml").object_names == ("part",), address


def test_a_percent_sign_of_a_path_is_a_percent_sign(folder):
    (folder / "a b.stl").write_text(stl(TETRAHEDRON))
    (folder / "arm.urdf").write_text(urdf(MESH % "a%20b.stl"))
    with pytest.raises(pc.PlannercheckError, match=r"mesh a%20b\.stl could not be found"):
        pc.Robot.from_urdf("arm.urdf")


@pytest.mark.parametrize(
    ("address", "hint"),
    [
        (r"meshes\link.stl", "since it has backslashes: write / in their place"),
        (r"package://arm\meshes\link.stl", "since it has backslashes: write / in their place"),
        (r"C:\meshes\link.stl", "since it has backslashes"),
        ("https://example.org/link.stl", "since 'https:' is none of package://, model:// and file:"),
        ("file:///a%00b.stl", "not be found|not found|does not exist"),
    ],
)
def test_addresses_that_are_none(address, hint, folder):
    (folder / "meshes").mkdir()
    (folder / "meshes" / "link.stl").write_text(stl(TETRAHEDRON))
    (folder / "arm.urdf").write_text(urdf(MESH % address))
    with pytest.raises(pc.PlannercheckError, match=hint):
        pc.Robot.from_urdf("arm.urdf")
    (folder / "scene.yaml").write_text(f"objects: [{{name: part, mesh: {{file: '{address}'}}}}]")
    with pytest.raises(pc.PlannercheckError, match=hint):
        pc.Scene.load("scene.yaml")


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        (
            "link.stl",
            "solid a\nfacet normal 0 0 1\n outer loop\n vertex 0 0\n endloop\nendfacet\nendsolid\n",
            "facet 1",
        ),
        ("link.stl", "a page that says 404", "is no STL file"),
        ("link.stl", "<html>" + 90 * " ", "its header says"),
        ("link.obj", "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", "line 2: a vertex must have 3 numbers"),
    ],
)
@pytest.mark.parametrize("address", ["link.{}", "package://arm/link.{}", "file://{}"])
def test_a_malformed_mesh_is_blamed_itself(name, content, says, address, folder):
    (folder / "arm").mkdir()
    (folder / "arm" / name).write_text(content)
    suffix = name.partition(".")[2]
    named = address.format(folder / "arm" / name if address.startswith("file") else suffix)
    (folder / "arm" / "arm.urdf").write_text(urdf(MESH % named))
    with pytest.raises(pc.PlannercheckError, match=rf"mesh file '.*{name}': .*{says}") as caught:
        pc.Robot.from_urdf(folder / "arm" / "arm.urdf")
    assert not re.search("Searched|package_dirs|folder", str(caught.value))


def test_an_obj_with_leading_blanks_is_read(folder):
    lines = [
        "# by hand",
        *(f"v {x} {y} {z}" for x, y, z in TETRAHEDRON),
        "o part",
        "f 1 3 2",
        "f 1 2 4",
        "f 1 4 3",
        "f 2 3 4",
    ]
    (folder / "link.obj").write_text("\n".join(f" \t {line}  " for line in lines))
    solid = pc.Solid.load("link.obj", 0.001)
    assert (len(solid.vertices), len(solid.triangles), solid.kind) == (4, 4, "closed")


def test_meshes_in_millimetres(folder):
    (folder / "link.stl").write_text(stl(TETRAHEDRON))
    (folder / "arm.urdf").write_text(urdf(MESH % "link.stl"))
    with pytest.warns(RuntimeWarning, match=r"is 300 m large: if it is in millimetres, scale it by 0.001 \(scale= in"):
        pc.Robot.from_urdf("arm.urdf")
    with pytest.warns(RuntimeWarning, match="mesh file 'link.stl': is 300 m large"):
        pc.Scene().add_mesh("part", "link.stl")


def test_a_mesh_that_is_cut_short(folder):
    (folder / "link.stl").write_text(stl(TETRAHEDRON)[:40])
    (folder / "arm.urdf").write_text(urdf(MESH % "link.stl"))
    with pytest.raises(pc.PlannercheckError, match=r"URDF arm.urdf: link 'base': mesh file '.*link.stl'"):
        pc.Robot.from_urdf("arm.urdf")


def test_xacro(folder, capsys):
    content = urdf().replace("0.1 0.1 0.2", "${size}").replace("<robot", '<robot xmlns:xacro="http://ros.org/xacro"')
    messages = {
        "arm.urdf": "it is a xacro, which has to be expanded first: xacro arm.urdf",
        "arm.urdf.xacro": "xacro arm.urdf.xacro can't be expanded: name 'size' is not defined",
    }
    for name, message in messages.items():
        (folder / name).write_text(content.replace("http://ros.org/xacro", "http://www.ros.org/wiki/xacro"))
        with pytest.raises(pc.PlannercheckError, match=message):
            pc.Robot.from_urdf(name)
        assert message in said(capsys, "inspect", "--robot", name)


def test_a_urdf_without_collision_geometry(folder):
    (folder / "arm.urdf").write_text(urdf(BOX.replace("collision", "visual")))
    with pytest.warns(RuntimeWarning, match=r"no <collision> elements \(it has <visual> ones, .* nothing will ever"):
        pc.Robot.from_urdf("arm.urdf")


def test_no_srdf_and_links_that_touch_by_design(folder, capsys):
    tool = f'<link name="tool">{BOX}</link><joint name="flange" type="fixed"><parent link="tip"/><child link="tool"/>'
    long = urdf(BOX.replace("0.1 0.1 0.2", "0.1 0.1 0.7")).replace("</robot>", f"{tool}</joint></robot>")
    (folder / "arm.urdf").write_text(long)
    np.save(folder / "q.npy", np.linspace(-0.5, 0.5, 50)[:, None])
    message = "every configuration collides, each time by these pairs: base – tool; .*disabled_pairs"
    assert re.search(message, said(capsys, "validate", "--robot", "arm.urdf", "q.npy", code=1))
    assert re.search(message, said(capsys, "inspect", "--robot", "arm.urdf", "--states", "50", code=0))


def test_a_urdf_that_is_cut_short(folder):
    (folder / "arm.urdf").write_text(urdf()[:200])
    with pytest.raises(pc.PlannercheckError, match=r"URDF arm.urdf does not parse"):
        pc.Robot.from_urdf("arm.urdf")


# ---- planning ------------------------------------------------------------------------------------------------------


def test_starts_and_goals(checker, capsys):
    colliding = SAMPLES[~checker.check_states(SAMPLES)][0]
    for start, message in (
        (colliding, r"not planned: start collides: panda_link5 with shelf"),
        (np.degrees(READY), r"start is beyond the limits: .*; as degrees it would be within: angles are in rad"),
        (READY[:6], r"start: configurations must have shape \(7,\) .*; the joints are panda_joint1"),
    ):
        assert re.search(message, said(capsys, "plan", *PANDA, "--start", ",".join(map(str, start))))
    assert "--start must be numbers separated by commas" in said(capsys, "plan", *PANDA, "--start", "home")
    found = said(capsys, "plan", "--robot", "xarm7", "--scene", "bookshelf")
    assert "declares no start for robot 'xarm7', but for panda, ur5: give the start yourself" in found
    assert "needs --scene, or --problems" in said(capsys, "plan", "--robot", "panda")
    assert "unknown format of a plan '.txt'" in said(capsys, "plan", *PANDA, "--output", "plan.txt")


# ---- scenes --------------------------------------------------------------------------------------------------------

SCENES = {
    "objects: [{name: a, box: {sise: [1, 1, 1]}}]": "object 'a': box: unknown key 'sise': did you mean 'size'",
    "objects: [{name: a, box: {size: [1, 1]}}]": "'size' needs 3 numbers, not 2",
    "objects: [{name: a, box: {size: [1, 1, -1]}}]": "box size z must be finite and not negative",
    "objects: [{name: a, cylinder: {radius: 1}}]": "key 'length' is missing",
    "objects: [{name: a}]": "needs exactly one of the keys box",
    "objects: [{name: a, mesh: {file: a.stl}}]": "mesh file 'a.stl' does not exist",
    "objects: [{name: a, sphere: {radius: 1}}, {name: a, sphere: {radius: 1}}]": "object 'a' exists already",
    "objects:\n\t- name: a": "no valid YAML: .* line 2",
    "box: {size: [1, 1, 1]}": "unknown key 'box': valid are name, objects",
}


@pytest.mark.parametrize("content", SCENES)
def test_scene_files(content, folder):
    (folder / "cell.yaml").write_text(content)
    with pytest.raises(pc.PlannercheckError, match=f"scene file 'cell.yaml': .*{SCENES[content]}"):
        pc.Scene.load("cell.yaml")


def test_calls_of_a_scene():
    scene = pc.Scene()
    for size, pose, message in (
        (0.1, None, "box size must be a list of numbers, not 0.1"),
        ([1, 1, 1], [0, 0, 1], r"must be a homogeneous matrix of shape \(4, 4\), not \(3,\)"),
        ([1, 1, 1], [0, 0, 1, 0, 0, 0, 1], r"homogeneous matrix of shape \(4, 4\), not \(7,\)"),
        ([1, 1, 1], 2 * np.eye(4), "last row must be 0 0 0 1"),
    ):
        with pytest.raises(pc.PlannercheckError, match=message):
            scene.add_box("box", size, pose)


def test_moveits_padding_is_used_on_request(folder, capsys):
    box = "{id: b, primitives: [{type: box, dimensions: [0.1, 0.1, 0.1]}], pose: {position: [0.0, 0.0, 0.9]}}"
    text = f"world: {{collision_objects: [{box}]}}\nlink_padding: [{{link_name: panda_hand, padding: 0.02}}]\n"
    (folder / "planning_scene.yaml").write_text(text)
    with pytest.warns(UserWarning, match="link_padding, for panda_hand, is used if asked for: .*scene.link_padding"):
        scene = pc.Scene.load("planning_scene.yaml")
    robot = pc.Robot.load("panda")
    plain, padded = pc.Checker(robot, scene), pc.Checker(robot, scene, padding=scene.link_padding)
    q = robot.random_configurations(2000, 0)
    expected = (plain.check_states(q) & ~padded.check_states(q)).sum()
    assert expected > 0
    np.save(folder / "q.npy", q[plain.check_states(q) & ~padded.check_states(q)])
    command = ("validate", "--robot", "panda", "--scene", "planning_scene.yaml", "q.npy")
    assert "--padding scene" in said(capsys, *command, code=0)
    said(capsys, *command, "--padding", "scene", code=1)
    assert "--padding must be a length in m or 'scene', not '2cm'" in said(capsys, *command, "--padding", "2cm")


@pytest.mark.parametrize(
    ("name", "keys"),
    [
        *((f"part.{suffix}", ["mesh"]) for suffix in ("stl", "dae", "obj", "off", "gltf", "glb", "STL")),
        ("part.ply", ["mesh", "cloud"]),
        *((f"part.{suffix}", ["cloud"]) for suffix in ("pcd", "xyz", "pts")),
        *((f"part.{suffix}", ["octree"]) for suffix in ("bt", "ot")),
    ],
)
def test_geometry_in_place_of_a_scene_says_what_to_write(name, keys, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(b"\x00")
    error = said(capsys, "inspect", "--robot", "panda", "--scene", name)
    assert f"scene file '{name}': is geometry, not a scene: write a YAML file beside it with" in error
    written = [yaml.safe_load(text) for text in re.findall(r"(objects: \[\{.*?\}\]) ?(?=\(|$|,)", error)]
    assert [next(iter(each["objects"][0].keys() - {"name"})) for each in written] == keys
    assert all(each["objects"][0][key]["file"] == name for each, key in zip(written, keys, strict=True))


def test_what_to_write_for_a_mesh_loads(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.stl").write_text(stl(TETRAHEDRON))
    error = said(capsys, "inspect", "--robot", "panda", "--scene", "part.stl")
    (tmp_path / "scene.yaml").write_text(re.search(r"objects: \[.*?\]", error)[0])
    with pytest.warns(RuntimeWarning, match="millimetres"):
        assert pc.Scene.load("scene.yaml").object_names == ("part",)
