"""Ctrl-C ends a command even where Python drops the exception, and says nothing of that."""

import os
import signal
import time
import weakref

import pytest

from plannercheck.cli.ending_signals import ended_by_signals


class Thing:
    """What weak references refer to."""


@pytest.fixture
def said(monkeypatch):
    """What Python says of exceptions that it drops."""
    dropped = []
    monkeypatch.setattr("sys.unraisablehook", dropped.append)
    return dropped


def interrupted(kind):
    """Raises where Python drops exceptions: in a weak reference's callback."""

    def callback(reference):
        if kind is KeyboardInterrupt:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.05)  # it comes before this ends
        else:
            raise kind

    thing = Thing()
    reference = weakref.ref(thing, callback)
    del thing
    return reference


def go_on_after_an_interruption():
    interrupted(KeyboardInterrupt)
    time.sleep(5)


def test_an_interruption_that_is_dropped_comes_again_and_is_not_said(said):
    """Found by a run of all tests: the trace of one in a callback stood before the line that a command ends with."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), ended_by_signals():
            go_on_after_an_interruption()
    finally:
        signal.signal(signal.SIGINT, before)
    assert said == []


def test_what_else_is_dropped_is_said(said):
    with ended_by_signals():
        interrupted(ValueError)
    assert [dropped.exc_type for dropped in said] == [ValueError]
    interrupted(ValueError)
    assert len(said) == 2
