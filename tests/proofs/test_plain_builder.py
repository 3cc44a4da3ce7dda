"""Proofs by a builder that shares nothing with plannercheck: honest ones are confirmed, and forged ones are not."""

import contextlib
import copy
import json

import numpy as np
import plain_builder
import pytest
from proof_cases import free_motions

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs import load_proofs


def documents(count, first=0):
    found = (plain_builder.document(seed) for seed in range(first, first + 50 * count))
    return [next(each for each in found if each is not None) for _ in range(count)]


def verified(document, folder):
    (folder / "x.json").write_text(json.dumps(document))
    (proof,) = load_proofs(folder / "x.json")
    return proof.verify()


def test_honest_proofs_of_another_builder_are_confirmed(tmp_path):
    kinds = set()
    for document in documents(40):
        found = verified(document, tmp_path)
        assert found, found.fault
        bodies = document["model"]["bodies"]
        kinds |= {(body.get("parts", ""), "triangles" in body) for body in bodies}
    assert kinds == {("", False), ("", True), ("balls", False), ("boxes", False)}


# ----- forgeries by hand, whose hashes fit


def first_of(document, by):
    """The first body of a kind."""
    return next((b for b in document["model"]["bodies"] if by in b or b.get("parts") == by), None)


def motion(document):
    return document["motions"][0]


def beyond(document):
    motion(document)["motion"]["end"][0] += 3.0
    motion(document)["motion"]["asked_end"][0] += 3.0


FORGED = {
    "another end": beyond,
    "an end that was not asked for": lambda d: motion(d)["motion"]["asked_end"].__setitem__(0, 0.123),
    "a larger margin": lambda d: motion(d).update(margin=3.0),
    "a margin below 0": lambda d: motion(d).update(margin=-1e-3),
    "a margin that is no number": lambda d: motion(d).update(margin=float("nan")),
    "no entries": lambda d: motion(d).update(entries=[]),
    "an entry less": lambda d: motion(d)["entries"].pop(len(motion(d)["entries"]) // 2),
    "the last part left out": lambda d: motion(d)["entries"].pop(),
    "a direction turned round": lambda d: motion(d)["entries"][0].update(
        direction=[-x for x in motion(d)["entries"][0]["direction"]]
    ),
    "a direction of no length": lambda d: motion(d)["entries"][0].update(direction=[0.0, 0.0, 0.0]),
    "a frame that there is not": lambda d: motion(d)["entries"][0].update(frame=99),
    "a range that there is not": lambda d: motion(d)["entries"][-1].update(first=[0, 10**6]),
    "balls of no size": lambda d: (
        [b.update(reach=1e-9) for b in d["model"]["bodies"]]
        + [motion(d).update(entries=[{"pair": k, "start": 0.0, "end": 1.0, "by": "balls"} for k in range(9)])]
    ),
    "an axis of twice the length": lambda d: d["model"]["joints"][0].update(
        axis=[2 * x for x in d["model"]["joints"][0]["axis"]]
    ),
    "a placement that shrinks": lambda d: d["model"]["bodies"][0].update(
        pose=(np.array(d["model"]["bodies"][0]["pose"]) * 0.5).tolist()
    ),
    "whole turns of an axis that is halved": lambda d: (
        d["model"].update(whole_turns=[0]),
        d["model"]["joints"][0].update(multipliers=[0.5]),
    ),
    "a pair of a body with itself": lambda d: d["model"]["pairs"].append([0, 0]),
    "a pair more, without entries": lambda d: d["model"]["pairs"].append([len(d["model"]["bodies"]) - 1, 0]),
    "radii below 0": lambda d: [b.update(radii=[-x for x in b["radii"]]) for b in d["model"]["bodies"] if "radii" in b],
    "an obstacle in the way": lambda d: d["model"]["bodies"][-1].update(radius=5.0),
    "a version that equals 1": lambda d: d.update(version=1.0),
    "a name of two lines": lambda d: d.update(scene="x\n  model: confirmed"),
    "a motion along another path": lambda d: motion(d)["motion"].update(path="shortest"),
    "a field more": lambda d: motion(d)["motion"].update(note="confirmed"),
}


@pytest.fixture(scope="module")
def mixed():
    """An honest proof with a cloud and a solid, with more than one pair."""
    for document in documents(60):
        if first_of(document, "balls") and first_of(document, "triangles") and len(document["model"]["pairs"]) > 1:
            return document
    raise AssertionError


def test_what_is_forged_below_is_sound(mixed, panda, tmp_path):
    assert verified(mixed, tmp_path)
    (tmp_path / "x.json").write_text(json.dumps(panda))
    assert load_proofs(tmp_path / "x.json")[0].verify("panda", "table")


@pytest.mark.parametrize("name", FORGED)
def test_forged_proofs_are_refused(mixed, name, tmp_path):
    document = copy.deepcopy(mixed)
    FORGED[name](document)
    document["hashes"] = plain_builder.hashes(document["model"])
    with contextlib.suppress(PlannercheckError):
        assert not verified(document, tmp_path)


def test_a_model_changed_without_its_hash_is_refused(mixed, tmp_path):
    document = copy.deepcopy(mixed)
    document["model"]["bodies"][0]["name"] = "other"
    assert "hashes" in verified(document, tmp_path).fault


# ----- forgeries beside files


@pytest.fixture(scope="module")
def panda(tmp_path_factory):
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("table"))
    q0, q1 = free_motions(checker, 1, 1)
    path = tmp_path_factory.mktemp("panda") / "x.json"
    checker.certify_motions(q0, q1)[0].save(path)
    return json.loads(path.read_text())


def body_named(document, name):
    return next(body for body in document["model"]["bodies"] if body["name"] == name)


def without_pair(document):
    document["model"]["pairs"].pop()
    count = len(document["model"]["pairs"])
    motion(document)["entries"] = [each for each in motion(document)["entries"] if each["pair"] < count]


def without_obstacles(document):
    document["model"]["pairs"] = []
    motion(document)["entries"] = []


def smaller(document, name):
    given = body_named(document, name)
    given["vertices"] = (np.array(given["vertices"]) * 0.99).tolist()


BESIDE_FILES = {
    "a smaller hand": lambda d: smaller(d, "panda_hand_0"),
    "a smaller table": lambda d: smaller(d, "table_top"),
    "a vertex less": lambda d: body_named(d, "panda_link5_0")["vertices"].pop(),
    "a finger held elsewhere by a column": lambda d: d["model"]["joints"][7].update(columns=[0]),
    "a joint that goes half as far": lambda d: d["model"]["joints"][6].update(multipliers=[0.5]),
    "a joint with an offset": lambda d: d["model"]["joints"][6].update(offsets=[1e-6]),
    "a table that stands aside": lambda d: body_named(d, "table_top").update(
        pose=[1.0, 0.0, 0.0, 5.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    ),
    "a pair less": without_pair,
    "no pairs": without_obstacles,
    "an obstacle less": lambda d: body_named(d, "table_top").update(name="other"),
}


@pytest.mark.parametrize("name", BESIDE_FILES)
def test_forged_models_are_refused_beside_their_files(panda, name, tmp_path):
    path = tmp_path / "x.json"
    document = copy.deepcopy(panda)
    BESIDE_FILES[name](document)
    document["hashes"] = plain_builder.hashes(document["model"])
    path.write_text(json.dumps(document))
    assert not load_proofs(path)[0].verify("panda", "table")


@pytest.mark.parametrize(
    "change",
    [
        lambda m: m.update(turning_radius=0.01),
        lambda m: m.update(turning_radius=3.0),
        lambda m: m.update(curve="dubins"),
        lambda m: m.update(curve="straight"),
        lambda m: m.update(pieces=m["pieces"][:-1]),
        lambda m: m["pieces"][0].update(slip=10.0),
    ],
)
def test_forged_curves_are_refused(change, tmp_path):
    scene = pc.planar.Scene.load("warehouse")
    checker = pc.planar.Checker(pc.planar.Robot.load("forklift"), scene)
    q = np.array(scene.start("forklift"))
    proof = checker.certify_motions(q[None], q[None] + [-0.3, 0.02, 0.05], curve="reeds_shepp", turning_radius=1.5)[0]
    proof.save(tmp_path / "x.json")
    document = json.loads((tmp_path / "x.json").read_text())
    assert verified(document, tmp_path)
    change(motion(document)["motion"])
    assert not verified(document, tmp_path)
