"""A misspelt command, option or value: the error says which it may have been meant to be."""

import pytest

from plannercheck.cli.main import main


@pytest.mark.parametrize(
    ("arguments", "suggested"),
    [
        (["valdate"], "did you mean validate?"),
        (["stess"], "did you mean stress?"),
        (["validate", "q.npy", "--robot", "panda", "--sceen", "bookshelf"], "did you mean --scene or --scheduler?"),
        (["inspect", "--robt=panda"], "did you mean --robot"),
        (["inspect", "--robot", "panda", "--no-self-colision"], "did you mean --no-self-collision?"),
        (["plan", "--robot", "panda", "--plannner=RRT"], "did you mean --planner?"),
        (["bench", "stats"], "did you mean states?"),
        (["validate", "--robot", "panda", "q.npy", "--engine", "dsk"], "did you mean dask?"),
        (["--versoin", "robots"], "did you mean --version?"),
    ],
)
def test_what_is_misspelt_is_suggested(capsys, arguments, suggested):
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert suggested in printed.err
    assert "Traceback" not in printed.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["validate", "--robot", "panda", "q.npy", "--xyzzy"], "unrecognized arguments: --xyzzy\n"),
        (["demo", "extra"], "unrecognized arguments: extra\n"),
        (["view"], "the following arguments are required"),
    ],
)
def test_nothing_is_made_up_where_nothing_is_close(capsys, arguments, message):
    assert main(arguments) == 2
    printed = capsys.readouterr().err
    assert message in printed
    assert "did you mean" not in printed
