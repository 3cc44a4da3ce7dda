"""A sample of the stress of solids, what it counts and keeps. `plannercheck stress --solids` runs more of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.evaluation.campaign import posed_pairs
from plannercheck.evaluation.campaign.campaign import run
from plannercheck.evaluation.campaign.cases import load, save
from plannercheck.evaluation.campaign.pairs import INSIDE, TRUTH, PairCase, smaller
from plannercheck.evaluation.campaign.supervised_process import Supervised
from plannercheck.evaluation.campaign.tallies import EXCEPTION, TIMEOUT, Tally, total
from plannercheck.evaluation.stress_solids import judges, robot_links
from plannercheck.evaluation.stress_solids.bodies import Body, decided
from plannercheck.evaluation.stress_solids.campaign import campaign
from plannercheck.evaluation.stress_solids.draws import Draw
from plannercheck.evaluation.stress_solids.other_libraries import CoalMeshes, FclMeshes
from plannercheck.evaluation.stress_solids.robot_links import link_draw
from plannercheck.evaluation.stress_solids.solid_families import SOLID_FAMILIES
from plannercheck.evaluation.stress_solids.surfaces import ball

SAMPLE = 1500  # pairs
SUITES = {"solids": lambda: campaign(0)}
CASES = sorted((Path(__file__).parent / "solid_cases").glob("*.json"))


SUITE = campaign(2027)


@pytest.fixture(scope="module")
def tally() -> Tally[PairCase[Body]]:
    return run(SUITE, SAMPLE)


def test_nothing_fails_on_a_sample(tally: Tally[PairCase[Body]]) -> None:
    assert tally.failures == 0, "\n".join(SUITE.lines(tally))
    assert not tally.cases
    assert tally.judged >= SAMPLE
    assert total(tally.counts, outcome=INSIDE) > 0


def test_every_way_of_asking_was_asked(tally: Tally[PairCase[Body]]) -> None:
    unasked = posed_pairs.UNFIT
    asked = {who: total(tally.counts, who=who) - total(tally.counts, who=who, outcome=unasked) for who in judges.OURS}
    assert asked["batch"] == asked["swapped"] == asked["public"] == tally.judged
    assert min(asked.values()) > tally.draws


def test_the_tables_count_every_pair(tally: Tally[PairCase[Body]]) -> None:
    sums = [line.split() for line in SUITE.lines(tally) if line.startswith("all")]
    assert len(sums) == 2
    inside = total(tally.counts, outcome=INSIDE)
    for each in sums:
        assert each[1:] == [str(tally.judged), sums[0][2], str(inside), "0", "0", "0"]


def test_a_question_that_takes_too_long_is_left_behind() -> None:
    import time

    def sleeps() -> list[posed_pairs.Outcome]:
        time.sleep(5)
        return [True]

    def fails() -> list[posed_pairs.Outcome]:
        raise RuntimeError

    assert posed_pairs.limited(sleeps, 2, limit=0.05) == [TIMEOUT] * 2
    assert posed_pairs.limited(fails, 2) == [EXCEPTION] * 2


def test_distances_that_are_wrong_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A millionth too long or short, a lower bound above it, 0 where nothing is shared and the other way round."""
    sphere = Body("ball", ball(60))
    pose = at(1.5, 0.25, 0)
    drawn = Draw("ball", "", sphere, sphere, np.stack([pose, np.eye(4)]), np.tile(np.eye(4), (2, 1, 1)), ("any",) * 2)
    truth = [False, True]
    told = judges.distance
    assert judges._distances(drawn, truth, [0, 1]) == truth
    for change in (
        lambda d: replace(d, distance=d.distance * (1 + 1e-6)),
        lambda d: replace(d, distance=d.distance * (1 - 1e-6), lower_bound=0.0),
        lambda d: replace(d, lower_bound=d.lower_bound + 1e-9),
        lambda d: replace(d, distance=0.0 if d.distance else 1.0),
    ):
        monkeypatch.setattr(judges, "distance", lambda *a, change=change: change(told(*a)))
        assert judges._distances(drawn, truth, [0])[0] != truth[0]


def box_case(shift: float) -> PairCase[Body]:
    """Two balls that touch in a corner, one of them moved."""
    pose = at(1 + shift)
    return PairCase("a name", Body("ball", ball(20)), Body("ball", ball(20), 0.25), pose, np.eye(4))


def test_a_case_keeps_every_bit(tmp_path: Path) -> None:
    case = box_case(1e-17 / 3)
    case = replace(case, p=replace(case.p, surface=case.p.surface.scaled(1 / 3), is_convex=True))
    save(tmp_path / "case.json", "solids", case.document())
    _, again = load(tmp_path / "case.json", SUITES)
    for body, same in ((case.p, again.p), (case.r, again.r)):
        np.testing.assert_array_equal(body.surface.points, same.surface.points)
        np.testing.assert_array_equal(body.surface.triangles, same.surface.triangles)
        assert (body.family, body.inflation_radius, body.is_convex) == (
            same.family,
            same.inflation_radius,
            same.is_convex,
        )
    np.testing.assert_array_equal(case.pose_p, again.pose_p)
    (tmp_path / "none.json").write_text('{"campaign": "solids"}')
    with pytest.raises(pc.PlannercheckError, match="no case of a stress"):
        load(tmp_path / "none.json", SUITES)


def test_a_failure_is_shrunk_to_the_triangles_that_it_takes() -> None:
    """Taken for failing while the bodies meet: one triangle of each is left."""
    case = replace(box_case(0.0), r=Body("ball", ball(20)))

    def meets(tried: PairCase[Body]) -> bool:
        return bool(decided(tried.p, tried.pose_p[None], tried.r, tried.pose_r[None])[0])

    assert meets(case)
    left = smaller(case, meets)
    assert [len(body.surface.triangles) for body in (left.p, left.r)] == [1, 1]
    assert [len(body.surface.points) for body in (left.p, left.r)] == [3, 3]
    assert SUITE.faults(case) == {}


def test_peers_find_surfaces_that_cross_and_miss_what_is_inside() -> None:
    rng = np.random.default_rng(1)
    ring = Body("torus", SOLID_FAMILIES["torus"](300, rng))
    small = Body("ball", ball(60).scaled(0.01))
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, 0, 3] = [0.3 + ring.size / 2 - 0.3, 0.3, 0.0]  # about the surface, in the tube, in the hole
    drawn = Draw("torus", "", small, ring, poses, np.tile(np.eye(4), (3, 1, 1)), ("any",) * 3)
    assert decided(small, poses, ring, drawn.poses_r).tolist() == [1, 3, 0]
    for peer in (FclMeshes(), CoalMeshes()):
        assert Supervised(peer).outcomes(drawn) == [True, False, False]
    inflated = replace(drawn, p=replace(small, inflation_radius=0.1))
    assert list(FclMeshes().outcomes(inflated)) == ["unfit"] * 3


def test_the_command_asks_a_case_again(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["stress", "--links"]) == main(["stress", "--parts", "5", "--links"]) == 2
    case = PairCase("touching", *(Body("ball", ball(20)),) * 2, box_case(0.0).pose_p, np.eye(4))
    save(tmp_path / "case.json", "solids", case.document())
    assert main(["stress", "--case", str(tmp_path / "case.json")]) == 0
    assert "nothing is wrong now" in capsys.readouterr().out


def test_links_of_robots_are_drawn_about_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a robot all of whose links are meshes, and of one of boxes and cylinders with two meshes."""
    monkeypatch.setattr(robot_links, "shipped_robots", lambda: ["ur5", "baxter"])
    for number in range(4):
        drawn = link_draw(7, number)
        assert drawn.family == ("ur5", "baxter")[number % 2]
        shared = decided(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r) != 0
        assert shared[[k for k, name in enumerate(drawn.offsets) if name == "-1e-3"]].all()
        assert not shared[[k for k, name in enumerate(drawn.offsets) if name == "next"]].any()
    suite = campaign(7, of_links=True)
    tally = run(suite, 100)
    assert tally.failures == 0, "\n".join(suite.lines(tally))
    assert {entry.family for entry in tally.counts if entry.who == TRUTH} == {"ur5", "baxter"}


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_kept_case(path: Path) -> None:
    """Bodies that touch by construction, and the next doubles at which they do not, in every way of asking."""
    _, case = load(path, SUITES)
    shared = bool(decided(case.p, case.pose_p[None], case.r, case.pose_r[None], every=True)[0])
    assert shared == path.stem.endswith("touching")
    assert SUITE.faults(case) == {}
