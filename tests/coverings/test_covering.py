"""Audits, growth, fits and neighbours of robots, against samples and moved poses."""

import numpy as np
import pytest
from covering_oracle import distances, element, write_robot

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.coverings.neighbours import of_neighbours
from plannercheck.coverings.primitives import Primitives

LINKS = {
    "base": element('<box size="0.4 0.4 0.2"/>') + element('<cylinder radius="0.1" length="0.6"/>', "0 0 0.3"),
    "arm": element('<capsule radius="0.1" length="0.5"/>', "0.5 0 0", "0 1.5707963267948966 0"),
    "hand": element('<sphere radius="0.15"/>'),
}
TURN = [[0.9, 0.0, 0.1], [1, 2, 3]]


@pytest.fixture
def robot(tmp_path):
    return write_robot(tmp_path, LINKS)


@pytest.fixture
def model(robot):
    return pc.Covering(
        robot,
        {
            "base": Primitives.of([((0, 0, 0), 0.3), ((0, 0, 0.4), 0.2)]),
            "arm": Primitives.of([((0.3, 0, 0), 0.15), ((0.6, 0, 0), 0.2)]),
            "hand": Primitives.of([((0, 0, 0), 0.15)]),
        },
    )


def test_an_audit_says_what_is_outside(model):
    found = model.audit(tolerance=1e-4)
    base, arm, hand = found.links
    assert (hand.name, hand.covered, hand.outside, hand.witness, hand.excess < 2e-2) == (
        "hand",
        True,
        (0, 0),
        None,
        True,
    )
    # The base's cylinder ends at z = 0.6, its rim is hypot(0.1, 0.2) from a centre.
    assert base.outside[0] <= np.hypot(0.1, 0.2) - 0.2 <= base.outside[1]
    assert base.outside[1] - base.outside[0] < 1.1e-4
    # The arm reaches from 0.15 to 0.85; the sphere about 0.3 ends at 0.15, that about 0.6 at 0.8.
    assert arm.outside[0] <= 0.05 <= arm.outside[1]
    assert arm.witness[0] == pytest.approx(0.85, abs=1e-3)
    assert not found.covered
    assert 0 < arm.share < 0.5
    # The sphere of 0.2 about (0.6, 0, 0) around a capsule of 0.1 sticks out by 0.1.
    assert 0.1 - 1e-6 <= arm.excess < 0.105
    assert "base" in found._repr_html_()
    assert found.as_json()["links"][2]["covered"] is True


def test_the_excess_is_of_the_nearest_body(tmp_path):
    sphere = '<sphere radius="0.15"/>'
    robot = write_robot(tmp_path, {"base": element(sphere) + element(sphere, "1 0 0")})
    cover = Primitives.of([((0, 0, 0), 0.25), ((1, 0, 0), 0.25)])
    (link,) = pc.Covering(robot, {"base": cover}).audit().links
    assert 0.1 <= link.excess < 0.13
    assert link.mean_excess == pytest.approx(0.1, abs=1e-9)
    assert link.area == pytest.approx(2 * 4 * np.pi * 0.25**2, rel=1e-9)


def test_growth_is_the_least_that_covers(model):
    grown = model.inflated()
    assert grown.verify()
    assert grown.growth == pytest.approx(0.05, abs=2e-6)
    assert grown.audit().covered
    each = model.inflated(by_link=True)
    assert each.verify()
    np.testing.assert_array_equal(each.spheres("hand"), model.spheres("hand"))
    np.testing.assert_array_equal(each.spheres("arm"), grown.spheres("arm"))
    less = {link: cover.grown(grown.growth - 4e-6) for link, cover in model.links.items()}
    assert not pc.Covering(model.robot, less).verify()


def test_growth_cannot_cover_links_without_primitives(robot, model):
    with pytest.raises(pc.PlannercheckError, match="no primitives: arm, hand"):
        pc.Covering(robot, {"base": model.links["base"]}).inflated()
    (arm,) = (row for row in pc.Covering(robot, {}).audit().links if row.name == "arm")
    assert arm.outside == (np.inf, np.inf)
    assert arm.witness is not None


def test_a_fit_covers_and_reads_the_same_in_32_bits(robot, tmp_path):
    fit = pc.Covering.fit(robot, spheres=8)
    assert len(fit) == 8
    assert fit.verify()
    rows = np.concatenate([fit.spheres(link) for link in fit.links])
    np.testing.assert_array_equal(rows, rows.astype(np.float32))
    for name in ("m.yml", "m.urdf", "m.json"):
        fit.save(tmp_path / name)
        again = pc.Covering.load(tmp_path / name, robot)
        assert all((again.spheres(link) == fit.spheres(link)).all() for link in fit.links)
    more = pc.Covering.fit(robot, spheres=16)
    assert more.audit().mean_excess < fit.audit().mean_excess


@pytest.mark.parametrize("spheres", [2, 4, 9])
def test_a_fit_splits_no_ball_that_holds_nothing(tmp_path, spheres):
    robot = write_robot(tmp_path, {"base": element('<sphere radius="1e-7"/>')})
    fit = pc.Covering.fit(robot, spheres=spheres)
    assert len(fit) == spheres
    assert fit.verify()


def test_a_fit_reaches_an_excess_with_few_spheres(robot):
    fit = pc.Covering.fit(robot, spheres=40, excess=0.12)
    found = fit.audit()
    assert found.covered
    assert max(link.excess for link in found.links) <= 0.12
    assert len(fit) < 20
    with pytest.raises(pc.PlannercheckError, match=r"4 spheres do not reach an excess of 0\.01 m"):
        pc.Covering.fit(robot, spheres=4, excess=0.01)


def test_what_neighbours_hold_they_hold_in_all_configurations(model):
    """Points of the spheres that count are in the neighbours' spheres at random configurations."""
    robot, rng = model.robot, np.random.default_rng(0)
    poses = robot.link_poses(rng.uniform(robot.lower, robot.upper, (50, robot.nq)))
    for link in robot.link_names:
        counted = of_neighbours(robot, model.links, link)
        directions = rng.normal(size=(200, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        for (centre, _), radius in zip(counted.ends, counted.radii, strict=True):
            points = centre + radius * directions
            for pose in poses:
                world = points @ pose[robot.link_index(link)][:3, :3].T + pose[robot.link_index(link)][:3, 3]
                outside = np.min(
                    [
                        distances(cover, (world - pose[i][:3, 3]) @ pose[i][:3, :3])
                        for name, cover in model.links.items()
                        if (i := robot.link_index(name)) != robot.link_index(link)
                    ],
                    axis=0,
                )
                assert outside.max() <= 1e-12
    # The arm's axis of turn passes the base's frame at x = 1: none of the base's spheres are as wide.
    assert len(of_neighbours(robot, model.links, "arm")) == 1  # the hand's, about its own axis
    assert of_neighbours(robot, model.links, "arm").radii[0] == pytest.approx(0.15)


def test_neighbours_cover_what_is_at_the_joint(model):
    links = {**model.links, "hand": Primitives.of([((0, 0, 0), 0.3)])}
    links["arm"] = Primitives.of([((0.3, 0, 0), 0.17), ((0.6, 0, 0), 0.2)])
    wide = pc.Covering(model.robot, links)
    alone, together = wide.audit(), wide.audit(neighbours=True)
    assert not alone.links[1].covered
    assert together.links[1].covered
    assert together.neighbours


def test_held_joints_keep_neighbours_in_place(model):
    held = model.robot.with_group(["arm_hand"])
    cover = {"base": Primitives.of([((0.5, 0, 0), 0.2)], boxes=[(np.eye(4), (0.1, 0.1, 0.1))])}
    counted = of_neighbours(held, cover, "arm")
    np.testing.assert_allclose(counted.ends[0, 0], [-0.5, 0, 0], atol=1e-12)
    assert len(counted) == 2
    assert len(of_neighbours(model.robot, cover, "arm")) == 0


def test_hulls_solids_and_own_geometry(robot, model):
    assert model.audit(geometry="hull").outside == model.audit(geometry=None).outside
    with pytest.raises(pc.PlannercheckError, match="unknown geometry 'mesh'"):
        model.audit(geometry="mesh")
    together = pc.Robot.together({"a": robot})
    with pytest.raises(pc.PlannercheckError, match="unknown link 'base'"):
        model.audit(together)


@pytest.mark.parametrize(
    ("cover", "words"),
    [
        (Primitives.of([((0, 0, 0), -1.0)]), "a radius must be finite and not negative"),
        (Primitives.of([((0, 0, 0), np.nan)]), "a radius must be finite"),
        (Primitives.of([((0, np.inf, 0), 1.0)]), "centres must be finite"),
        (Primitives.of(boxes=[(np.eye(4), (1, -1, 1))]), "a size must be finite"),
    ],
)
def test_faulty_numbers_are_errors(robot, cover, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        pc.Covering(robot, {"arm": cover})


@pytest.mark.parametrize("wanted", [{"spheres": 2}, {"spheres": 4.5}, {"excess": 0.0}, {"excess": "1"}])
def test_faulty_wishes_are_errors(robot, wanted):
    with pytest.raises(pc.PlannercheckError, match=r"at least 3, one a link|positive length"):
        pc.Covering.fit(robot, **wanted)


def test_the_command(model, tmp_path, capsys):
    urdf, path = str(tmp_path / "robot.urdf"), str(tmp_path / "m.json")
    model.save(path)
    assert main(["cover", "audit", "--robot", urdf, "--model", path, "--output", str(tmp_path / "grown.yml")]) == 1
    assert "not all links are covered: 50.0" in capsys.readouterr().out
    findings = str(tmp_path / "found.json")
    grown = ["cover", "audit", "--robot", urdf, "--model", str(tmp_path / "grown.yml"), "--findings", findings]
    assert main(grown) == 0
    fit = str(tmp_path / "fit.urdf")
    assert main(["cover", "fit", "--robot", urdf, "--spheres", "5", "--output", fit]) == 0
    assert main(["cover", "audit", "--robot", urdf, "--model", fit, "--geometry", "hull", "--neighbours"]) == 0
    assert "all links are covered, proved" in capsys.readouterr().out
    assert main(["cover", "audit", "--robot", urdf]) == 2
    assert main(["cover", "fit", "--robot", urdf, "--model", path]) == 2
    assert main(["cover", "audit", "--robot", urdf, "--model", path, "--excess", "1"]) == 2
    assert "--excess counts only with fit" in capsys.readouterr().err
