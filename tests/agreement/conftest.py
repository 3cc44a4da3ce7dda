"""Sizes of the agreement runs, and their tables at the end of the session."""

import os

import pytest

REPORTS = pytest.StashKey[list[str]]()

# Short runs keep CI quick; `pytest -m agreement` runs long ones.
SHORT = {"PLANNERCHECK_PAIRS": 4_000, "PLANNERCHECK_STATES": 500}
LONG = {"PLANNERCHECK_PAIRS": 1_000_000, "PLANNERCHECK_STATES": 100_000}


def pytest_configure(config: pytest.Config) -> None:
    config.stash[REPORTS] = []


def wanted(config: pytest.Config, variable: str) -> int:
    """How much to run: what the environment says, or short or long by the markers asked for."""
    sizes = LONG if config.getoption("-m") == "agreement" else SHORT
    return int(os.environ.get(variable, sizes[variable]))


@pytest.fixture(scope="session")
def pairs_wanted(pytestconfig: pytest.Config) -> int:
    return wanted(pytestconfig, "PLANNERCHECK_PAIRS")


@pytest.fixture(scope="session")
def states_wanted(pytestconfig: pytest.Config) -> int:
    return wanted(pytestconfig, "PLANNERCHECK_STATES")


@pytest.fixture(scope="session")
def reports(pytestconfig: pytest.Config) -> list[str]:
    """Lines to be shown when all tests have run."""
    return pytestconfig.stash[REPORTS]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    if config.stash[REPORTS]:
        terminalreporter.section("agreement with FCL")
        for line in config.stash[REPORTS]:
            terminalreporter.write_line(line)
