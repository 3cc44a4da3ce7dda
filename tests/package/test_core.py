"""The compiled core: every instruction set that this processor runs gives the same bits."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import plannercheck as pc
from plannercheck.common import core as core_module
from plannercheck.common.core import LEVELS, available_levels, core

# Digests of prepared bodies, verdicts, stages, poses and motions, at one level.
PROBE = """
import hashlib, json, sys
sys.path.insert(0, {tests!r})
import numpy as np
from plannercheck.evaluation.stress import body_families as families, contact_poses as contacts
import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.bodies.tuning import METHODS, pair_options

out = {{"level": core.level}}
digest = lambda data: hashlib.sha256(bytes(data)).hexdigest()
bodies = {{}}
for name in sorted(families.FAMILIES):
    for n in (12, 300):
        for scale in (1.0, 1e-9):
            bodies[name, n, scale] = body = pc.Polytope(families.family(name, n, 1) * scale)
            out[f"hull {{name}} {{n}} {{scale}}"] = digest(body.core.serialise())
mesh = pc.Polytope(families.mesh_points(families.MESHES[0]))
out["mesh"] = digest(mesh.core.serialise())
directions = np.random.default_rng(1).normal(size=(500, 3))
out["extremes"] = digest(b"".join(np.asarray(mesh.core.extremes(directions, k)[0]).tobytes() for k in (False, True)))
gaps = np.repeat([1e-2, 1e-9, 1e-14, 1e-16, 0, -1e-15, -1e-3], 6)
for first, second in (("round", "box"), ("flat", "prism"), ("lattice", "cone")):
    P, R = bodies[first, 300, 1.0], bodies[second, 300, 1.0]
    p, r = (contacts.Solid("", b.vertices, b.faces.astype(np.int64)) for b in (P, R))
    poses = contacts.contact_poses(p, r, gaps, np.random.default_rng(2))
    for method in METHODS:
        shared, stages, _ = core.intersect_batch(P.core, poses[0], R.core, poses[1], pair_options(method))
        out[f"pairs {{first}} {{second}} {{method}}"] = digest(shared.tobytes() + stages.tobytes())
for name, scene in (("panda", "bookshelf"), ("ur5", "kitchen")):
    robot, scene = pc.Robot.load(name), pc.Scene.load(scene)
    checker, q = pc.Checker(robot, scene), scene.samples(name)
    out[f"poses {{name}}"] = digest(robot.link_poses(q).tobytes())
    out[f"verdicts {{name}}"] = digest(checker.first_colliding_pair(q).tobytes())
    certified = checker.check_motions(q[:200], q[200:400])
    out[f"certified {{name}}"] = digest(certified.tobytes())
    out[f"motions {{name}}"] = digest(checker.check_motions(q[:20], q[20:40], 0.05).tobytes())
print(json.dumps(out))
"""


def probe(level):
    code = PROBE.format(tests=str(Path(__file__).parents[1] / "support"))
    environment = os.environ | {"PLANNERCHECK_LEVEL": level, "PLANNERCHECK_CACHE": "0"}
    ran = subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True)
    return json.loads(ran.stdout)


def test_every_level_gives_the_same_bits():
    levels = available_levels()
    if len(levels) < 2:
        pytest.skip(f"only {levels} is built and runs here")
    first, *others = (probe(level) for level in levels)
    assert first.pop("level") == levels[0]
    for level, other in zip(levels[1:], others, strict=True):
        assert other.pop("level") == level
        assert {key for key in first if first[key] != other[key]} == set()


def test_the_best_level_is_loaded(monkeypatch):
    monkeypatch.delenv("PLANNERCHECK_LEVEL", raising=False)
    assert core_module.load().level == available_levels()[0]
    assert core.lanes == {"v4": 8, "v3": 4}.get(core.level, 2)


def test_the_module_calls_its_level_of_the_library_beside_it():
    maps, module = Path("/proc/self/maps"), Path(core.__file__)
    if not maps.exists():
        pytest.skip("not Linux; on macOS, the module has the code itself")
    assert str(module.with_name("libplannercheck.so")) in maps.read_text()
    called = re.findall(rb"_ZN?K?\w*12plannercheck\w*\.(\w+)\0", module.read_bytes())
    assert len(called) > 100
    assert set(called) == {core.level.encode()}


def test_levels_that_are_not_there_are_named(monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_LEVEL", "v9")
    with pytest.raises(pc.PlannercheckError, match=r"PLANNERCHECK_LEVEL='v9'.*" + available_levels()[0]):
        core_module.load()


def test_a_level_needs_all_its_features(monkeypatch):
    monkeypatch.setattr(core_module, "_processor_flags", lambda: frozenset({"avx2", "fma"}))
    assert set(available_levels()) <= {"v2", "plain"}
    assert all(level in LEVELS for level in available_levels())


def test_a_missing_core_says_so(monkeypatch):
    monkeypatch.delenv("PLANNERCHECK_LEVEL", raising=False)
    monkeypatch.setattr(core_module, "available_levels", list)
    with pytest.raises(ImportError, match="compiled core is missing"):
        core_module.load()
