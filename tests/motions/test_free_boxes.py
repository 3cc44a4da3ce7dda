"""Boxes of configurations that are proved free, against states in them."""

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.motions import box_search
from plannercheck.motions.joint_cells import are_free


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))


def states_of(box, n=4000):
    """States in it, half of them corners."""
    rng = np.random.default_rng(0)
    within = rng.uniform(box.lower, box.upper, (n // 2, len(box.lower)))
    corners = np.where(rng.random((n // 2, len(box.lower))) < 0.5, box.lower, box.upper)
    return np.concatenate([within, corners])


@pytest.mark.parametrize("shape", [None, 0.5, [1, 1, 1, 1, 2, 2, 3]])
def test_all_states_of_a_box_are_free(checker, shape):
    q = checker.scene.start("panda")
    volumes = []
    for cells in (1, 60):
        box = checker.free_box(q, shape, cells)
        assert (box.lower < q).all()
        assert (q < box.upper).all()
        assert (box.lower >= checker.robot.lower).all()
        assert (box.upper <= checker.robot.upper).all()
        assert box.cells <= cells
        assert checker.check_states(states_of(box)).all()
        volumes.append(box.volume)
    assert volumes[1] > volumes[0]
    a, b = box.half_spaces()
    assert (a @ q <= b).all()
    np.testing.assert_array_equal(np.sort(b), np.sort(np.concatenate([box.upper, -box.lower])))


def test_a_slide_before_a_wall_is_free_up_to_the_wall(tmp_path):
    path = tmp_path / "slide.urdf"
    path.write_text(
        '<robot name="slide"><link name="base"/><link name="body"><collision><geometry>'
        '<box size="0.2 0.2 0.2"/></geometry>'
        '</collision></link><joint name="x" type="prismatic"><parent link="base"/><child link="body"/>'
        '<axis xyz="1 0 0"/>'
        '<limit lower="-1" upper="3" effort="1" velocity="1"/></joint></robot>'
    )
    scene, pose = pc.Scene("wall"), np.eye(4)
    pose[0, 3] = 1.0
    scene.add("wall", pc.Box((0.2, 1.0, 1.0)), pose)
    checker = pc.Checker(pc.Robot.from_urdf(path), scene)
    box = checker.free_box([0.3])
    assert box.lower[0] == -1.0
    assert 0.75 < box.upper[0] < 0.8  # where the box touches the wall
    assert checker.free_box([1.0]) is None


@pytest.mark.parametrize("off", [1e-9, 0.5])
def test_a_configuration_beyond_the_limits_is_named(off):
    """A search around it would not end."""
    checker = pc.Checker(pc.Robot.load("panda"), self_collision=False)
    q = np.array(pc.Scene.load("bookshelf").start("panda"))
    q[[0, 3]] = checker.robot.upper[0] + off, checker.robot.lower[3] - off
    with pytest.raises(pc.PlannercheckError, match="panda_joint1, panda_joint4: beyond the limits"):
        checker.free_box(q)


def test_a_joint_without_limits_turns_once(tmp_path):
    path = tmp_path / "wheel.urdf"
    path.write_text(
        '<robot name="wheel"><link name="base"/><link name="wheel"><collision><geometry>'
        '<sphere radius="0.1"/></geometry></collision></link><joint name="axle" type="continuous">'
        '<parent link="base"/><child link="wheel"/><axis xyz="1 0 0"/></joint></robot>'
    )
    scene, pose = pc.Scene("stone"), np.eye(4)
    pose[2, 3] = 1.0
    scene.add_sphere("stone", 0.1, pose)
    box = pc.Checker(pc.Robot.from_urdf(path).with_group(["axle"]), scene).free_box([0.5])
    assert (box.lower[0], box.upper[0]) == (0.5 - np.pi, 0.5 + np.pi)


def test_a_shape_is_its_proportions(checker):
    q = checker.scene.start("panda")
    boxes = [checker.free_box(q, size * np.arange(1.0, 8.0), 30) for size in (1.0, 2.0**-20, 2.0**1000)]
    assert all(np.array_equal(box.lower, boxes[0].lower) for box in boxes)


def test_a_row_of_a_table_is_the_box_alone(checker):
    """Whatever the threads, the order and the other rows; boxes of few cells end before those of many."""
    q = np.concatenate([checker.robot.random_configurations(12, seed=1), [checker.scene.start("panda")]])
    alone = [checker.free_box(row, cells=20) for row in q]
    order = np.random.default_rng(0).permutation(len(q))
    for rows, threads in ((np.arange(len(q)), 1), (order, np.int64(3)), (order[:5], 1), (order[:0], 2)):
        table = checker.free_boxes(q[rows], cells=20, threads=threads)
        assert len(table) == len(rows) == table.volume.size
        assert table.lower.shape == table.upper.shape == (len(rows), 7)
        for k, row in enumerate(rows.tolist()):
            box, one = table.box(k), alone[row]
            assert table.proved[k] == (one is not None)
            if one is None:
                assert box is None
                assert np.isnan([table.lower[k], table.upper[k]]).all()
                assert table.volume[k] == table.cells[k] == 0
                with pytest.raises(pc.PlannercheckError, match=f"row {k}: no box is proved"):
                    table.half_spaces(k)
            else:
                np.testing.assert_array_equal([box.lower, box.upper], [one.lower, one.upper])
                assert (box.cells, box.volume) == (one.cells, one.volume) == (table.cells[k], table.volume[k])
                np.testing.assert_array_equal(table.half_spaces(k)[1], one.half_spaces()[1])
    assert 0 < sum(one is None for one in alone) < len(alone)
    assert {one.cells for one in alone if one} - {20}


def test_tables_do_not_depend_on_how_many_rows_are_searched_at_once(checker, monkeypatch):
    q = np.array([checker.scene.start("panda"), checker.scene.goal("panda")])
    table = checker.free_boxes(q, cells=20)
    monkeypatch.setattr(box_search, "_CELLS_AT_ONCE", 1)
    np.testing.assert_array_equal(checker.free_boxes(q, cells=20).lower, table.lower)
    assert str(table).startswith("FreeBoxes(2 of 2 proved")


def test_a_cell_is_judged_alone():
    """All pairs judge it, also if it has no width."""
    asked = []

    class Certifier:
        def check_curves(self, curves, tolerance, threads):
            asked.append(curves.need_all_pairs)
            return np.ones(len(curves.points), dtype=bool)

    for width in (0.0, 1e-12, 1.0):
        are_free(Certifier(), np.zeros((1, 2)), np.full((1, 2), width))
    assert asked == [True] * 3


def test_what_is_no_table_of_boxes_is_named(checker):
    q = np.repeat([checker.scene.start("panda")], 3, axis=0)
    table = checker.free_boxes(q[:1], cells=1)
    for row in (1, -1, 0.0, True, None):
        with pytest.raises(pc.PlannercheckError, match="row must be one of 1 of the table, from 0 on"):
            table.box(row)
    with pytest.raises(pc.PlannercheckError, match="threads must be"):
        checker.free_boxes(q, threads=0)
    q[2, 1] = checker.robot.upper[1] + 1
    with pytest.raises(pc.PlannercheckError, match=r"^row 2: panda_joint2: beyond the limits"):
        checker.free_boxes(q)


def test_what_is_no_box_is_named(checker):
    q = checker.scene.start("panda")
    for arguments, message in (
        ({"shape": [1, 2]}, "7 positive numbers"),
        ({"shape": 0}, "positive"),
        ({"shape": float("nan")}, "positive"),
        ({"cells": 0}, "cells must be"),
        ({"cells": True}, "cells must be"),
        ({"cells": 2.0}, "cells must be"),
    ):
        with pytest.raises(pc.PlannercheckError, match=message):
            checker.free_box(q, **arguments)


def test_unit_vectors_have_no_boxes(tmp_path):
    path = tmp_path / "floats.urdf"
    path.write_text(
        '<robot name="floats"><link name="base"/><link name="body"><collision><geometry><sphere radius="1"/>'
        '</geometry></collision></link><joint name="j" type="floating"><parent link="base"/>'
        '<child link="body"/></joint></robot>'
    )
    with pytest.raises(pc.PlannercheckError, match="unit vectors"):
        pc.Checker(pc.Robot.from_urdf(path)).free_box([0, 0, 0, 0, 0, 0, 1.0])
