"""Pairs that one or two joints move relative to each other are looked up in cells that are proved apart."""

import functools

import numpy as np
import pinocchio as pin
import pytest

import plannercheck as pc
from plannercheck.checking import apart_cells
from plannercheck.common import cache
from plannercheck.common.core import core

ROBOTS = ("panda", "xarm7", "talos", "go2", "g1", "tiago")


@functools.cache
def checkers(name, scene=None):
    """With cells and without."""
    robot = pc.Robot.load(name)
    scene = None if scene is None else pc.Scene.load(scene)
    return tuple(pc.Checker(robot, scene, tuning=pc.Tuning(apart_cells=each)) for each in (True, False))


def cells_of(checker):
    return checker._proofs.in_cells(checker.pairs[~checker.unreachable])


def found_cells(checker):
    """Each pair in cells, its columns, and where it is apart (cells, cells)."""
    chains = checker._proofs._reach._chains
    pairs = checker.pairs[~checker.unreachable]
    for each in cells_of(checker):
        for pair in pairs[each.pairs[each.pairs >= 0]].tolist():
            cut = chains.whole_cut(*pair)
            yield pair, cut, apart_cells.apart_in_cells(chains, cut, tuple(pair), checker._preparation.polytope)


@pytest.mark.parametrize("name", ROBOTS)
def test_verdicts_are_the_same(name):
    on, off = checkers(name)
    assert cells_of(on)
    robot = on.robot
    q = robot.random_configurations(3000, seed=1)
    expected = off.check_states(q)
    assert (on.check_states(q) == expected).all()
    assert (on.check_states(q, threads=2) == expected).all()
    assert [on.is_valid(row) for row in q[:600]] == expected[:600].tolist()
    assert (on.first_colliding_pair(q) == off.first_colliding_pair(q)).all()
    for count in (1, 2, 3, 5, 9):
        assert (on.check_states(q[:count]) == expected[:count]).all()


@pytest.mark.parametrize("name", ROBOTS)
def test_verdicts_at_borders_of_cells(name):
    """At borders, an ulp beside them, at the limits, and beyond these, where the cells say nothing."""
    on, off = checkers(name)
    robot = on.robot
    rng = np.random.default_rng(2)
    for _, cut, apart in found_cells(on):
        q = robot.random_configurations(1500, seed=3)
        for column in cut:
            low, high = robot.lower[column], robot.upper[column]
            places = rng.integers(-2, apart.shape[0] + 3, size=len(q))
            q[:, column] = low + (high - low) * places / apart.shape[0]
            q[:, column] = np.nextafter(q[:, column], rng.choice([-np.inf, np.inf], size=len(q)))
            exactly = rng.random(len(q)) < 0.2
            q[exactly, column] = rng.choice([low, high], size=exactly.sum())
        assert (on.check_states(q) == off.check_states(q)).all()
        assert [on.is_valid(row) for row in q[:200]] == off.check_states(q[:200]).tolist()


def pinocchio_poses(robot, q, bodies):
    """By Pinocchio itself, not by our kernel: (4, 4) of some bodies."""
    model, full = robot.model, robot.expand(q)
    data = model.createData()
    pin.framesForwardKinematics(model, data, full)
    return [data.oMf[model.getFrameId(body.link)].homogeneous @ body.pose for body in bodies]


@pytest.mark.parametrize("name", ROBOTS)
def test_pairs_are_apart_all_over_their_cells(name):
    """In the cells that are nearest to those that are not proved, at their corners: by Pinocchio and the exact test."""
    on, _ = checkers(name)
    robot = on.robot
    rng = np.random.default_rng(4)
    for pair, cut, apart in found_cells(on):
        assert apart.any()
        near = ~apart
        for axis in range(apart.ndim):
            near = near | np.roll(near, 1, axis=axis) | np.roll(near, -1, axis=axis)
        cells = np.argwhere(apart & near)
        if not len(cells):
            cells = np.argwhere(apart)
        bodies = [on.bodies[k] for k in pair]
        polytopes = [on._preparation.polytope(k) for k in pair]
        for cell in rng.permutation(cells)[:40]:
            q = robot.random_configurations(1, seed=int(rng.integers(1 << 30)))[0]
            corner = rng.choice([0.0, 1.0], size=len(cut))
            span = robot.upper[list(cut)] - robot.lower[list(cut)]
            q[list(cut)] = robot.lower[list(cut)] + span * (cell + corner) / apart.shape[0]
            poses = pinocchio_poses(robot, q, bodies)
            assert not pc.intersects(*polytopes, *poses)
            assert pc.distance(*polytopes, *poses).distance > 0


def test_most_of_the_fingers_cells_are_proved():
    on, _ = checkers("panda", "bookshelf")
    (cells,) = cells_of(on)
    assert (cells.pairs >= 0).sum() == 8
    for pair, cut, apart in found_cells(on):
        assert {on.bodies[k].link.removeprefix("panda_") for k in pair} & {"link5"}
        assert cut == (5, 6)
        assert apart.mean() > 0.97


def test_less_is_tested():
    on, off = checkers("g1")
    q = on.robot.random_configurations(2000, seed=5)
    spent = []
    for checker in (on, off):
        before = checker.statistics()
        checker.check_states(q)
        spent.append({name: checker.statistics()[name] - before[name] for name in ("boxes", "centre_axis")})
    assert spent[0]["boxes"] < 0.5 * spent[1]["boxes"]
    assert spent[0]["centre_axis"] < 0.5 * spent[1]["centre_axis"]
    before = [checker.statistics() for checker in (on, off)]
    for checker in (on, off):
        for row in q[:500]:
            checker.is_valid(row)
    on_boxes, off_boxes = (c.statistics()["bounds"] - b["bounds"] for c, b in zip((on, off), before, strict=True))
    assert on_boxes > off_boxes


def with_made_up_cells(may_meet):
    """A checker of the Panda whose pairs of a finger and link 5 are looked up in these cells.

    It learns nothing, as it would ask pairs that collided lately before it looks up their cells.
    """
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene(), tuning=pc.Tuning(learning=False))
    robot = checker.robot
    (real,) = cells_of(checker)
    low, high = robot.lower[[5, 6]], robot.upper[[5, 6]]
    table = core.apart_cells([5, 6], low.tolist(), (np.array(may_meet.shape) / (high - low)).tolist(), may_meet)
    checker._proofs.in_cells = lambda pairs: (real._replace(cells=table),)
    checker._compile()
    return checker, real.pairs


@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (64, 64), (5, 256)])
def test_a_state_is_looked_up_in_its_own_cell(shape):
    """Cells that are made up leave out pairs that collide: just those whose bit is not set, in just their cells."""
    rng = np.random.default_rng(6)
    may_meet = rng.integers(0, 256, size=shape, dtype=np.uint8)
    checker, rows = with_made_up_cells(may_meet)
    plain = pc.Checker(checker.robot, pc.Scene(), tuning=pc.Tuning(apart_cells=False))
    robot = checker.robot
    q = robot.random_configurations(120_000, seed=7)
    q = q[~plain.check_states(q)]
    colliding = plain.colliding_pairs(q)[:, ~plain.unreachable]
    place = (q[:, [5, 6]] - robot.lower[[5, 6]]) / (robot.upper[[5, 6]] - robot.lower[[5, 6]]) * shape
    flags = may_meet[tuple(np.minimum(place.astype(int), np.array(shape) - 1).T)]
    for bit, row in enumerate(rows):
        colliding[:, row] &= (flags >> bit & 1).astype(bool)
    expected = ~colliding.any(axis=1)
    assert 0.02 < expected.mean() < 0.9
    assert (checker.check_states(q) == expected).all()
    assert (checker.check_states(q, threads=2) == expected).all()
    assert [checker.is_valid(row) for row in q[:2000]] == expected[:2000].tolist()
    for count in (1, 2, 3, 7):
        assert (checker.check_states(q[:count]) == expected[:count]).all()
        assert (checker.check_states(q[-count:]) == expected[-count:]).all()


def test_poses_alone_are_in_no_cell():
    checker, _ = with_made_up_cells(np.zeros((4, 4), dtype=np.uint8))
    plain = pc.Checker(checker.robot, pc.Scene(), tuning=pc.Tuning(apart_cells=False))
    q = checker.robot.random_configurations(3000, seed=8)
    assert (checker.check_states(q) != plain.check_states(q)).any()
    poses = checker.robot.link_poses(q)
    first = checker._tables.within_limits.core.first_of_poses(np.ascontiguousarray(poses), 1)
    assert ((first < 0) == plain.check_states(q)).all()


def test_states_beyond_the_limits_are_in_no_cell():
    """Whatever the cells say: the table of all pairs judges these, and its pairs are in none."""
    checker, _ = with_made_up_cells(np.zeros((4, 4), dtype=np.uint8))
    plain = pc.Checker(checker.robot, pc.Scene(), tuning=pc.Tuning(apart_cells=False))
    q = checker.robot.random_configurations(3000, seed=9)
    q[:, 0] = checker.robot.upper[0] + 0.1
    assert (checker.check_states(q) == plain.check_states(q)).all()
    assert not plain.check_states(q).all()


def test_cells_are_of_the_fingers_as_they_are_held():
    robot = pc.Robot.load("panda")
    tables = []
    for width in (0.0, 0.04):
        held = robot.holding({"panda_finger_joint1": width})
        on, off = (pc.Checker(held, pc.Scene(), tuning=pc.Tuning(apart_cells=each)) for each in (True, False))
        q = held.random_configurations(4000, seed=10)
        assert (on.check_states(q) == off.check_states(q)).all()
        tables.append(np.array([apart for *_, apart in found_cells(on)]))
    assert (tables[0] != tables[1]).any()


def test_padding_counts():
    robot = pc.Robot.load("panda")
    on, off = (
        pc.Checker(robot, pc.Scene(), padding=0.03, tuning=pc.Tuning(apart_cells=each)) for each in (True, False)
    )
    q = robot.random_configurations(4000, seed=11)
    assert cells_of(on)
    assert (on.check_states(q) == off.check_states(q)).all()
    padded = np.array([apart.mean() for *_, apart in found_cells(on)])
    plain = np.array([apart.mean() for *_, apart in found_cells(checkers("panda")[0])])
    assert (padded < plain).all()


def test_carried_objects_are_in_no_cell():
    robot = pc.Robot.load("panda")
    scene = pc.Scene.load("bookshelf")
    scene.add("mug", pc.Cylinder(0.04, 0.1), robot.link_poses(robot.reference)[robot.link_index("panda_hand")])
    scene.attach("mug", "panda_hand")
    on, off = (pc.Checker(robot, scene, tuning=pc.Tuning(apart_cells=each)) for each in (True, False))
    carried = {k for k, body in enumerate(on.bodies) if body.carried is not None}
    pairs = on.pairs[~on.unreachable]
    assert carried
    assert cells_of(on)
    for each in cells_of(on):
        assert not carried & set(pairs[each.pairs[each.pairs >= 0]].ravel().tolist())
    q = robot.random_configurations(2000, seed=12)
    assert (on.check_states(q) == off.check_states(q)).all()


def test_solids():
    on, off = (
        pc.Checker(pc.Robot.load("xarm7", geometry="solid"), pc.Scene(), tuning=pc.Tuning(apart_cells=each))
        for each in (True, False)
    )
    assert cells_of(on)
    q = on.robot.random_configurations(2000, seed=13)
    assert (on.check_states(q) == off.check_states(q)).all()


def test_cells_come_from_the_cache_only_if_they_are_whole(tmp_path, monkeypatch):
    def fresh():
        robot = pc.Robot.load("panda")
        robot._parts.memory.__init__()
        return cells_of(pc.Checker(robot, pc.Scene()))

    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path))
    proved = []
    real = apart_cells.apart_in_cells
    monkeypatch.setattr(apart_cells, "apart_in_cells", lambda *args: proved.append(1) or real(*args))
    fresh()
    assert len(proved) == 8
    (path,) = tmp_path.glob("*.cells")
    fresh()
    assert len(proved) == 8
    content = path.read_bytes()
    for broken in (content[:-1], content[: len(content) // 2], b"", content[:-1] + bytes([content[-1] ^ 1])):
        path.write_bytes(broken)
        before = len(proved)
        fresh()
        assert len(proved) == before + 8
        assert path.read_bytes() == content
    cache.write_to_cache(path, b"\xff" * 10)  # whole, but of something else
    before = len(proved)
    fresh()
    assert len(proved) == before + 8
    monkeypatch.setenv("PLANNERCHECK_CACHE", "0")
    fresh()
    assert len(proved) == before + 16


@pytest.mark.parametrize(
    ("columns", "flags"), [([0, 1], np.zeros((0, 4), dtype=np.uint8)), ([0, 1], np.zeros((4, 2000), dtype=np.uint8))]
)
def test_tables_that_are_none(columns, flags):
    with pytest.raises(ValueError, match="1 to 1024 cells"):
        core.apart_cells(columns, [0.0, 0.0], [1.0, 1.0], flags)


def test_each_cell_file_is_of_one_robot(tmp_path, monkeypatch):
    """Robots that differ in a limit, a body's place or shape, or a padding."""
    urdf = """<robot name="r"><link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry>
      </collision></link>{links}</robot>"""
    link = """<link name="l{k}"><collision><origin xyz="{x} 0 0"/><geometry><box size="0.3 {width} 0.04"/></geometry>
      </collision></link><joint name="j{k}" type="revolute"><parent link="{parent}"/><child link="l{k}"/>
      <origin xyz="{x} 0 0"/><axis xyz="0 0 1"/><limit lower="-{limit}" upper="{limit}" velocity="1" effort="1"/>
      </joint>"""

    def robot(width=0.04, x=0.16, limit=3.0):
        links = "".join(
            link.format(k=k, parent=f"l{k - 1}" if k else "base", x=x if k else 0.05, limit=limit, width=width)
            for k in range(3)
        )
        path = tmp_path / "r.urdf"
        path.write_text(urdf.format(links=links))
        return pc.Robot.from_urdf(path)

    folder = tmp_path / "cache"
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(folder))
    monkeypatch.setattr(apart_cells, "_WORTH", 0.01)
    files = set()
    for padding, settings in [(0.0, {}), (0.01, {}), (0.0, {"x": 0.17}), (0.0, {"limit": 2.5}), (0.0, {"width": 0.05})]:
        made = robot(**settings)
        on, off = (
            pc.Checker(made, pc.Scene(), padding=padding, tuning=pc.Tuning(apart_cells=each)) for each in (True, False)
        )
        assert cells_of(on)
        q = made.random_configurations(4000, seed=14)
        assert (on.check_states(q) == off.check_states(q)).all()
        before, files = files, {path.name for path in folder.glob("*.cells")}
        assert len(files) > len(before), (padding, settings)


@pytest.mark.parametrize("count", [1, 6, 30])
def test_bodies_at_rest_are_in_no_cell(tmp_path, monkeypatch, count):
    """Found by an audit: the core has them as obstacles, whose numbers were taken for those of bodies that move."""
    monkeypatch.setattr(apart_cells, "_WORTH", 0.01)
    box = '<collision><origin xyz="{x:.2f} {y:.2f} 0"/><geometry><box size=".1 .1 .1"/></geometry></collision>'
    base = "".join(box.format(x=0.12 * (k % 3) - 0.1, y=0.12 * (k // 3) - 0.1 * (count // 6)) for k in range(count))
    limit = '<limit lower="-2.2" upper="2.2" effort="1" velocity="1"/>'
    (tmp_path / "r.urdf").write_text(
        f"""<robot name="r"><link name="b">{base}</link><link name="l1"/><link name="l2"><collision>
        <origin xyz="0 0 0.2"/><geometry><box size=".08 .08 .3"/></geometry></collision></link>
        <joint name="a" type="revolute"><parent link="b"/><child link="l1"/><origin xyz="0 0 0.25"/><axis xyz="1 0 0"/>
        {limit}</joint><joint name="c" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>{limit}
        </joint></robot>"""
    )
    robot = pc.Robot.from_urdf(tmp_path / "r.urdf")
    q = robot.random_configurations(3000, seed=15)
    expected = pc.Checker(robot, pc.Scene(), tuning=pc.Tuning(apart_cells=False)).check_states(q)
    for static_poses in (True, False):
        checker = pc.Checker(robot, pc.Scene(), tuning=pc.Tuning(static_poses=static_poses))
        assert not cells_of(checker)
        assert (checker.check_states(q) == expected).all()
        assert [checker.is_valid(row) for row in q[:500]] == expected[:500].tolist()


def test_cells_of_bodies_that_slide(tmp_path, monkeypatch):
    """Two boxes of 0.2 m, one of which slides by (x, y) against the other: they are apart where either exceeds 0.2."""
    monkeypatch.setattr(apart_cells, "_WORTH", 0.01)
    box = '<collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>'
    joint = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>
      <limit lower="-{limit}" upper="{limit}" velocity="1" effort="1"/></joint>"""
    joints = (
        joint.format(name="turn", kind="revolute", parent="base", child="first", axis="0 0 1", limit=2),
        joint.format(name="x", kind="prismatic", parent="first", child="between", axis="1 0 0", limit=0.7),
        joint.format(name="y", kind="prismatic", parent="between", child="last", axis="0 1 0", limit=0.9),
    )
    (tmp_path / "r.urdf").write_text(
        f'<robot name="r"><link name="base"/><link name="first">{box}</link><link name="between"/>'
        f'<link name="last">{box}</link>{"".join(joints)}</robot>'
    )
    checker = pc.Checker(pc.Robot.from_urdf(tmp_path / "r.urdf"), pc.Scene())
    ((_, cut, apart),) = found_cells(checker)
    assert cut == (1, 2)
    ways = [np.linspace(-limit, limit, len(apart) + 1) for limit in (0.7, 0.9)]
    nearest = [
        np.where(np.sign(way[1:]) != np.sign(way[:-1]), 0, np.minimum(*np.abs([way[1:], way[:-1]]))) for way in ways
    ]
    surely = (nearest[0] > 0.2)[:, None] | (nearest[1] > 0.2)[None]
    assert not (apart & ~surely).any()
    assert (apart & surely).sum() > 0.9 * surely.sum()


@pytest.mark.parametrize(("low", "has_cells"), [(-2.0, True), (1e7, False)])
def test_limits_far_from_zero_have_no_cells(tmp_path, monkeypatch, low, has_cells):
    """Found by an audit: middles of cells round by an ulp of the limits, which may be as wide as a cell."""
    monkeypatch.setattr(apart_cells, "_WORTH", 0.01)
    box = '<collision><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.05 0.05"/></geometry></collision>'
    links = "".join(f'<link name="l{k}">{box}</link>' for k in range(4))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="0.2 0 0"/>'
        f'<axis xyz="0 0 1"/><limit lower="{low}" upper="{low + 4}" velocity="1" effort="1"/></joint>'
        for k in range(3)
    )
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{links}{joints}</robot>')
    on, off = (
        pc.Checker(pc.Robot.from_urdf(tmp_path / "r.urdf"), pc.Scene(), tuning=pc.Tuning(apart_cells=e))
        for e in (True, False)
    )
    assert bool(cells_of(on)) == has_cells
    q = on.robot.random_configurations(2000, seed=16)
    assert (on.check_states(q) == off.check_states(q)).all()


def test_cells_of_the_cache_are_those_that_were_proved(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path))
    checker, _ = checkers("panda")
    found = list(found_cells(checker))
    chains, pairs = checker._proofs._reach._chains, [tuple(pair) for pair, *_ in found]
    for _ in range(2):  # written, then read
        cells = apart_cells._apart(chains, (5, 6), pairs, checker._preparation.polytope)
        assert (cells == np.array([apart for *_, apart in found])).all()
    assert len(list(tmp_path.glob("*.cells"))) == 1
