"""Robots in a given order: each waits for those before, and those after it stand in the meantime."""

import numpy as np
import pytest
from crossing_boxes import at, gantries, meet, way

import plannercheck as pc

A = way([-1, 0], [1, 0], times=[0, 2])
B = way([0, -1], [0, 1], times=[0, 2])
C = way([0.5, 1], [0.5, -1], times=[0.5, 2.5])  # meets a at 1.5 s, both without a delay


@pytest.fixture(name="checker", scope="module")
def _checker(tmp_path_factory) -> pc.Checker:
    return gantries(tmp_path_factory.mktemp("schedule"), ("a", "b", "c"))


def test_three_in_order(checker):
    found = pc.schedule(checker, [{"a": A}, {"b": B}, {"c": C}], resolution=1e-3)
    assert found.delays["a"] == 0.0
    assert found.delays["b"] == pytest.approx(0.4, abs=2e-2)
    assert found.delays["c"] == pytest.approx(0.4, abs=2e-2)
    assert found.verdict.free
    assert len(found.steps) == 2
    times = np.linspace(0, 5, 10_001)
    runs = {"a": A, "b": B, "c": C}
    assert not meet({name: at(run, times, found.delays[name]) for name, run in runs.items()}).any()
    for step, name in zip(found.steps, ("b", "c"), strict=True):
        assert found.delays[name] == step.delay
        assert step.loss < 0.02
    assert "b 0.4" in repr(found)
    assert "proved free" in repr(found)


def test_the_order_counts(checker):
    found = pc.schedule(checker, [{"b": B}, {"c": C}, {"a": A}], resolution=1e-3)
    assert found.delays["b"] == found.delays["c"] == 0.0
    assert found.delays["a"] > 0.3
    assert found.verdict.free


def test_two_that_wait_together_and_one_that_stands(checker):
    found = pc.schedule(checker, [{"a": A}, {"b": B, "c": [-0.5, 0.5]}])
    assert set(found.delays) == {"a", "b"}
    assert found.verdict.free
    alone = pc.schedule(checker, [{"a": A, "b": [0.0, 0.5], "c": [0.0, -0.5]}])
    assert alone.delays == {"a": 0.0}
    assert alone.steps == ()
    assert alone.verdict.free


def test_one_that_is_in_the_way_of_those_before(checker):
    """c stands in a's way until it starts, which it does after a."""
    blocking = way([0.5, 0], [0.5, 2])
    found = pc.schedule(checker, [{"a": A}, {"b": B}, {"c": blocking}], at_most=1.0)
    assert found.delays == {"a": 0.0, "b": None, "c": None}
    assert len(found.steps) == 1
    assert found.steps[0].refuted
    assert found.verdict is None
    assert "b never, c never; not free" in repr(found)
    assert "<svg" in found._repr_html_()


def test_the_picture(checker):
    picture = pc.schedule(checker, [{"a": A}, {"b": B}, {"c": C}], resolution=0.05)._repr_html_()
    assert picture.count("<text") == 3
    assert picture.count("#4477aa") == 3
    assert picture.count("#cc3311") >= 2


@pytest.mark.parametrize(
    ("order", "words"),
    [
        ({"a": A}, "an order is a list of trajectories by robot"),
        ([A], "an order is a list of trajectories by robot"),
        (None, "an order is a list of trajectories by robot"),
        ([{"a": A}, {"a": A, "b": B, "c": C}], "a can't have two places in the order"),
        ([{"a": A}, {"b": B}], "no trajectory of c"),
        ([], "no trajectory of a, b, c"),
        ([{"a": [0, 0], "b": [0, 1], "c": [1, 0]}], "no robot moves"),
    ],
)
def test_bad_input(checker, order, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        pc.schedule(checker, order)


def test_plans_in_time(checker):
    """OMPL's bindings have no planner for it."""
    pytest.importorskip("ompl")
    for options in ({"start_time": 0.0}, {"latest": 5.0}):
        with pytest.raises(pc.PlannercheckError, match=r"no such planner \(STRRTstar\).* pc\.least_delay"):
            pc.ompl.plan(checker, np.zeros(6), np.zeros(6), **options)
