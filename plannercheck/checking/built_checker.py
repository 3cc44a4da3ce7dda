"""How a checker is built, and how it changes: for another scene, other bodies, another group of joints.

In: a `Robot`, a `Scene`, settings. Out: `BuiltChecker`, immutable, with its bodies, pairs and compiled tables. Building
one places the scene's objects, lists and pads bodies and pairs, proves pairs apart that never meet, and compiles the
others. A changed checker takes over what still holds. What a checker answers is in state_checker.py.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar, Literal, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.circumscribed import checked_excess
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import DEFAULT_EXCESS, GeometryObject
from plannercheck.bodies.tuning import DEFAULT_TUNING, Tuning, core_tuning
from plannercheck.checking.compiled_pairs import PairSource
from plannercheck.checking.compiled_tables import CompiledTables
from plannercheck.checking.padding import Padding
from plannercheck.checking.pair_proofs import MeetingProofs
from plannercheck.checking.pair_table import Acm, warn_of_unknown_names
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.checking.scene_clock import MovingScene, NeedsTimes, SceneClock
from plannercheck.checking.scene_placement import place_objects
from plannercheck.checking.settings import Settings, without_attached
from plannercheck.checking.touching_pairs import warn_of_touching
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import read_only
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.progress import reported
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

Same = TypeVar("Same", bound="BuiltChecker")


class BuiltChecker:
    """The bodies and pairs of one robot in one scene, prepared and compiled.

    Attributes:
        robot: The robot.
        scene: The scene as it was when the checker was built, with all objects placed.
        bodies: The robot's collision bodies, then the scene's (or their stand-ins); then copies for pairs with a
            padding of their own.
        pairs: (k, 2) indices into `bodies`: the pairs that are tested at every configuration.
        unreachable: (k,) which pairs provably can't collide at any configuration within the limits; they are tested
            only beyond the limits, and where all pairs are asked for.
        static: (k,) which of the pairs no joint of the group moves relative to each other.
        excess: How far polytopes of cylinders and cones stick out, as a part of the radius.
        paddings: (bodies,) each body's part of the padding, m; `polytopes` are inflated by it.
    """

    robot: Robot
    scene: Scene
    bodies: tuple[GeometryObject, ...]
    pairs: Ints
    unreachable: Bools
    static: Bools
    _labels: tuple[str, ...]
    _preparation: Preparation
    _proofs: MeetingProofs
    _moving: MovingScene[Any] | None = None  # set where something in the scene moves
    _judge_row: Any  # the compiled judge of one configuration, in a slot

    # Attributes with compiled objects or a lock, which can't be pickled; they are made again.
    _COMPILED: ClassVar[frozenset[str]] = frozenset({"_tables", "_set_validity", "_proofs"})

    def __init__(
        self,
        robot: Robot,
        scene: Scene | None = None,
        *,
        self_collision: bool = True,
        acm: Acm | None = None,
        padding: Padding = 0.0,
        excess: float = DEFAULT_EXCESS,
        kinematics: Literal["batch", "pinocchio"] = "batch",
        tuning: Tuning = DEFAULT_TUNING,
    ) -> None:
        """Prepares all bodies (through the disk cache) and the pair table.

        Args:
            robot: The robot.
            scene: The scene; None is empty.
            self_collision: Whether the robot's self pairs are tested.
            acm: Whose allowed collisions act on self pairs: None or "robot" (SRDF or YAML), or "scene" as well.
            padding: The distance of every pair, m: a configuration is valid if and only if all distances exceed it. Or
                a mapping: the name of a body, link or obstacle to its part (a pair keeps the sum of its two parts), and
                a pair of names to the whole distance: `{"panda_hand": 0.01, ("panda_hand", "shelf"): 0.002}`.
            excess: How far polytopes of curved shapes may stick out, as a part of the radius.
            kinematics: "batch", the compiled kernel, or "pinocchio".
            tuning: What saves work; verdicts do not depend on it.

        Raises:
            PlannercheckError: If an argument has none of the values above.
        """
        if kinematics not in ("batch", "pinocchio"):
            raise PlannercheckError(f"kinematics must be 'batch' or 'pinocchio', not {kinematics!r}")
        if not isinstance(robot, Robot) or not isinstance(scene, Scene | None):
            raise PlannercheckError(
                "Checker takes a Robot and a Scene: Checker(Robot.load('panda'), Scene.load('bookshelf')), "
                f"not {type(robot).__name__} and {type(scene).__name__}"
            )
        if not isinstance(tuning, Tuning):
            raise PlannercheckError(f"tuning must be a Tuning, e.g. pc.Tuning(learning=False), not {tuning!r}")
        if not isinstance(self_collision, bool | np.bool_):
            raise PlannercheckError(f"self_collision must be True or False, not {self_collision!r:.80}")
        self.excess = checked_excess(excess)
        alone = without_attached(robot, () if scene is None else scene.attached)
        self._settings = Settings(
            alone, self_collision, padding, "robot" if acm is None else acm, kinematics, None, tuning
        )
        with reported(f"preparing robot {robot.name}"):
            self._prepare(scene if scene is not None else Scene("empty"), None)

    def _prepare(self, scene: Scene, earlier: BuiltChecker | None, is_same_robot: bool = True) -> None:
        """Builds everything that depends on the scene; takes over what an earlier checker has, where it still holds.

        `is_same_robot`: the earlier checker's robot moves by the same configurations.
        """
        is_same_robot = is_same_robot and (earlier is None or earlier._moving is None)
        settings, same = self._settings, earlier if is_same_robot else None
        self.scene = scene.copy()
        place_objects(settings.robot, self.scene)
        self.robot = settings.carrier(self.scene.attached, None if same is None else same.robot)
        self._kernel = self.robot.kinematics if settings.kinematics == "batch" else None
        moved, self._moving = self._moving, None
        if self.scene.moving and not settings.on_clock:
            self._prepare_moving(earlier, moved)
            return
        if earlier is None:
            warn_of_unknown_names(self.robot, self.scene)
        padded = settings.padded(self.robot, self.scene, is_first=earlier is None)
        self.bodies, self._labels, paddings, (pairs, at_rest) = padded
        self.paddings, self.pairs = read_only(paddings), read_only(pairs)
        known = None if earlier is None else earlier._preparation
        self._preparation = Preparation(self.bodies, self.excess, self.paddings, known)
        at_rest = self._prove(at_rest, same)
        self._compile()
        self._scene_taken()
        carried = np.array([body.carried is not None for body in self.bodies], dtype=bool)
        never_moving = self.pairs[self.static & ~self.unreachable & carried[self.pairs].any(axis=1)]
        warned = set() if earlier is None else set(earlier.bodies)
        warn_of_touching(self._pair_source(), self._labels, at_rest, never_moving, self._link_poses, warned)

    def _prepare_moving(self, earlier: BuiltChecker | None, known: MovingScene[Any] | None) -> None:
        """Builds the checker of the robot that carries what moves, to which all questions go."""
        robot, moving = self._settings.robot, self.scene.moving
        is_same = known is not None and known.clock.fits(robot, moving)
        clock = known.clock if known is not None and is_same else SceneClock(robot, moving)
        inner = type(self).__new__(type(self))
        inner.__dict__.update(self.__dict__)
        inner._settings = replace(self._settings, robot=clock.robot, on_clock=True)
        inner._prepare(self.scene, earlier if known is None else known.checker, is_same)
        self._moving = MovingScene(clock, inner)
        self.bodies, self._labels, self.paddings, self.pairs = inner.bodies, inner._labels, inner.paddings, inner.pairs
        self.unreachable, self.static, self._preparation = inner.unreachable, inner.static, inner._preparation
        self._compile()
        self._scene_taken()

    @property
    def with_all_columns(self: Same) -> Same:
        """The checker whose configurations have the columns of what moves as well; this one where nothing does."""
        return self if self._moving is None else self._moving.checker

    @property
    def clock(self) -> SceneClock | None:
        """The scene's clock; None where nothing moves."""
        return None if self._moving is None else self._moving.clock

    def in_time(self: Same, q: Floats, times: ArrayLike | None) -> tuple[Same, Floats]:
        """The checker of configurations (n, nq) at times, (n,) or a number, s, and its rows: `with_all_columns`'s."""
        if self._moving is None:
            return self, q
        if times is None:
            raise self._moving.clock.missing()
        return self._moving.checker, self._moving.clock.rows(self.robot.check_configurations(q), times)

    def _prove(self, at_rest: Ints, earlier: BuiltChecker | None) -> Ints:
        """Proves pairs apart where it can; returns the pairs (m, 2) fixed to the world that are not proved apart."""
        self._proofs = self._meeting_proofs(None if earlier is None else earlier._proofs)
        candidates, count = np.concatenate([self.pairs, at_rest]), len(self.pairs)
        is_wanted = self._settings.tuning.reach
        apart, static = self._proofs.of(candidates) if is_wanted else np.zeros((2, len(candidates)), dtype=bool)
        self.unreachable, self.static = read_only(apart[:count]), read_only(static[:count])
        return at_rest[~apart[count:]]

    def _scene_taken(self) -> None:
        """A hook: a subclass renews here what depends on the scene."""

    def _meeting_proofs(self, earlier: MeetingProofs | None) -> MeetingProofs:
        return MeetingProofs(self.robot, self.bodies, self._preparation, self._kernel is not None, earlier)

    def _compile(self) -> None:
        if self._moving is not None:
            self._tables = cast(CompiledTables, NeedsTimes(self._moving.clock))
            self._judge_row, self._set_validity = self._tables.judges(self._kernel)
            return
        is_wanted = self._settings.tuning.apart_cells
        in_cells = self._proofs.in_cells(self.pairs[~self.unreachable]) if is_wanted else ()
        self._tables = CompiledTables(self._pair_source(), self.pairs, self.unreachable, in_cells)
        self._judge_row, self._set_validity = self._tables.judges(self._kernel)

    def _pair_source(self) -> PairSource:
        tuning = self._settings.tuning
        kernel = self._kernel if tuning.static_poses else None
        return PairSource(self.robot, self.bodies, self._preparation, core_tuning(tuning), kernel)

    def __getstate__(self) -> dict[str, Any]:
        """The state for a pickle: prepared bodies and tables, but nothing compiled."""
        return {name: value for name, value in self.__dict__.items() if name not in self._COMPILED} | {
            "_kernel": self._kernel is not None
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._kernel = self.robot.kinematics if state["_kernel"] else None
        if self._moving is None:
            self._proofs = self._meeting_proofs(None)
        self._compile()

    def __copy__(self: Same) -> Same:
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)  # copies within a process share what is compiled
        other._judge_row = self._judge_row
        return other

    def with_scene(self: Same, scene: Scene | None) -> Same:
        """The same checker for another scene, e.g. this one's, in which something was moved, added or attached.

        Whatever both scenes share is not prepared again: bodies of the same shape, pairs whose bodies are where they
        were, and everything of the robot.

        Args:
            scene: The scene; None is empty.

        Returns:
            A checker with the settings of this one.

        Raises:
            PlannercheckError: If this checker was built with stand-ins for its bodies.
        """
        if not isinstance(scene, Scene | None):
            raise PlannercheckError(f"with_scene takes a Scene, not {type(scene).__name__}")
        if self._settings.bodies is not None:
            raise PlannercheckError("a checker with stand-ins for its bodies can't take another scene: build a new one")
        other = copy.copy(self)
        other._prepare(scene if scene is not None else Scene("empty"), self)
        return other

    def with_bodies(self: Same, bodies: Sequence[GeometryObject]) -> Same:
        """The same checker with stand-ins, e.g. coarser ones, for the robot's bodies and then the scene's.

        Args:
            bodies: One for each body, on the same link, in their order; the pairs stay as they are. Copies of bodies
                for pairs with a padding of their own may be left out.

        Returns:
            A checker with the settings of this one, which takes no other scene.

        Raises:
            PlannercheckError: If the bodies are not as many, or on other links.
        """
        other = copy.copy(self)
        other._settings = replace(self._settings, bodies=tuple(bodies))
        other._prepare(self.scene, None)
        return other

    def with_group(self: Same, joints: Sequence[str], name: str = "group") -> Same:
        """The same checker for another planning group of its robot; arguments as for `Robot.with_group`."""
        other = copy.copy(self)
        other._settings = replace(self._settings, robot=self._settings.robot.with_group(joints, name))
        other._prepare(self.scene, self, is_same_robot=False)
        return other

    @property
    def polytopes(self) -> tuple[Polytope | None, ...]:
        """The prepared body of each of `bodies`; None where no pair needs it."""
        _ = self.with_all_columns._tables.all
        return self._preparation.prepared_bodies()

    @property
    def prepared(self) -> tuple[Polytope | None, ...]:
        """Like `polytopes`, with None for bodies that have not been needed so far: those of unreachable pairs."""
        return self._preparation.prepared_bodies()

    def _link_poses(self, rows: Floats) -> Floats:
        poses = self.robot.pinocchio_link_poses(rows) if self._kernel is None else self.robot.link_poses(rows)
        return np.ascontiguousarray(poses)
