"""Validity of configurations: a robot in a scene, every pair decided by the hierarchy test.

In: a `Robot`, a `Scene`. Out: an immutable `StateChecker` whose verdicts are exact for the hulls at the poses that
forward kinematics computes in doubles. All are thin wrappers of one batch call in the core (cpp/checking/checker).
"""

from __future__ import annotations

import copy
import threading
import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any, ClassVar, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.intersection import Method, certify_posed, pair_options
from plannercheck.bodies.objects import Parts
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import DEFAULT_EXCESS, Body
from plannercheck.checking.compiled_pairs import CompiledPairs, Preparation, added
from plannercheck.checking.padding import Padding, padded_pairs
from plannercheck.checking.pair_proofs import MeetingProofs
from plannercheck.checking.pair_table import Acm, pair_table
from plannercheck.checking.scene_placement import place_objects
from plannercheck.checking.settings import COUNTED, UNCOUNTED, Settings, known_parts, stand_ins, without
from plannercheck.checking.verdicts import PairVerdict, Verdict
from plannercheck.common.arrays import read_only
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.threads import checked_threads
from plannercheck.robots.anchored_objects import inverse
from plannercheck.robots.kinematic_error import largest_distance
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int32]
Same = TypeVar("Same", bound="StateChecker")


# Steps of the descent that a lower bound of a distance takes.
_BOUND_ROUNDS = 2


class StateChecker:
    """Exact verdicts of configurations of one robot in one scene; `Checker` adds motions.

    Attributes:
        robot: The robot.
        scene: The scene, as it was when the checker was built; all its objects have their places.
        bodies: The robot's collision bodies, then the scene's, or what stands in for them; then copies for pairs with
            a padding of their own.
        pairs: (k, 2) indices into `bodies`: what is tested at every configuration.
        unreachable: (k,) which of the pairs can't collide at any configuration within the limits, by proof; they are
            tested only beyond the limits, and where all pairs are asked for.
        resting: (k,) which of the pairs no joint of the group moves relative to each other.
        excess: How far polytopes of cylinders and cones stick out, as a part of the radius.
        paddings: (bodies,) each body's part of the padding, m; `polytopes` are swollen by it.
    """

    _preparation: Preparation
    _proofs: MeetingProofs

    # Attributes that hold compiled objects or a lock, which a pickle can't have; they are made anew.
    _COMPILED: ClassVar[frozenset[str]] = frozenset({"_live", "_judge_row", "_whole", "_lock", "_proofs"})

    def __init__(
        self,
        robot: Robot,
        scene: Scene | None = None,
        self_collision: bool = True,
        padding: Padding = 0.0,
        *,
        acm: Acm = "robot",
        kinematics: Literal["batch", "pinocchio"] = "batch",
        excess: float = DEFAULT_EXCESS,
        bodies: Sequence[Body] | None = None,
        method: Method = "oracle",
        cached_plane: bool = True,
        centre_axis: bool = True,
        turned_axis: bool = True,
        facet_plane: bool = True,
        nearest_points: bool = True,
        bounds: bool = True,
        boxes: bool = True,
        overlaps: bool = True,
        learning: bool = True,
        reach: bool = True,
        static_poses: bool = True,
    ) -> None:
        """Prepares all bodies (through the disk cache) and the pair table.

        Args:
            robot: The robot.
            scene: The scene; None is empty.
            self_collision: Whether the robot's self pairs are tested.
            padding: What every pair has to keep apart, m: a configuration is valid if and only if all distances exceed
                it. Or by name of body, link or obstacle parts of it, of which a pair keeps the sum of its two, and by
                pair of names the whole distance: `{"panda_hand": 0.01, ("panda_hand", "shelf"): 0.002}`.
            acm: Whose allowed collisions act on self pairs: "robot" (SRDF or YAML) or "scene" as well.
            kinematics: "batch", the compiled kernel, or "pinocchio".
            excess: How far polytopes of curved shapes may stick out, as a part of the radius.
            bodies: Stand-ins for the robot's bodies and then the scene's, in their order, e.g. coarser ones; the pairs
                stay as they are.
            method: The solver of the pair test, see `pair.pair_options`. Verdicts do not depend on it.
            cached_plane: Whether the last separating plane of a pair is tried first, also that of an earlier motion.
            centre_axis: Whether the axis between the centres, and swells around them, are tried before the solver.
            turned_axis: Whether that axis is turned to where the bodies would face each other if they were ellipsoids.
            facet_plane: Whether the facets' planes of two bodies of eight corners at most are tried before the solver.
            nearest_points: Whether nearest points in doubles are tried before exact arithmetic.
            bounds: Whether bounding balls and a tree of the obstacles settle pairs that are far apart.
            boxes: Whether planes along the faces of the bodies' boxes do.
            overlaps: Whether balls inside one body that meet a box inside the other settle pairs where any collision
                will do.
            learning: Whether the pair that collided most often comes first where any collision will do.
            reach: Whether pairs that can't meet within the limits are left out there.
            static_poses: Whether links that no joint of the group moves are posed once, as obstacles are.

        Raises:
            PlannercheckError: If an argument is none of those above.
        """
        if kinematics not in ("batch", "pinocchio"):
            raise PlannercheckError(f"kinematics must be 'batch' or 'pinocchio', not {kinematics!r}")
        if not isinstance(robot, Robot) or not isinstance(scene, Scene | None):
            raise PlannercheckError(
                "Checker takes a Robot and a Scene: Checker(Robot.load('panda'), Scene.load('bookshelf')), "
                f"not {type(robot).__name__} and {type(scene).__name__}"
            )
        self.excess = excess
        alone = without(robot, () if scene is None else scene.attached)
        self._settings = Settings(alone, self_collision, padding, acm, kinematics, bodies, reach, static_poses)
        self._options = (
            (method, cached_plane, centre_axis, turned_axis, facet_plane, nearest_points),
            (bounds, boxes, overlaps, learning),
        )
        self._prepare(scene if scene is not None else Scene("empty"), None)

    def _prepare(self, scene: Scene, earlier: StateChecker | None) -> None:
        """Builds all that depends on the scene, from what another checker of the same settings has where it holds."""
        settings = self._settings
        self.scene = scene.copy()
        place_objects(settings.robot, self.scene)
        self.robot = robot = self._carrier(earlier)
        bodies = stand_ins(settings.bodies, (*robot.bodies, *self.scene.bodies))
        table = pair_table(robot, self.scene, settings.self_collision, settings.acm)
        labels = (*(b.label for b in robot.bodies), *self.scene.body_objects)
        padding = settings.padding if earlier is None else known_parts(settings.padding, bodies, labels)
        padded = padded_pairs(padding, bodies, labels, (table.pairs, table.resting))
        self.bodies, self._labels, paddings, (pairs, at_rest) = padded
        self.paddings, self.pairs = read_only(paddings), read_only(pairs)
        self._kernel = robot.kinematics if settings.kinematics == "batch" else None
        self._preparation = Preparation(
            self.bodies, self.excess, self.paddings, None if earlier is None else earlier._preparation
        )
        self._proofs = self._meeting_proofs(None if earlier is None else earlier._proofs)
        candidates = np.concatenate([self.pairs, at_rest])
        apart, resting = self._proofs.of(candidates) if settings.reach else np.zeros((2, len(candidates)), dtype=bool)
        self.unreachable, self.resting = read_only(apart[: len(self.pairs)]), read_only(resting[: len(self.pairs)])
        self._limits = (robot.lower, robot.upper) if self.unreachable.any() else None
        self._live = self._compiled(self.pairs, np.flatnonzero(~self.unreachable), self._limits)
        self._judge_row = self._row_validity()
        self._whole: CompiledPairs | None = None
        self._lock = threading.RLock()  # a finaliser that runs while its holder compiles may ask, too
        self._scene_taken(earlier)
        never_moving = self.pairs[self.resting & ~self.unreachable & self._with_carried()]
        self._warn_of_touching(at_rest[~apart[len(self.pairs) :]], never_moving, earlier)

    def _scene_taken(self, earlier: StateChecker | None) -> None:
        """For what else depends on the scene."""

    def _meeting_proofs(self, earlier: MeetingProofs | None) -> MeetingProofs:
        return MeetingProofs(self.robot, self.bodies, self._preparation, self._kernel is not None, earlier)

    def __getstate__(self) -> dict[str, Any]:
        """What a pickle has: prepared bodies and tables, so that nothing is prepared twice; nothing compiled."""
        return {name: value for name, value in self.__dict__.items() if name not in self._COMPILED} | {
            "_kernel": self._kernel is not None
        }

    def __copy__(self: Same) -> Same:
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)  # within a process, what is compiled is shared
        return other

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._kernel = self.robot.kinematics if state["_kernel"] else None
        self._proofs = self._meeting_proofs(None)
        self._live = self._compiled(self.pairs, np.flatnonzero(~self.unreachable), self._limits)
        self._judge_row = self._row_validity()
        self._whole, self._lock = None, threading.RLock()

    def _with_carried(self) -> Bools:
        """(k,) which of `pairs` have a body that a link carries."""
        carried = np.array([body.carried is not None for body in self.bodies], dtype=bool)
        return np.asarray(carried[self.pairs].any(axis=1))

    def _carrier(self, earlier: StateChecker | None) -> Robot:
        """The robot with what the scene attaches to it."""
        carried = (*self._settings.robot.carried, *self.scene.attached)
        if earlier is not None and earlier.robot.carried == carried:
            return earlier.robot
        robot = self._settings.robot
        return robot.carrying(carried) if self.scene.attached else robot

    def with_scene(self: Same, scene: Scene | None) -> Same:
        """The same checker for another scene, e.g. this one's, in which something was moved, added or attached.

        Whatever both scenes share is not prepared again: bodies of the same shape, pairs whose bodies are where they
        were, and everything of the robot.

        Args:
            scene: The scene; None is empty.

        Returns:
            A checker with this one's settings.

        Raises:
            PlannercheckError: If this checker has stand-ins for its bodies.
        """
        if not isinstance(scene, Scene | None):
            raise PlannercheckError(f"with_scene takes a Scene, not {type(scene).__name__}")
        if self._settings.bodies is not None:
            raise PlannercheckError("a checker with stand-ins for its bodies can't take another scene: build a new one")
        other = copy.copy(self)
        other._prepare(scene if scene is not None else Scene("empty"), self)
        return other

    def attach(
        self: Same,
        name: str,
        parts: Parts | None,
        link: str,
        pose: ArrayLike | None = None,
        touch_links: Iterable[str] = (),
        *,
        q: ArrayLike | None = None,
    ) -> Same:
        """The same checker with an object that a link carries.

        Args:
            name: Of the object.
            parts: Its shape, or posed shapes; None for an object of the scene, which leaves the world.
            link: Which carries it. The object is tested against all other links, and against obstacles.
            pose: (4, 4) of the object's frame in the link's, m.
            touch_links: Links, or other carried objects, that it may touch, too.
            q: (nq,) instead of `pose`, for an object of the scene: it is attached where it stands while the robot is at
                this configuration.

        Returns:
            A checker that shares all prepared bodies with this one.
        """
        scene = self.scene.copy()
        if q is not None:
            if pose is not None or parts is not None:
                raise PlannercheckError("attach takes a pose on the link, or for an object of the scene q=, not both")
            pose = inverse(self._link_pose(link, q)) @ scene.object(name).pose
        scene.attach(name, link, pose, touch_links, parts)
        return self.with_scene(scene)

    def detach(self: Same, name: str, q: ArrayLike | None = None) -> Same:
        """The same checker without an attached object, or with it standing in the world.

        Args:
            name: Of the object.
            q: (nq,) the object becomes an obstacle where it is at this configuration; None removes it.

        Returns:
            A checker that shares all prepared bodies with this one.
        """
        scene = self.scene.copy()
        if name not in {item.name for item in scene.attached}:
            raise unknown_name("attached object", name, [item.name for item in scene.attached])
        if q is None:
            scene.remove(name)
        else:
            item = scene.object(name)
            scene.detach(name, self._link_pose(str(item.link), q) @ item.pose)
        return self.with_scene(scene)

    def _link_pose(self, link: str, q: ArrayLike) -> Floats:
        """(4, 4) of a link at one configuration (nq,), m."""
        index = self.robot.link_index(link)
        return np.asarray(self._link_poses(self.robot.check_configurations(self._single(q)))[0, index])

    def _compiled(self, pairs: Ints, rows: NDArray[np.int64], limits: tuple[Floats, Floats] | None) -> CompiledPairs:
        test, switches = self._options
        options = (pair_options(*test), *switches)
        kernel = self._kernel if self._settings.static_poses else None
        return CompiledPairs(self.robot, self.bodies, self._preparation, pairs, rows, limits, options, kernel)

    @property
    def _all(self) -> CompiledPairs:
        """All pairs, for configurations beyond the limits and for given poses; compiled when first needed."""
        if self._limits is None:
            return self._live
        with self._lock:
            if self._whole is None:
                self._whole = self._compiled(self.pairs, np.arange(len(self.pairs)), None)
            return self._whole

    @property
    def polytopes(self) -> tuple[Polytope | None, ...]:
        """The prepared body of each of `bodies`; None where no pair needs it."""
        _ = self._all
        return self._preparation.so_far()

    @property
    def prepared(self) -> tuple[Polytope | None, ...]:
        """The same as far as bodies have been needed: those of unreachable pairs are prepared late."""
        return self._preparation.so_far()

    def _warn_of_touching(self, uncounted: Ints, counted: Ints, earlier: StateChecker | None) -> None:
        """Warns of pairs that no joint moves and that touch; of those that were there before, it was warned.

        Args:
            uncounted: (k, 2) links that are fixed to the world with obstacles.
            counted: (k, 2) carried objects with links, for which no configuration is valid if they touch.
            earlier: The checker that this one follows.
        """
        known = set() if earlier is None else set(earlier.bodies)
        for rows, words in ((uncounted, UNCOUNTED), (counted, COUNTED)):
            news = [row for row in rows.tolist() if not known.issuperset(self.bodies[k] for k in row)]
            for a, b in self._touching(np.array(news, dtype=np.int32).reshape(-1, 2)):
                text = words.format(self._labels[a], self._labels[b], robot=self.robot.name)
                warnings.warn(text, RuntimeWarning, stacklevel=4)

    def _touching(self, rows: Ints) -> list[list[int]]:
        """Which of these pairs (k, 2) touch at the reference."""
        if not len(rows):
            return []
        compiled = self._compiled(rows, np.arange(len(rows)), None)
        touching: list[list[int]] = rows[compiled.colliding(self._link_poses(self.robot.reference[None]))[0]].tolist()
        return touching

    def is_valid(self, q: ArrayLike) -> bool:
        """Whether one configuration is free of collision.

        Args:
            q: (nq,) rad and m. Limits are not looked at.

        Returns:
            True if no pair shares a point.
        """
        known = self._judge_row(q)
        if known is None:  # not an array of doubles yet, e.g. a list
            row = self._single(q)
            known = self._judge_row(np.ascontiguousarray(row[0]))
        return bool(self.check_states(row)[0]) if known is None else known

    def _row_validity(self) -> Callable[[ArrayLike], bool | None]:
        """A compiled judge of rows that need no care, and None for all others."""
        if self._kernel is None or self.robot.configuration_map.units:  # it does not look at unit vectors' lengths
            return _never_known
        judge: Callable[[ArrayLike], bool | None] = core.row_validity(self._live.core, self._kernel)
        return judge

    def state_validity(self) -> Callable[[Any], bool] | None:
        """A compiled function that judges states of an OMPL RealVectorStateSpace of nq numbers; None if there is none.

        It has the same verdicts as `is_valid`. There is none where Pinocchio itself has to pose, nor for robots with
        quaternions, or cosines and sines, whose length has to be looked at.
        """
        if self._kernel is None or self.robot.configuration_map.units:
            return None
        judge: Callable[[Any], bool] = core.state_validity(self._live.core, self._kernel, self.is_valid)
        return judge

    def check_states(self, q: ArrayLike, threads: int = 1) -> Bools:
        """Whether each configuration of a set is free of collision.

        Args:
            q: (n, nq) rad and m.
            threads: How many to use.

        Returns:
            (n,), True means valid.
        """
        rows = self.robot.check_configurations(q)
        threads = checked_threads(threads, len(rows))
        if self._kernel is None:
            return np.asarray(self._all.core.first_of_poses(self._link_poses(rows), threads) < 0)
        return self._judged(lambda table, part: table.core.check_states(self._kernel, part, threads).view(bool), rows)

    def first_colliding_pair(self, q: ArrayLike, threads: int = 1) -> Ints:
        """The first colliding pair of each configuration, in the order of `pairs`.

        Args:
            q: (n, nq) rad and m.
            threads: How many to use.

        Returns:
            (n,) rows of `pairs`, -1 where the configuration is valid.
        """
        rows = self.robot.check_configurations(q)
        threads = checked_threads(threads, len(rows))
        if self._kernel is None:
            return self._all.named(self._all.core.first_of_poses(self._link_poses(rows), threads))
        return self._judged(
            lambda table, part: table.named(table.core.first_of_states(self._kernel, part, threads)), rows
        )

    def _judged(self, judge: Callable[..., NDArray[Any]], *rows: NDArray[Any]) -> NDArray[Any]:
        """Rows judged with the pairs that count for them.

        Args:
            judge: Gets compiled pairs and some of the rows, gives an array (n,).
            rows: Arrays (n, …), which judge gets; a row counts as within the limits if its configurations are.

        Returns:
            (n,).
        """
        beyond = self._beyond_limits(*rows)
        if not beyond.any():
            return np.asarray(judge(self._live, *rows))
        if beyond.all():
            return np.asarray(judge(self._all, *rows))
        within = judge(self._live, *(array[~beyond] for array in rows))
        out = np.empty(len(beyond), dtype=within.dtype)
        out[~beyond], out[beyond] = within, judge(self._all, *(array[beyond] for array in rows))
        return out

    def _beyond_limits(self, *rows: NDArray[Any]) -> Bools:
        """(n,) whether some configuration of each row is; False where all pairs are tested anyway."""
        beyond = np.zeros(len(rows[0]), dtype=bool)
        for q in rows:
            if self._limits is not None and q.ndim == 2:
                outside = (q < self._limits[0]) | (q > self._limits[1])
                if outside.any():
                    beyond |= outside.any(axis=1)
        return beyond

    def colliding_pairs(self, q: ArrayLike) -> Bools:
        """Which pairs collide, without stopping at the first.

        Args:
            q: (n, nq) rad and m.

        Returns:
            (n, k) for the k rows of `pairs`.
        """
        return self._all.colliding(self._link_poses(self.robot.check_configurations(q)))

    def body_poses(self, q: ArrayLike) -> Floats:
        """World poses of all bodies, the same bits that the verdicts use.

        Args:
            q: (n, nq) or (nq,) rad and m.

        Returns:
            (n, bodies, 4, 4), m; NaN for bodies that no pair needs.
        """
        return self._all.body_poses(self._link_poses(self.robot.check_configurations(q)))

    def explain(self, q: ArrayLike, separations: bool = False) -> Verdict:
        """The verdict of one configuration with the names and certificates behind it.

        Args:
            q: (nq,) rad and m.
            separations: Whether to give the separating planes of all other pairs, too.

        Returns:
            The verdict; certificates are in world coordinates.
        """
        row = self._single(q)
        colliding = self.colliding_pairs(row)[0]
        poses = self.body_poses(row)[0]
        wanted = range(len(self.pairs)) if separations else np.flatnonzero(colliding)
        found = [self._pair_verdict(int(k), poses, bool(colliding[k])) for k in wanted]
        return Verdict(
            not colliding.any(),
            tuple(v for v in found if v.colliding),
            tuple(v for v in found if not v.colliding),
            self._kinematic_error(row, poses),
        )

    def explain_pair(self, k: int, q: ArrayLike) -> PairVerdict:
        """The verdict of row k of `pairs` alone.

        Args:
            k: Row.
            q: (nq,) rad and m.

        Returns:
            The verdict with its certificate.
        """
        row = self._single(q)
        return self._pair_verdict(k, self.body_poses(row)[0], bool(self.colliding_pairs(row)[0, k]))

    def _kinematic_error(self, row: Floats, poses: Floats) -> float:
        """The proven bound for the poses (bodies, 4, 4) of one configuration (1, nq), m.

        Pinocchio's poses are off by no more than the kernel's, and how far the two are apart.
        """
        error = self.robot.kinematic_error_at(row[0])
        if self._kernel is None and self.robot.kinematics is not None:
            error += largest_distance(self.bodies, poses, self._all.body_poses(self.robot.link_poses(row))[0])
        return error

    def _pair_verdict(self, k: int, poses: Floats, colliding: bool) -> PairVerdict:
        a, b = (int(i) for i in self.pairs[k])
        certificate = certify_posed(self._preparation.polytope(a), self._preparation.polytope(b), poses[a], poses[b])
        first, second = self.pair_names(k)
        return PairVerdict(first, second, self.bodies[a].name, self.bodies[b].name, colliding, certificate)

    def pair_names(self, k: int) -> tuple[str, str]:
        """The link and the other link or obstacle of row k of `pairs`."""
        a, b = self.pairs[k]
        return self._labels[a], self._labels[b]

    def clearance(self, q: ArrayLike, lower_bound: bool = False) -> float:
        """The least distance of all pairs, whatever the padding.

        Args:
            q: (nq,) rad and m.
            lower_bound: Whether a proved lower bound will do, which is cheaper.

        Returns:
            m, within 1e-9 of max(distance, 1e-3 of the bodies' radius). Where bodies overlap, it is the negative of a
            depth: moving one of them by it separates them, but a shorter move may, too (see `distances.Distance`).
            Infinite without pairs.
        """
        return float(self.clearances(self._single(q), lower_bound)[0])

    def clearances(self, q: ArrayLike, lower_bound: bool = False) -> Floats:
        """`clearance` of a set of configurations.

        Args:
            q: (n, nq) rad and m.
            lower_bound: As for `clearance`.

        Returns:
            (n,), m.
        """
        return self._clearances(q, lower_bound)[0]

    def nearest_pair(self, q: ArrayLike) -> Ints:
        """The pairs that are nearest, or deepest in each other.

        Args:
            q: (n, nq) rad and m.

        Returns:
            (n,) rows of `pairs`; -1 if there are none.
        """
        return self._clearances(q, False)[1]

    def _clearances(self, q: ArrayLike, lower_bound: bool) -> tuple[Floats, Ints]:
        rows = self.robot.check_configurations(q)
        if not len(self.pairs):
            return np.full(len(rows), np.inf), np.full(len(rows), -1, dtype=np.int32)
        used = np.unique(self.pairs)
        table = np.searchsorted(used, self.pairs).astype(np.int32)
        bodies = [self._preparation.polytope(k).core for k in used.tolist()]
        poses = np.ascontiguousarray(self.body_poses(rows)[:, used])
        distances, nearest = core.clearances(
            bodies, poses, table, self.paddings[used], _BOUND_ROUNDS if lower_bound else 0
        )
        return np.asarray(distances), np.asarray(nearest)

    def statistics(self) -> dict[str, Any]:
        """Counters of all calls so far: states, pairs, what settled them, and the pair test's queries.

        Every pair of every state is counted once: as unreachable, or by what settled it; as skipped where another pair
        of the state collides and that is all that was asked.
        """
        counted = dict(self._live.core.statistics())
        unreachable = int(self.unreachable.sum()) * counted["states"]
        counted["pairs"] += unreachable
        if self._whole is not None:
            counted = added(counted, self._whole.core.statistics())
        return {"states": counted.pop("states"), "pairs": counted.pop("pairs"), "unreachable": unreachable, **counted}

    def _link_poses(self, rows: Floats) -> Floats:
        poses = self.robot.pinocchio_link_poses(rows) if self._kernel is None else self.robot.link_poses(rows)
        return np.ascontiguousarray(poses)

    def _single(self, q: ArrayLike) -> Floats:
        try:
            row = np.asarray(q, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise PlannercheckError(f"one configuration must be {self.robot.nq} numbers, not {q!r:.80}") from None
        if row.ndim != 1:
            raise PlannercheckError(f"one configuration must have shape ({self.robot.nq},), not {row.shape}")
        return row[None]

    def __repr__(self) -> str:
        return f"Checker({self.robot.name!r} in {self.scene.name!r}, {len(self.pairs)} pairs)"


def _never_known(q: ArrayLike) -> None:
    """For robots whose configurations all need care."""
