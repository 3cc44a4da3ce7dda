"""The compiled oracle of the stress runs, held against Python's integers and Fractions: its sums and products, its
verdicts, and that it refuses every certificate that is wrong."""

import itertools
import random
from fractions import Fraction

import numpy as np
import pytest

from plannercheck import _oracle
from plannercheck.bodies import exact_reference as exact
from plannercheck.common.core import core
from plannercheck.evaluation.campaign.tallies import EXCEPTION
from plannercheck.evaluation.stress import campaign as stress
from plannercheck.evaluation.stress import oracle as oracles
from plannercheck.evaluation.stress.oracle import Oracle
from plannercheck.evaluation.stress.random_cases import RELATIONS, ROTATIONS, Placement, draws


def posed(vertices, pose):
    """Posed vertices in Fractions."""
    matrix = [[Fraction(x) for x in row] for row in pose.tolist()]
    return [
        [sum((m * Fraction(x) for m, x in zip(row, v, strict=False)), row[3]) for row in matrix[:3]]
        for v in vertices.tolist()
    ]


def dot(a, b):
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def is_apart(question, direction):
    """From the definition."""
    p, pose_p, r, pose_r, inflation_radii = question
    least = min(dot(direction, x) for x in posed(p, pose_p))
    most = max(dot(direction, x) for x in posed(r, pose_r))
    inflation_radius = sum(map(Fraction, inflation_radii))
    return least > most and (least - most) ** 2 > inflation_radius**2 * dot(direction, direction)


def is_shared(question, first, second, weights):
    """From the definition."""
    p, pose_p, r, pose_r, inflation_radii = question
    if not weights or min(weights) < 0 or sum(weights) <= 0:
        return False
    on_p, on_r = posed(p[first], pose_p), posed(r[second], pose_r)
    apart = [sum(w * (a[k] - b[k]) for w, a, b in zip(weights, on_p, on_r, strict=True)) for k in range(3)]
    return dot(apart, apart) <= (sum(map(Fraction, inflation_radii)) * sum(weights)) ** 2


def compiled(question):
    p, pose_p, r, pose_r, inflation_radii = question
    return _oracle.Points(p, inflation_radii[0]), pose_p, _oracle.Points(r, inflation_radii[1]), pose_r


def digits(numbers):
    """Fractions whose denominators are powers of two, as the oracle takes them."""
    out = []
    for number in map(Fraction, numbers):
        power = number.denominator.bit_length() - 1
        assert number.denominator == 1 << power
        out.append((f"{number.numerator:x}", -power))
    return out


def questions(count, seed):
    """Pairs of bodies of few vertices, of all kinds of draws and both verdicts."""
    rng = np.random.default_rng(seed)
    while count > 0:
        relation = str(rng.choice(list(RELATIONS)))
        drawn = RELATIONS[relation](relation, Placement(str(rng.choice(ROTATIONS)), 1.0), rng)
        if len(drawn.p.vertices) + len(drawn.r.vertices) > 40:
            continue
        k = int(rng.integers(len(drawn.poses_p)))
        inflation_radii = drawn.p.inflation_radius, drawn.r.inflation_radius
        yield drawn.p.vertices, drawn.poses_p[k], drawn.r.vertices, drawn.poses_r[k], inflation_radii
        count -= 1


def test_whole_numbers_are_pythons():
    rng = random.Random(1)
    edges = [0, 1, -1, 2**64 - 1, -(2**64), 2**128 - 2**64, 2**200 - 1]
    numbers = edges + [
        rng.choice((1, -1)) * rng.getrandbits(rng.choice((1, 30, 64, 65, 127, 129, 700))) for _ in range(60)
    ]
    for a, b, c in itertools.chain(
        itertools.product(edges, repeat=3), (tuple(rng.choice(numbers) for _ in range(3)) for _ in range(5000))
    ):
        assert int(_oracle.multiplied_and_added(f"{a:x}", f"{b:x}", f"{c:x}"), 16) == a * b + c
    for wrong in ("", "-", "0x1", "g", "1 "):
        with pytest.raises(ValueError, match="hexadecimal"):
            _oracle.multiplied_and_added(wrong, "1", "1")


def test_verdicts_are_those_of_integers_and_proved():
    shared = 0
    for question in questions(300, 1):
        p, pose_p, r, pose_r, inflation_radii = question
        truth = exact.intersects(p, r, pose_p, pose_r, *inflation_radii)
        arguments = compiled(question)
        for every in (True, False):
            found = _oracle.decide(arguments[0], pose_p[None], arguments[2], pose_r[None], every)
            assert found.tolist() == [truth]
        direction, first, second, weights = _oracle.proof(*arguments)
        if truth:
            assert is_shared(question, first, second, [int(w, 16) for w in weights])
        else:
            # In units of the pair's, which are any power of two.
            assert is_apart(question, [Fraction(int(d, 16)) for d in direction])
        shared += truth
    assert 60 < shared < 240


def test_separations_hold_or_are_refused():
    """Directions that separate, ones that just don't, and any: always what the definition says."""
    rng = np.random.default_rng(2)
    verdicts = []
    for question in questions(150, 2):
        arguments = compiled(question)
        found = [int(d, 16) for d in _oracle.proof(*arguments)[0]]
        tried = [rng.normal(size=3).tolist(), [0.0, 0.0, 0.0]]
        if found:
            largest = max(map(abs, found))
            rounded = [float(Fraction(x, largest)) for x in found]
            tried += [rounded, [-x for x in rounded], [x * 2.0**-1000 for x in rounded]]
            tried += [[x + 0.5 ** int(rng.integers(1, 52)) * rng.normal() for x in rounded] for _ in range(4)]
            assert _oracle.separates(*arguments, digits(found), True)
        for direction in tried:
            expected = is_apart(question, [Fraction(x) for x in direction])
            for every in (True, False):
                assert _oracle.separates(*arguments, digits(direction), every) == expected
            verdicts.append(expected)
    assert len(verdicts) > 550
    assert 100 < sum(verdicts) < len(verdicts) - 100


def test_separations_within_the_inflation_radius_are_refused():
    """A ball and a corner whose distance is the radius, and one step of a double more."""
    ball, corner, eye = np.zeros((1, 3)), np.array([[3.0, 4.0, 0.0], [3.0, 4.0, 5.0], [9.0, 9.0, 0.0]]), np.eye(4)
    for radius, apart in ((5.0, False), (np.nextafter(5, 0), True), (np.nextafter(5, 9), False)):
        question = ball, eye, corner, eye, (radius, 0.0)
        assert is_apart(question, [Fraction(-3), Fraction(-4), Fraction(0)]) == apart
        assert _oracle.separates(*compiled(question), digits([-3, -4, 0]), True) == apart
        assert _oracle.shares(*compiled(question), [0], [0], digits([7])) == (not apart)


def test_mixtures_hold_or_are_refused():
    """Mixtures that meet, each with one weight or vertex changed, negative weights, and weights of sum 0."""
    rng = np.random.default_rng(3)
    verdicts = []
    for question in questions(180, 3):
        arguments = compiled(question)
        _, first, second, found = _oracle.proof(*arguments)
        weights = [int(w, 16) for w in found]
        tried = [([0], [0], [1]), ([0], [0], [0]), ([0], [0], [-1]), ([], [], [])]
        if weights:
            tried.append((first, second, weights))
            tried.append(([*first, 0, 0], [*second, 0, 0], [*weights, 1, -1]))
            tried.append(([*first, 0], [*second, 0], [*weights, 0]))
            tried.append((first, second, [-w for w in weights]))
            for _ in range(4):
                k, changed = int(rng.integers(len(weights))), list(weights)
                changed[k] += int(rng.choice((1, -1))) * (changed[k] >> int(rng.integers(1, 60)) or 1)
                tried.append((first, second, changed))
                other = list(first)
                other[k] = int(rng.integers(len(question[0])))
                tried.append((other, second, weights))
        for some, others, masses in tried:
            expected = is_shared(question, some, others, [Fraction(w) for w in masses])
            assert _oracle.shares(*arguments, some, others, digits(masses)) == expected
            verdicts.append(expected)
        assert not _oracle.shares(*arguments, [len(question[0])], [0], digits([1]))
        assert not _oracle.shares(*arguments, [0, 0], [0], digits([1]))
    assert len(verdicts) > 1100
    assert 180 < sum(verdicts) < len(verdicts) - 180


def test_what_is_no_question_is_refused():
    points, eye = _oracle.Points(np.zeros((1, 3)), 0.0), np.eye(4)
    for vertices, inflation_radius in (
        (np.zeros((0, 3)), 0.0),
        (np.full((1, 3), np.nan), 0.0),
        (np.zeros((1, 3)), -1.0),
    ):
        with pytest.raises(ValueError, match=r"finite|at least"):
            _oracle.Points(vertices, inflation_radius)
    with pytest.raises(ValueError, match="finite"):
        _oracle.separates(points, np.full((4, 4), np.inf), points, eye, digits([1, 0, 0]), True)
    with pytest.raises(ValueError, match="three"):
        _oracle.separates(points, eye, points, eye, digits([1, 0]), True)
    with pytest.raises(ValueError, match="as many"):
        _oracle.decide(points, eye[None].repeat(2, axis=0), points, eye[None], False)


def test_the_cores_certificates_are_proved_or_counted(monkeypatch):
    """A plane that the core does not have, and weights that are not its own, prove nothing."""
    drawn = next(d for d in draws(7) if len(d.p.vertices) > 4)
    oracle = Oracle(drawn)
    truth, _ = oracle.truth(thorough=True)
    assert [oracle.certified(k) for k in range(len(truth))] == truth
    told = core.certify_pair

    class Wrong:
        @staticmethod
        def certify_pair(*arguments):
            found = told(*arguments)
            if found["shared"]:
                found["exact_weights"] = [("-1", 0)] * len(found["exact_weights"])
            else:
                found["normal"] = -found["normal"]
                found.pop("exact_normal", None)
            return found

    monkeypatch.setattr(oracles, "core", Wrong)
    assert {oracle.certified(k) for k in range(len(truth))} == {None}
    assert stress.proved(oracle, 0) == EXCEPTION


def test_what_the_oracle_does_not_prove_integers_decide(monkeypatch):
    drawn = next(iter(draws(8)))
    expected, notes = Oracle(drawn).truth(thorough=True)
    assert set(notes) == {""}

    class Shy:
        Points = _oracle.Points

        @staticmethod
        def decide(*arguments):
            return np.full(len(expected), 2, dtype=np.uint8)

    monkeypatch.setattr(oracles, "compiled_oracle", lambda: Shy)
    assert Oracle(drawn).truth(thorough=False) == (expected, [oracles.BY_INTEGERS] * len(expected))
