"""Allowed collision matrices: the counts are the checker's, proposals load, audits find what was left out wrongly."""

import itertools
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.checking.collision_matrix import adjacent_links, audit, collision_matrix, with_all_joints
from plannercheck.cli.main import main
from plannercheck.common.package_data import example_robot_data
from plannercheck.robots.description import DisabledPair, description_of
from plannercheck.robots.link_tree import LinkTree
from plannercheck.robots.srdf import disabled_collisions, read_srdf

STATES = 1500
AS_MESHES = re.compile(r"^(\S+) and (\S+) are disabled.* as meshes in (\S+) %", re.MULTILINE)


@pytest.fixture(scope="module")
def panda():
    return collision_matrix(pc.Robot.load("panda"), STATES, seed=4)


@pytest.fixture(scope="module")
def everything():
    """A checker that tests all bodies on different joints but adjacent ones, without skips."""
    description = description_of("panda")
    plain = pc.Robot.from_urdf(description.urdf, package_dirs=example_robot_data())
    return pc.Checker(with_all_joints(plain), tuning=pc.Tuning(reach=False, learning=False))


def test_counts_are_those_of_a_checker_of_all_pairs(panda, everything):
    assert everything.robot.joint_names == panda.robot.joint_names
    colliding = everything.colliding_pairs(panda.configurations)
    by_links = {}
    for k in range(len(everything.pairs)):  # some links have several bodies
        links = frozenset(everything.pair_names(k))
        by_links[links] = by_links.get(links, False) | colliding[:, k]
    compared = 0
    for pair in panda.pairs:
        if pair.links in by_links:
            truth = by_links[pair.links]
            assert pair.collisions == truth.sum(), pair
            assert pair.first == (int(truth.argmax()) if truth.any() else None)
            np.testing.assert_array_equal(panda.colliding_rows(pair), np.flatnonzero(truth))
            compared += truth.any()
    assert compared > 15


def test_reasons_are_what_was_found(panda):
    reasons = {reason: [pair for pair in panda.pairs if pair.reason == reason] for reason in ("never", "proved never")}
    assert all(pair.collisions == 0 for pairs in reasons.values() for pair in pairs)
    assert len(reasons["proved never"]) > 5
    links = len({body.link for body in panda.robot.bodies})
    assert len(panda.pairs) == links * (links - 1) // 2
    assert all(pair.collisions > 0 for pair in panda.pairs if pair.reason is None)
    tested = next(pair for pair in panda.pairs if pair.reason is None)
    assert panda.example(tested) == dict(
        zip(panda.robot.joint_names, panda.configurations[tested.first].tolist(), strict=True)
    )


def test_links_without_bodies_connect_their_neighbours():
    #       base - empty - a - b,   empty - c - hollow - d
    parents = {"empty": "base", "a": "empty", "b": "a", "c": "empty", "hollow": "c", "d": "hollow"}
    names = ("base", "empty", "a", "b", "c", "hollow", "d")
    tree = LinkTree(names, tuple(range(7)), parents, {})
    found = adjacent_links(tree, {"base", "a", "b", "c", "d"})
    expected = [("base", "a"), ("base", "c"), ("a", "c"), ("a", "b"), ("c", "d")]
    assert found == {frozenset(pair) for pair in expected}


def test_audits_find_pairs_that_are_disabled_yet_collide(panda):
    wrong = next(pair for pair in panda.pairs if pair.reason is None)
    right = next(pair for pair in panda.pairs if pair.reason == "proved never")
    adjacent = next(pair for pair in panda.pairs if pair.reason == "adjacent")
    declared = [DisabledPair(p.link_b, p.link_a, "Never") for p in (wrong, right, adjacent, wrong)]
    found = audit(panda, [*declared, DisabledPair("panda_link1", "panda_link99", "Never")])
    assert [pair.found for pair in found.suspects] == [wrong]
    assert len(found.disabled) == 4
    assert [pair.found for pair in found.disabled if pair.declared.link_b == "panda_link99"] == [None]


def test_audit_of_the_shipped_panda_names_the_hand_and_the_fifth_link(panda):
    description = description_of("panda")
    found = audit(panda, disabled_collisions(read_srdf(description.srdf)))
    assert found.suspects[0].found.links == {"panda_hand", "panda_link5"}
    assert not found.hopeless


@pytest.mark.parametrize("suffix", ["srdf", "yaml"])
def test_written_proposals_load_and_leave_just_these_pairs_out(panda, tmp_path, suffix, capsys):
    output = tmp_path / f"proposal.{suffix}"
    assert main(["acm", "--robot", "panda", "--states", str(STATES), "--seed", "4", "--output", str(output)]) == 0
    assert "proved never" in capsys.readouterr().out
    description = description_of("panda")
    if suffix == "srdf":
        robot = pc.Robot.from_urdf(description.urdf, output, example_robot_data())
        old, new = (ElementTree.parse(path).getroot() for path in (description.srdf, output))
        assert [each.get("name") for each in old.findall("group")] == [
            each.get("name") for each in new.findall("group")
        ]
    else:
        robot = pc.Robot.load(output)
        assert robot.joint_names == panda.robot.joint_names[:7]
    kept = {frozenset((robot.bodies[a].link, robot.bodies[b].link)) for a, b in robot.self_pairs.tolist()}
    left_out = {pair.links for pair in panda.disabled()}
    joints = {link: robot.model.frames[robot.model.getBodyId(link)].parentJoint for link in robot.link_names}
    links = {body.link for body in robot.bodies}
    movable = {frozenset(p) for p in itertools.combinations(links, 2) if joints[p[0]] != joints[p[1]]}
    assert kept == movable - left_out


def test_the_command_audits(tmp_path, capsys):
    common = ["acm", "--robot", "panda", "--states", "300"]
    assert main([*common, "--audit", "--meshes", "20"]) == 1
    out = capsys.readouterr().out
    assert "panda_link5 and panda_hand are disabled (Default), yet they collide in" in out
    assert "as meshes in" in out
    assert "e.g. at [" in out
    srdf = tmp_path / "careful.srdf"
    srdf.write_text(
        '<robot name="panda"><disable_collisions link1="panda_link0" link2="panda_link1" reason="Adjacent"/></robot>'
    )
    assert main([*common, "--audit", "--srdf", str(srdf)]) == 1  # other adjacent links are tested and always collide
    assert "are tested and collide in every state: none is valid" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "acm needs --robot"),
        (["--robot", "panda", "--states", "0"], "--states must be at least 1"),
        (["--robot", "panda", "--output", "x.txt", "--states", "2"], "must end in .srdf or .yaml"),
        (["--robot", "truck_trailer"], "planar"),
        (["--audit", "--srdf", "x.srdf"], "need --robot"),
    ],
)
def test_mistakes_are_named(arguments, message, capsys):
    assert main(["acm", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_the_audit_counts_meshes_exactly(capsys):
    """Against one query a pair and state."""
    assert main(["acm", "--robot", "ur5", "--audit", "--states", "400", "--meshes", "400"]) == 1
    told = {tuple(found[:2]): float(found[2]) for found in AS_MESHES.findall(capsys.readouterr().out)}
    assert len(told) == 3
    robot = with_all_joints(pc.Robot.load("ur5", geometry="solid"))
    q = robot.random_configurations(400, 0)
    poses, bodies = robot.link_poses(q), {body.link: body for body in robot.bodies}
    solids = {
        link: pc.Polytope(bodies[link].shape.vertices).of_solid(bodies[link].shape) for link in itertools.chain(*told)
    }
    for (a, b), percent in told.items():
        on_a, on_b = (poses[:, robot.link_index(link)] @ bodies[link].pose for link in (a, b))
        collide = [pc.intersects(solids[a], solids[b], *pair) for pair in zip(on_a, on_b, strict=True)]
        assert percent == round(100 * np.mean(collide), 2)


def test_srdfs_that_name_unknown_links_are_said(tmp_path):
    description = description_of("panda")
    root = ElementTree.parse(description.srdf).getroot()
    ElementTree.SubElement(root, "disable_collisions", link1="panda_link8", link2="panda_lnk3", reason="Never")
    (tmp_path / "typo.srdf").write_bytes(ElementTree.tostring(root))
    with pytest.warns(RuntimeWarning) as caught:
        pc.Robot.from_urdf(description.urdf, tmp_path / "typo.srdf", example_robot_data())
    texts = " ".join(str(each.message) for each in caught)
    assert "links that the URDF does not know: panda_lnk3 (did you mean 'panda_link3'" in texts
