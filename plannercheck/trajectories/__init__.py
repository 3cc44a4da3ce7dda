"""Trajectories as controllers run them."""

from plannercheck.trajectories.controllers import CONTROLLERS, Controller
from plannercheck.trajectories.limits import Excess
from plannercheck.trajectories.timing import Timing
from plannercheck.trajectories.trajectory import Trajectory

__all__ = ["CONTROLLERS", "Controller", "Excess", "Timing", "Trajectory"]
