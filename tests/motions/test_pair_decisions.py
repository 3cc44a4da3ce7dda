"""Pairs of links decided by their joints' values, against dense samples and geometry that is known."""

import json

import numpy as np
import pytest
from pointers import arm, disc

import plannercheck as pc
from plannercheck.checking.collision_matrix import colliding_rows
from plannercheck.cli.main import main
from plannercheck.motions.pair_decisions import PairDecider


@pytest.mark.parametrize("joint", ["revolute", "continuous"])
def test_a_millirad_that_collides_is_found_and_a_gap_of_20_um_is_proved(tmp_path, joint):
    """2 mrad of 6 rad: a sample of 2,000 sees them in one of two draws."""
    low = PairDecider(arm(tmp_path, -1e-4, joint))
    found = low.decide("post", "pointer", 5)
    assert found.answer == "collides"
    assert found.joints == ("turn",)
    assert len(colliding_rows(low.robot, found.example[None], "post", "pointer")) == 1
    apart = PairDecider(arm(tmp_path, 2e-5, joint)).decide("post", "pointer", 5)
    assert apart.answer == "never"
    assert apart.open_share == 0
    assert apart.cells > 10
    assert apart.example is None


def test_what_overlaps_at_every_angle_always_collides(tmp_path):
    """The tip begins 1 mm inside of the post's faces, or 1 cm beyond its corners."""
    inside = PairDecider(disc(tmp_path, 0.1 + 0.05 - 0.001)).decide("post", "tip", 5)
    assert inside.answer == "always"
    assert inside.open_share == 0
    assert inside.cells > 1
    beyond = PairDecider(disc(tmp_path, 0.1 * 3**0.5 + 0.06)).decide("post", "tip", 5)
    assert beyond.answer == "never"
    for free in (1e-4, -1e-4):  # the last 0.1 mm of the slide, or none of it
        slid = PairDecider(disc(tmp_path, 0.0, slide=True, height=2 * (3 - 0.01 - free))).decide("post", "tip", 0.5)
        assert slid.answer == ("collides" if free > 0 else "always")


def test_touching_is_a_collision_that_no_cell_proves_away(tmp_path):
    found = PairDecider(arm(tmp_path, 0.0)).decide("post", "pointer", 0.3)
    assert found.answer in ("collides", "open")


def test_what_time_does_not_decide_is_open(tmp_path):
    found = PairDecider(arm(tmp_path, 2e-5)).decide("post", "pointer", 1e-9)
    assert found.answer == "open"
    assert found.open_share == 1


def test_all_pairs_of_the_panda_agree_with_samples():
    decider = PairDecider(pc.Robot.load("panda"))
    robot = decider.robot
    q = robot.random_configurations(20_000, seed=5)
    links = sorted({str(body.link) for body in robot.bodies})
    answers = {}
    for k, a in enumerate(links):
        for b in links[:k]:
            found = decider.decide(a, b, 2)
            answers[a, b] = found.answer
            if found.answer == "never":
                assert not len(colliding_rows(robot, q, a, b))
            elif found.answer == "always":
                assert len(colliding_rows(robot, q, a, b)) == len(q)
            elif found.answer == "collides":
                assert len(colliding_rows(robot, found.example[None], a, b)) == 1
    assert set(answers.values()) == {"never", "always", "collides"}
    assert answers["panda_link7", "panda_link5"] == "collides"


def test_batches_of_cells_are_taken_whole(tmp_path, monkeypatch):
    whole = PairDecider(arm(tmp_path, 2e-5)).decide("post", "pointer", 5)
    monkeypatch.setattr("plannercheck.motions.pair_decisions._BATCH", 3)
    cut = PairDecider(arm(tmp_path, 2e-5)).decide("post", "pointer", 5)
    assert (cut.answer, cut.cells) == ("never", whole.cells)


def test_links_without_bodies_are_named(tmp_path):
    with pytest.raises(pc.PlannercheckError, match="'hub' is no link with collision bodies"):
        PairDecider(arm(tmp_path, 1.0)).decide("post", "hub", 1)


def test_the_command_audits_by_proofs(tmp_path, capsys):
    out = tmp_path / "pairs.json"
    code = main(["acm", "--robot", "panda", "--audit", "--prove", "--states", "200", "--output", str(out)])
    text = capsys.readouterr().out
    assert code == 1
    assert "panda_link5 and panda_link7" in text
    rows = json.loads(out.read_text())["rows"]
    assert {row["answer"] for row in rows} == {"never", "always", "collides"}


def test_the_command_proposes_what_it_proved(tmp_path, capsys):
    out = tmp_path / "ur5.srdf"
    assert main(["acm", "--robot", "ur5", "--prove", "--states", "200", "--output", str(out)]) == 0
    assert "proved never" in capsys.readouterr().out
    assert "not seen to meet" not in out.read_text()
    assert main(["acm", "--robot", "ur5", "--prove", "-1"]) == 2
    assert "--prove takes seconds" in capsys.readouterr().err


def test_levers_are_the_arms_of_the_joints_between(tmp_path):
    """Of a turn the furthest vertex of the body that is moved less, seen from the other; of a slide 1; else none."""
    decider = PairDecider(pc.Robot.load("panda"))
    robot, search = decider.robot, decider.search("panda_link3", "panda_link4")
    (column,) = search.columns
    assert np.flatnonzero(search.levers).tolist() == [column]
    poses = search.body_poses(robot.reference + 1e-6 * np.array([[0], [1]]) * np.eye(robot.nq)[column])
    arms = []
    for k, other in (search.pairs[0], search.pairs[0][::-1]):
        change = np.diff(np.linalg.inv(poses[:, other]) @ poses[:, k], axis=0)[0, :3]
        moved = decider.polytope(k).vertices @ change[:, :3].T + change[:, 3]
        arms.append(np.linalg.norm(moved, axis=1).max() / 1e-6)
    assert search.levers[column] == pytest.approx(min(arms), rel=1e-4)
    slide = PairDecider(disc(tmp_path, 0.0, slide=True, height=1.0)).search("post", "tip")
    assert slide.levers[slide.columns[0]] == 1


@pytest.mark.parametrize("inside", [0.0, 1e-14, 1e-9])
def test_what_touches_by_rounding_stays_open(tmp_path, inside):
    """Kinova's base and first link are in each other by 8e-15 m: that the poses' rounding may feign."""
    path = tmp_path / "stack.urdf"
    path.write_text(
        '<robot name="stack"><link name="low"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>'
        '</link><joint name="turn" type="revolute"><parent link="low"/><child link="high"/><axis xyz="0 0 1"/>'
        f'<origin xyz="0 0 {0.2 - inside!r}"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        '<link name="high"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link></robot>'
    )
    found = PairDecider(pc.Robot.from_urdf(path)).decide("low", "high", 0.3)
    assert found.answer == ("collides" if inside > 1e-12 else "open")
    assert (found.example is None) == (found.answer == "open")


def test_what_touches_first_hides_nothing(tmp_path, monkeypatch):
    """Both links touch at every angle; a bar meets a post at 1 % of them, not the first ones."""
    monkeypatch.setattr("plannercheck.motions.pair_decisions._MEASURED", 1)
    path = tmp_path / "lid.urdf"
    box = '<collision><origin xyz="{0}"/><geometry><box size="{1}"/></geometry></collision>'
    path.write_text(
        f'<robot name="lid"><link name="low">{box.format("0 0 0", "0.2 0.2 0.2")}'
        f'{box.format("-0.5 0 0", "0.02 0.02 1")}</link><link name="high">{box.format("0 0 0", "0.2 0.2 0.2")}'
        f"{box.format('0.5 0 0', '0.1 0.01 0.1')}</link>"
        '<joint name="turn" type="revolute"><parent link="low"/><child link="high"/><axis xyz="0 0 1"/>'
        '<origin xyz="0 0 0.2"/><limit lower="-3.14" upper="3.14" effort="1" velocity="1"/></joint></robot>'
    )
    assert PairDecider(pc.Robot.from_urdf(path)).decide("low", "high", 1.0).answer == "collides"
