"""Objects that move: `Moving`, its errors, and scene files with it."""

import pickle
from pathlib import Path

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.bodies.moving import carrier_of

_TURN = np.array([[0.0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])


def _scene() -> pc.Scene:
    scene = pc.Scene("belt")
    belt = pc.Moving([0.0, 1.5, 4.0], [np.eye(4), _TURN, np.eye(4)], outside="stand")
    scene.add("pallet", pc.Box((0.4, 0.3, 0.2)), belt)
    scene.add("load", [pc.Part(pc.Sphere(0.1), _TURN), pc.Part(pc.Box((0.1, 0.1, 0.1)))], belt)
    scene.add_box("table", (1, 1, 1), _TURN)
    return scene


def test_a_saved_scene_moves_alike(tmp_path: Path) -> None:
    """Reading gives the same doubles."""
    scene = _scene()
    scene.save(tmp_path / "belt.yaml")
    read = pc.Scene.load(tmp_path / "belt.yaml")
    assert [item.name for item in read.moving] == ["pallet", "load"]
    for name in ("pallet", "load"):
        given, found = scene.object(name).moving, read.object(name).moving
        assert np.array_equal(given.times, found.times)
        assert np.array_equal(given.poses, found.poses)
        assert (given.outside, given.path, carrier_of(given)) == (found.outside, found.path, carrier_of(found))
    assert "Moving(3 poses, 0 to 4 s)" in read._repr_html_()
    assert [item.name for item in pickle.loads(pickle.dumps(scene)).moving] == ["pallet", "load"]


def test_moveits_text_has_no_motions(tmp_path: Path) -> None:
    """It names the object."""
    with pytest.raises(pc.PlannercheckError, match=r"'pallet'.*it moves"):
        _scene().save(tmp_path / "belt.scene")


@pytest.mark.parametrize(
    ("times", "poses", "message"),
    [
        ([0.0], [np.eye(4)], "two or more"),
        ([0.0, 0.0], [np.eye(4)] * 2, "time 1 is 0"),
        ([0.0, np.nan], [np.eye(4)] * 2, "must grow.*time 1 is nan"),
        ([np.nan, 1.0], [np.eye(4)] * 2, "must grow.*time 0 is nan"),
        ([[0.0, 1.0]], [np.eye(4)] * 2, "two or more"),
        (["a", "b"], [np.eye(4)] * 2, "must be numbers"),
        ([0.0, 1.0], np.eye(4), "shape"),
        ([0.0, 1.0, 2.0], [np.eye(4)] * 2, "as many times as poses"),
        ([0.0, 1.0], [np.eye(4), 2 * np.eye(4)], "pose 1 of Moving"),
        ([0.0, 1.0], [np.eye(4), np.diag([-1.0, -1, 1, 1])], "half a turn apart"),
    ],
)
def test_faulty_motions_are_refused(times: list[float], poses: list[np.ndarray], message: str) -> None:
    """The error names what is wrong."""
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.Moving(times, poses)


def test_unknown_words_are_refused() -> None:
    """With the ones that are known."""
    slid = at(1.0)
    with pytest.raises(pc.PlannercheckError, match="path"):
        pc.Moving([0, 1], [np.eye(4), slid], path="straight")
    with pytest.raises(pc.PlannercheckError, match="outside"):
        pc.Moving([0, 1], [np.eye(4), slid], outside="stop")
    with pytest.raises(pc.PlannercheckError, match="start_time must be a number"):
        pc.Moving.along(None, "hand", None, start_time=np.nan)


def test_an_object_that_moves_is_not_moved_otherwise() -> None:
    """Nothing is half-done: the scene is as it was."""
    scene = _scene()
    deeds = [
        lambda: scene.move("pallet", np.eye(4)),
        lambda: scene.update("pallet", np.zeros((1, 3))),
        lambda: scene.attach("pallet", "hand"),
        lambda: scene.attach("cup", "hand", pc.Moving([0, 1], [np.eye(4)] * 2), parts=pc.Sphere(0.1)),
        lambda: scene.add("floor", pc.HalfSpace((0, 0, 1)), pc.Moving([0, 1], [np.eye(4)] * 2)),
    ]
    for deed in deeds:
        with pytest.raises(pc.PlannercheckError, match=r"move|updated"):
            deed()
    assert scene.object_names == ("pallet", "load", "table")
    assert not scene.attached
    assert len(scene.moving) == 2


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ("moving: {times: [0, 1], poses: [{}, {}]}, position: [0, 0, 0]", "leave out position"),
        ("moving: {times: [0, 1], poses: [{}, {rotation: 1}]}", "pose 1"),
        ("moving: {times: [0, 1], poses: [{}, null]}", "pose 1: it is empty"),
        ("moving: {times: [0, 1]}", "poses"),
        ("moving: {poses: [{}, {}]}", "times"),
        ("moving: {times: [0, 1], poses: [{}, {}], outside: go}", "outside"),
        ("moving: {times: [1, 0], poses: [{}, {}]}", "must grow"),
        ("moving: {times: [1, 2], poses: []}", "as many times"),
    ],
)
def test_faulty_files_are_refused(tmp_path: Path, node: str, message: str) -> None:
    """The error names the file, the object and the key."""
    file = tmp_path / "scene.yaml"
    file.write_text(f"objects: [{{name: pallet, box: {{size: [1, 1, 1]}}, {node}}}]")
    with pytest.raises(pc.PlannercheckError, match=rf"scene\.yaml.*'pallet'.*{message}"):
        pc.Scene.load(file)
