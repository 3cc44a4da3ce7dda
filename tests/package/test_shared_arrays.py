"""What comes in is copied or refused, what goes out is read-only or a copy: of every array of every public class.

In: public objects, made from arrays that the test keeps. Out: nothing that a user does to an array of theirs, or of
ours, changes what an object says later.
"""

import pickle
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.planar.polygons import Polygons

TETRAHEDRON = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
SQUARE = [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]]
# Attributes that are objects of other packages, or the compiled core: not ours to hand out read-only.
FOREIGN = {"model", "core", "kinematics"}
TRAJECTORY = pc.Trajectory([0.0, 1.0], [[0.0] * 7, [0.1] * 7])

Maker = Callable[[Callable[[Any], Any]], Any]


def _planar_pose(x: float) -> np.ndarray:
    return np.array([[1.0, 0, x], [0, 1, 0], [0, 0, 1]])


def _planar_scene(given: Callable[[Any], Any]) -> pc.planar.Scene:
    scene = pc.planar.Scene("s", given([[-5, -5], [5, 5]]))
    scene.add_box("box", given([0.4, 0.4]), given(_planar_pose(2)))
    scene.add_polygon("polygon", given(SQUARE), given(_planar_pose(-2)))
    scene.set_states("robot", given([0.0, 0, 0]), given([1.0, 1, 0]))
    return scene


def _planar_robot(given: Callable[[Any], Any]) -> pc.planar.Robot:
    hitch = given([-0.6, 0.0, 0.0])
    links = [
        pc.planar.Link("base", given(SQUARE), joint="free"),
        pc.planar.Link("trailer", given(SQUARE), "base", hitch, "revolute", given([-1.0, 1.0])),
    ]
    return pc.planar.Robot(links)


def _planar_checker(given: Callable[[Any], Any]) -> pc.planar.Checker:
    return pc.planar.Checker(_planar_robot(given), _planar_scene(given))


def _scene(given: Callable[[Any], Any]) -> pc.Scene:
    scene = pc.Scene("s")
    scene.add_box("box", given([0.4, 0.4, 0.4]), given(at(2)))
    scene.add_hull("hull", given(TETRAHEDRON), given(at(-2)))
    scene.add("parts", [pc.Part(pc.Box(given([0.1, 0.1, 0.1])), given(at(0.1)))], given(at(3)))
    scene.set_states("panda", given(np.zeros(7)), given(np.zeros(7)))
    return scene


def _checker(given: Callable[[Any], Any]) -> pc.Checker:
    return pc.Checker(pc.Robot.load("panda"), _scene(given))


def _motion(given: Callable[[Any], Any]) -> Any:
    q = pc.Robot.load("panda").reference
    return _checker(given).explain_motion(given(q), given(q + 0.01), proofs=True)


MAKERS: dict[str, Maker] = {
    "Polytope": lambda given: pc.Polytope(given(TETRAHEDRON)),
    "Polytope with faces": lambda given: pc.Polytope(
        given(TETRAHEDRON), [given(f) for f in ([0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3])]
    ),
    "Hull": lambda given: pc.Hull(given(TETRAHEDRON)),
    "Part": lambda given: pc.Part(pc.Sphere(0.1), given(at(1))),
    "Moving": lambda given: pc.Moving(given([0.0, 1.0]), given(np.stack([at(0), at(1)]))),
    "Moving along": lambda given: pc.Moving.along(TRAJECTORY, "panda_hand", (pc.Robot.load("panda"), given(at(1)))),
    "Scene": _scene,
    "Checker": _checker,
    "Robot": lambda given: pc.Robot.load("panda"),
    "explain": lambda given: _checker(given).explain(given(pc.Robot.load("panda").reference), separations=True),
    "explain_motion": _motion,
    "certify apart": lambda given: pc.certify(
        pc.Polytope(given(TETRAHEDRON)), pc.Polytope(given(TETRAHEDRON)), given(at(0)), given(at(3))
    ),
    "certify sharing": lambda given: pc.certify(
        pc.Polytope(given(TETRAHEDRON)), pc.Polytope(given(TETRAHEDRON)), given(at(0)), given(at(0.1))
    ),
    "planar scene": _planar_scene,
    "planar robot": _planar_robot,
    "planar checker": _planar_checker,
    "planar explain": lambda given: _planar_checker(given).explain(given(np.zeros(4)), separations=True),
    "planar polygons": lambda given: Polygons([given(SQUARE)]),
    "planar certify": lambda given: pc.planar.certify(
        given(SQUARE), given(SQUARE), given(_planar_pose(0)), given(_planar_pose(3))
    ),
    "ndim polytope": lambda given: pc.ndim.Polytope(given(np.vstack([np.zeros(4), np.eye(4)]))),
    "ndim halfspaces": lambda given: pc.ndim.Polytope.from_halfspaces(
        given(np.vstack([np.eye(2), -np.eye(2)])), given(np.ones(4))
    ),
    "ndim certify": lambda given: pc.ndim.certify(
        pc.ndim.Polytope(given(SQUARE)), pc.ndim.Polytope(given(SQUARE)), None, given(_planar_pose(3))
    ),
}


def _children(item: Any) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Names of what a public object shows, with a function that asks for it again."""
    if isinstance(item, Mapping):
        for key in item:
            yield f"[{key!r}]", lambda key=key: item[key]
    elif isinstance(item, tuple | list):
        for k in range(len(item)):
            yield f"[{k}]", lambda k=k: item[k]
    elif type(item).__module__.startswith("plannercheck") and not isinstance(item, type):
        for name in dir(item):
            if not name.startswith("_") and name not in FOREIGN and not callable(getattr(item, name, None)):
                yield f".{name}", lambda name=name: getattr(item, name)


def arrays_of(item: Any, path: str, seen: set[int], kept: list[Any]) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Every array that can be reached from an object by public names."""
    for name, ask in _children(item):
        value = ask()
        if isinstance(value, np.ndarray):
            yield path + name, ask
        elif id(value) not in seen:
            seen.add(id(value))
            kept.append(value)  # else another object could get its id
            yield from arrays_of(value, path + name, seen, kept)


def _said(item: Any) -> list[tuple[str, bytes]]:
    return [(path, ask().tobytes()) for path, ask in arrays_of(item, "", set(), [])]


def _overwrite(array: np.ndarray) -> None:
    array[...] = ~array if array.dtype == bool else array + 7


@pytest.mark.parametrize("name", MAKERS)
def test_what_goes_out_is_read_only_or_a_copy(name: str) -> None:
    item = MAKERS[name](lambda values: np.array(values, dtype=np.float64))
    found, shared = 0, []
    for path, ask in arrays_of(item, name, set(), []):
        found += 1
        array = ask()
        if array.size and array.flags.writeable:
            before = array.tobytes()
            _overwrite(array)
            if ask().tobytes() != before:
                shared.append(path)
    assert found
    assert not shared


@pytest.mark.parametrize("name", MAKERS)
def test_what_comes_in_is_copied(name: str) -> None:
    given: list[np.ndarray] = []

    def keep(values: Any) -> np.ndarray:
        given.append(np.array(values, dtype=np.float64, order="C"))
        if name.endswith("faces") and given[-1].shape == (3,):
            given[-1] = given[-1].astype(np.int64)
        return given[-1]

    item = MAKERS[name](keep)
    before = _said(item)
    for array in given:
        _overwrite(array)
    assert _said(item) == before
    assert all(array.flags.writeable for array in given), "an array of the caller's was made read-only"


def test_a_pose_array_that_is_used_again_puts_obstacles_where_it_said() -> None:
    scene, pose = pc.planar.Scene(), np.eye(3)
    for k in range(3):
        pose[0, 2] = 4.0 * k
        scene.add_box(f"box{k}", [1, 1], pose)
    checker = pc.planar.Checker(pc.planar.Robot(SQUARE), scene)
    assert checker.check_states([[0, 0, 0], [4, 0, 0], [8, 0, 0], [2, 0, 0]]).tolist() == [False, False, False, True]
    pose[0, 2] = 100.0
    assert not checker.explain([0, 0, 0]).valid
    assert not checker.is_valid([0, 0, 0])


def test_the_pose_of_what_has_none_is_nobodys_to_move() -> None:
    scene = pc.planar.Scene()
    scene.add_box("a", [1, 1])
    with pytest.raises(ValueError, match="read-only"):
        scene.obstacles["a"].pose[0, 2] += 3
    assert pc.planar.intersects(SQUARE, SQUARE)
    with pytest.raises(ValueError, match="read-only"):
        pc.planar.Robot(SQUARE).bodies[0].pose[0, 2] += 3
    square = pc.ndim.Polytope(SQUARE)
    certificate = pc.ndim.certify(square, square)
    assert certificate.verify()


def test_a_planar_checker_keeps_the_scene_as_it_was() -> None:
    scene = pc.planar.Scene()
    scene.add_box("a", [1, 1])
    checker = pc.planar.Checker(pc.planar.Robot(SQUARE), scene)
    scene.remove("a")
    assert not checker.is_valid([0, 0, 0])
    assert checker.scene.object_names == ("a",)
    assert not pickle.loads(pickle.dumps(checker)).is_valid([0, 0, 0])


def test_links_keep_no_list_of_the_callers() -> None:
    anchor, limits = [-1.0, 0.0, 0.0], [-1.0, 1.0]
    link = pc.planar.Link("trailer", SQUARE, "base", anchor, "revolute", limits)  # type: ignore[arg-type]
    robot = pc.planar.Robot([pc.planar.Link("base", SQUARE, joint="free"), link])
    before = robot.link_poses(np.zeros(4))
    anchor[0], limits[1] = 5.0, 9.0
    assert np.array_equal(robot.link_poses(np.zeros(4)), before)
    assert robot.links[1].anchor == (-1.0, 0.0, 0.0)
    again = pickle.loads(pickle.dumps(robot))
    assert np.array_equal(again.link_poses(np.zeros(4)), before)
    assert again.upper[-1] == 1.0


def test_the_walk_sees_what_is_shared() -> None:
    """Else both tests above would pass with nothing behind them."""
    robot = _planar_robot(np.array)
    robot.reference = np.zeros(4)  # type: ignore[attr-defined]
    shared = [path for path, ask in arrays_of(robot, "robot", set(), []) if ask().flags.writeable]
    assert "robot.reference" in shared
