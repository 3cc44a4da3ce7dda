"""Methods whose compiled twin is asked first: they are the functions that they stand for, in all but their time."""

import copy
import gc
import inspect
import pickle
import pydoc
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.common.compiled_first import compiled_first
from plannercheck.common.core import core


class Doubling:
    """Its twin answers to whole numbers."""

    __slots__ = ("__dict__", "__weakref__", "twin")

    def __init__(self, twin: object = None) -> None:
        self.twin = twin
        self.asked: list[object] = []

    @compiled_first("twin", 1, "a value")
    def doubled(self, number: float, times: int = 1) -> object:
        """Twice a number."""
        self.asked.append(number)
        return 2 * number * times


def answers_to_whole_numbers(number: object, value: str) -> object:
    assert value == "a value"
    return ("twin", number) if isinstance(number, int) else None


def test_the_twin_is_asked_first_and_the_function_for_what_it_does_not_know() -> None:
    doubling = Doubling(answers_to_whole_numbers)
    assert doubling.doubled(3) == ("twin", 3)
    assert doubling.asked == []
    assert doubling.doubled(1.5) == 3.0
    assert doubling.asked == [1.5]


def test_calls_of_another_form_are_the_functions() -> None:
    doubling = Doubling(answers_to_whole_numbers)
    assert doubling.doubled(number=3) == 6
    assert doubling.doubled(3, 2) == 12
    assert doubling.doubled(3, times=3) == 18
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'number'"):
        doubling.doubled()
    assert Doubling.doubled(doubling, 3) == ("twin", 3)


def test_without_a_twin_the_function_is_called() -> None:
    doubling = Doubling()
    assert doubling.doubled(3) == 6
    del doubling.twin
    assert doubling.doubled(3) == 6
    doubling.twin = answers_to_whole_numbers
    assert doubling.doubled(3) == ("twin", 3)


def test_the_twin_of_a_subclass_is_the_one_in_the_slot() -> None:
    class Other(Doubling):
        twin = staticmethod(answers_to_whole_numbers)  # hides the slot from all but the method

        def __init__(self) -> None:
            self.asked = []

    assert Other().doubled(3) == 6
    other = Other()
    Doubling.twin.__set__(other, answers_to_whole_numbers)
    assert other.doubled(3) == ("twin", 3)


def test_the_twin_must_be_in_a_slot() -> None:
    def declared(**attributes: object) -> type:
        return type("Loose", (), {"doubled": compiled_first("twin", 1)(lambda self, number: 2 * number), **attributes})

    # Before Python 3.12, the error is the cause of a RuntimeError.
    of_another_class = {"twin": Doubling.twin}
    for attributes in ({}, {"__slots__": ("other",)}, {"twin": None}, {"twin": property(id)}, of_another_class):
        with pytest.raises((TypeError, RuntimeError)) as raised:
            declared(**attributes)
        error = raised.value if isinstance(raised.value, TypeError) else raised.value.__cause__
        assert str(error).startswith("doubled of class Loose has its compiled twin in 'twin', which must be one of its")
    assert declared(__slots__=("twin",))().doubled(3) == 6


def test_what_is_no_object_of_the_class_has_no_twin() -> None:
    class Stranger:
        __slots__ = ("asked", "other", "twin")  # the same name at another place
        doubled = Doubling.doubled

        def __init__(self) -> None:
            self.asked = []
            self.twin = self.other = answers_to_whole_numbers

    assert Stranger().doubled(3) == 6
    assert Doubling.doubled(Stranger(), 3) == 6
    with pytest.raises(AttributeError, match="'str' object has no attribute 'asked'"):
        Doubling.doubled("anything", 3)
    assert Doubling(answers_to_whole_numbers).doubled(3) == ("twin", 3)  # its class is still the first one


def test_a_method_of_no_class_is_the_function() -> None:
    alone = compiled_first("twin", 1)(lambda self, number: 2 * number)
    assert alone(Doubling(answers_to_whole_numbers), 3) == 6


def test_errors_of_the_twin_are_raised() -> None:
    def failing(number: object, value: str) -> object:
        raise ZeroDivisionError("by the twin")

    with pytest.raises(ZeroDivisionError, match="by the twin"):
        Doubling(failing).doubled(3)


def test_a_twin_that_replaces_itself_lives_as_long_as_its_call() -> None:
    def replacing() -> object:
        def twin(number: object, value: str) -> object:
            doubling.twin = None
            gc.collect()
            return number, value

        return twin

    doubling = Doubling()
    doubling.twin = replacing()
    assert doubling.doubled(3) == (3, "a value")
    assert doubling.doubled(3) == 6


def test_what_asks_a_method_what_it_is_hears_of_the_function() -> None:
    method = Doubling.doubled
    assert (method.__name__, method.__doc__, method.__module__) == ("doubled", "Twice a number.", __name__)
    assert str(inspect.signature(Doubling().doubled)) == "(number: float, times: int = 1) -> object"
    assert inspect.isfunction(method)
    assert inspect.ismethod(Doubling().doubled)
    assert "Twice a number." in pydoc.render_doc(Doubling)
    assert method.__wrapped__(Doubling(answers_to_whole_numbers), 3) == 6
    assert repr(method) == repr(method.__wrapped__)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = method.nothing


def test_weak_references_to_methods() -> None:
    doubling = Doubling(answers_to_whole_numbers)
    weak = weakref.WeakMethod(doubling.doubled)
    assert weak()(3) == ("twin", 3)
    assert weakref.ref(Doubling.doubled)() is Doubling.doubled
    del doubling
    assert weak() is None


def test_pickles_go_by_name(checker: pc.Checker) -> None:
    assert pickle.loads(pickle.dumps(pc.Checker.is_valid)) is pc.Checker.is_valid
    is_valid = pickle.loads(pickle.dumps(checker.is_valid))
    q = checker.robot.random_configurations(50, seed=1)
    assert [is_valid(row) for row in q] == checker.check_states(q).tolist()


def test_subclasses_replace_and_extend_the_method(checker: pc.Checker) -> None:
    class Careful(pc.Checker):
        def is_valid(self, q: object) -> bool:
            asked.append(q)
            return super().is_valid(q)

    asked: list[object] = []
    other = copy.copy(checker)
    other.__class__ = Careful
    q = checker.robot.random_configurations(20, seed=2)
    assert [other.is_valid(row) for row in q] == [checker.is_valid(row) for row in q]
    assert len(asked) == len(q)


def test_objects_are_let_go_without_a_search_for_cycles() -> None:
    gc.disable()
    try:
        doubling = Doubling(answers_to_whole_numbers)
        doubling.doubled(3), doubling.doubled(1.5)
        bound, watched = doubling.doubled, weakref.ref(doubling)
        del doubling
        assert watched() is not None  # a bound method keeps its object
        del bound
        assert watched() is None
        checker = pc.Checker(pc.Robot.load("ur5"))
        checker.is_valid(np.zeros(6)), checker.check_motion(np.zeros(6), np.full(6, 0.01))
        watched = weakref.ref(checker)
        del checker
        assert watched() is None
    finally:
        gc.enable()


def test_a_class_with_such_a_method_can_be_collected() -> None:
    class Local:
        __slots__ = ("__weakref__", "twin")

        @compiled_first("twin", 1)
        def doubled(self, number: int) -> int:
            return 2 * number if isinstance(self, __class__) else 0  # the function refers to its class

    assert Local().doubled(2) == 4
    watched = weakref.ref(Local)
    del Local
    gc.collect()
    assert watched() is None


def test_wrong_arguments_are_refused() -> None:
    with pytest.raises(ValueError, match="at most 4 arguments"):
        compiled_first("twin", 4, "one too many")(len)
    with pytest.raises(ValueError, match="at most 4 arguments"):
        compiled_first("twin", -1)(len)
    with pytest.raises(TypeError):
        core.CompiledFirst(len, 3, 1, ())


def test_single_states_and_motions_against_the_plain_functions(checker: pc.Checker) -> None:
    q = checker.robot.random_configurations(400, seed=3)
    ends = q + 0.1
    valid = [checker.is_valid(row) for row in q]
    free = [checker.check_motion(*rows) for rows in zip(q, ends, strict=True)]
    assert 0.1 < np.mean(valid) < 0.9
    assert 0.1 < np.mean(free) < 0.9
    plain_state, plain_motion = pc.Checker.is_valid.__wrapped__, pc.Checker.check_motion.__wrapped__
    assert [plain_state(checker, row) for row in q] == valid == checker.check_states(q).tolist()
    assert [plain_motion(checker, *rows) for rows in zip(q, ends, strict=True)] == free
    with ThreadPoolExecutor(4) as threads:
        assert list(threads.map(checker.is_valid, q)) == valid


def test_attached_and_changed_scenes_have_twins_of_their_own(checker: pc.Checker) -> None:
    q = checker.robot.random_configurations(200, seed=4)
    before = [checker.is_valid(row) for row in q]
    empty = checker.with_scene(None)
    assert [empty.is_valid(row) for row in q] == empty.check_states(q).tolist() != before
    assert [checker.is_valid(row) for row in q] == before
    assert [copy.copy(empty).is_valid(row) for row in q] == empty.check_states(q).tolist()


def test_copies_and_pickles_have_twins(checker: pc.Checker) -> None:
    q = checker.robot.random_configurations(2, seed=5)
    checker.check_motion(*q)
    twin = copy.copy(checker)
    assert twin._judge_row is checker._judge_row
    assert twin._judge_motion is checker._judge_motion is not None
    read = pickle.loads(pickle.dumps(checker))
    assert read._judge_row(q[0]) is checker.is_valid(q[0])
    assert read._judge_motion is None  # made when first needed
    assert read.check_motion(*q) is checker.check_motion(*q)
