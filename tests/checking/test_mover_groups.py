"""Neighbours in a chain are tested together against obstacles and against each other: the same pairs are left."""

import numpy as np
import pytest
from poses import at

import plannercheck as pc


def two_arms():
    """Two arms that reach each other."""
    return pc.Robot.together({"left": pc.Robot.load("panda"), "right": (pc.Robot.load("ur5"), at(0.7, 0.3))})


ROBOTS = {"panda": lambda: pc.Robot.load("panda"), "baxter": lambda: pc.Robot.load("baxter"), "two arms": two_arms}


@pytest.mark.filterwarnings("ignore:.*touches obstacle:RuntimeWarning")
@pytest.mark.parametrize("robot", ROBOTS)
def test_mover_groups_change_nothing_but_time(robot, monkeypatch):
    """The states that they are chosen by: none, the usual ones, all links in one place, all far apart."""
    q = ROBOTS[robot]().random_configurations(300, 5)
    links = len(ROBOTS[robot]().link_names)
    gathered = np.repeat(np.eye(4)[None], links, axis=0)
    scattered = gathered.copy()
    scattered[:, 0, 3] = 1e3 * np.arange(links)
    found = []
    for samples in (np.zeros((0, links, 4, 4)), None, gathered[None], scattered[None]):
        known = ROBOTS[robot]()
        if samples is not None:
            monkeypatch.setattr(pc.Robot, "sampled_link_poses", property(lambda _, poses=samples: poses))
        checker = pc.Checker(
            known, pc.Scene.load("kitchen"), tuning=pc.Tuning(overlaps=False, learning=False, apart_cells=False)
        )
        verdicts, colliding = checker.check_states(q), checker.colliding_pairs(q)
        counted = checker.statistics()
        found.append((verdicts, colliding, {k: counted[k] for k in ("pairs", "bounds", "boxes", "skipped")}))
    for verdicts, colliding, counted in found[1:]:
        np.testing.assert_array_equal(verdicts, found[0][0])
        np.testing.assert_array_equal(colliding, found[0][1])
        assert counted["pairs"] == found[0][2]["pairs"]
        assert counted["bounds"] == found[0][2]["bounds"]
