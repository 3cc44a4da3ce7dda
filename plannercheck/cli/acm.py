"""`plannercheck acm`: proposes pairs of links to leave untested, or audits those that are left untested."""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from plannercheck.checking.collision_matrix import (
    ALWAYS,
    REASONS,
    Audit,
    AuditedPair,
    CollisionMatrix,
    LinkPair,
    audit,
    colliding_rows,
    collision_matrix,
    with_all_joints,
)
from plannercheck.checking.collision_matrix_files import commented_srdf, srdf_text, yaml_text
from plannercheck.cli import acm_proofs
from plannercheck.cli.common import check_folder, table, table_of
from plannercheck.cli.robot_options import ROBOT_HELP, add_urdf_arguments, described, given_options
from plannercheck.cli.unused_options import check_used
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.records import write_record
from plannercheck.motions.pair_decisions import PairDecision
from plannercheck.planar.robot_files import is_planar
from plannercheck.robots.description import RobotDescription, description_of, shipped_robots
from plannercheck.robots.description_files import description_text
from plannercheck.robots.geometry_choices import of_meshes
from plannercheck.robots.robot import Robot
from plannercheck.robots.srdf import DisabledPair, disabled_collisions

_EPILOG = """\
Pairs are left out for MoveIt's reasons: adjacent; default, they collide in the reference; always, in at least 95 % of
random configurations; never, in none of them, or proved never to within the joint limits. Links are their convex hulls
unless --geometry says otherwise, so that they collide more often than their meshes; --meshes says how often those do.
All joints are moved, whatever the robot's group.

--prove decides pairs by the joints between both links: proved never to collide within the limits, or a configuration
that collides. What is not decided after some time is open. It takes pairs that were not seen to collide, or with
--audit all that are disabled.

--audit holds the pairs that the SRDF or YAML disables against the same configurations and names those that collide,
most frequent first. Its exit code is 1 if there are any.

Examples:
  plannercheck acm --robot my.urdf --output my.srdf
  plannercheck acm --robot panda --audit
  plannercheck acm --robot panda --audit --prove --output pairs.json
  plannercheck acm --robot my.urdf --audit my.srdf --prove --proofs my.pairs.npz && plannercheck verify my.pairs.npz
  plannercheck acm --audit --meshes 200          # all shipped robots that disable pairs
"""

# Suffixes of what is written.
_YAML, _SRDF, _JSON = (".yaml", ".yml"), (".srdf", ".xml"), (".json",)
_TEXTS = (*_YAML, *_SRDF)


@dataclass(frozen=True)
class AuditRow:
    """What the audit of a robot found.

    Attributes:
        robot: Its name.
        declared_by: "SRDF" or "YAML".
        link_pairs: Pairs of links with bodies.
        disabled: Pairs that are disabled.
        colliding: The pairs among them that collide in some states, less adjacent pairs and pairs that always do.
        never: The pairs among these whose reason is that they never do.
        most: The one that collides most often, and how often.
        colliding_meshes: Of `colliding`, those whose meshes collide; None if they were not asked for.
        most_meshes: As `most`, by meshes.
        proved_never: Disabled pairs that are proved never to collide; None if no proofs were asked for, as all below.
        collide: Disabled pairs that collide in some configuration, adjacent ones included.
        open: Disabled pairs of which neither is known.
        seconds: Processor time of the proofs.
    """

    robot: str
    declared_by: str
    link_pairs: int
    disabled: int
    colliding: int
    never: int
    most: str
    colliding_meshes: int | None = None
    most_meshes: str = ""
    proved_never: int | None = None
    collide: int | None = None
    open: int | None = None
    seconds: float | None = None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    parser.add_argument("--robot", help=f"{ROBOT_HELP}; with --audit, default: all shipped")
    add_urdf_arguments(parser)
    parser.add_argument(
        "--audit",
        type=Path,
        nargs="?",
        const=True,
        default=False,
        metavar="SRDF",
        help="say which pairs are disabled, yet collide; by this SRDF, as with --srdf",
    )
    parser.add_argument(
        "--output",
        type=Path,
        help="write the proposal (.srdf, or a robot's .yaml), or the table (.json; with --audit --prove also comments "
        "in the .srdf)",
    )
    parser.add_argument("--states", type=int, default=10_000, help="number of random configurations; default: 10000")
    parser.add_argument("--seed", type=int, default=0, help="seed of the random configurations; default: 0")
    parser.add_argument(
        "--always",
        type=float,
        default=ALWAYS,
        help="share of colliding configurations that counts as always; default: 0.95",
    )
    parser.add_argument(
        "--prove",
        type=float,
        nargs="?",
        const=1.0,
        metavar="SECONDS",
        help="decide pairs by proofs, for so many seconds of processor time a pair; default: 1",
    )
    parser.add_argument(
        "--proofs", type=Path, metavar="FILE", help="with --prove: write proofs for `plannercheck verify` (.json, .npz)"
    )
    parser.add_argument(
        "--meshes",
        type=int,
        default=0,
        metavar="N",
        help="with --audit: also test up to N states a pair by their meshes as they are, exactly",
    )


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    _take_srdf(options)
    check_folder(options.output)
    check_folder(options.proofs)
    of_all = options.audit and options.robot is None
    proves_audit = options.audit and options.prove is not None
    suffixes = _JSON if of_all else (*_JSON, *_SRDF) if proves_audit else _TEXTS
    if options.output is not None and options.output.suffix not in suffixes:
        kinds = ".json" if of_all else ".json or .srdf" if proves_audit else ".srdf or .yaml"
        raise PlannercheckError(f"--output must end in {kinds}, not {options.output.name!r}")
    if options.states < 1 or options.seed < 0 or options.meshes < 0:
        raise PlannercheckError("--states must be at least 1, --seed and --meshes at least 0")
    if options.prove is not None and not 0 < options.prove < float("inf"):
        raise PlannercheckError(f"--prove takes seconds, a positive number, not {options.prove}")
    if options.prove is None:
        check_used(options, ("--proofs",), "with --prove")
    if options.audit and not of_all and not proves_audit:
        check_used(options, ("--output",), "without --audit, which proposes nothing")
    elif not options.audit:
        check_used(options, ("--meshes",), "with --audit")
    if options.robot is None and not options.audit:
        raise PlannercheckError("acm needs --robot; without one, --audit audits all shipped robots")
    if options.robot is not None and is_planar(options.robot, "robots"):
        raise PlannercheckError(f"robot {options.robot!r} is planar: its self pairs are in its YAML")
    if options.robot is None:
        return _audit_shipped(options)
    description = described(options)
    matrix = _matrix(description, options)
    if options.audit:
        return _show_audit(matrix, description, options)
    decisions: list[PairDecision] = []
    if options.prove is not None:
        matrix, decisions = acm_proofs.with_proofs(matrix, options.prove)
    _show_proposal(matrix)
    if options.prove is not None:
        acm_proofs.show_proposed(decisions)
    if options.output is not None:
        _write(matrix, description, options.output)
    if options.proofs is not None:
        acm_proofs.write_proofs(matrix, decisions, options.prove, options.proofs)
    return 0


def _take_srdf(options: argparse.Namespace) -> None:
    """Leaves whether there is an audit, and the SRDF where --srdf has it."""
    if isinstance(options.audit, Path):
        if options.srdf is not None:
            raise PlannercheckError("--srdf and --audit both name an SRDF: give one of them")
        options.srdf, options.audit = options.audit, True


def _matrix(description: RobotDescription, options: argparse.Namespace) -> CollisionMatrix:
    return collision_matrix(Robot.from_description(description), options.states, options.seed, options.always)


def _declared(description: RobotDescription) -> list[DisabledPair]:
    """The pairs that SRDF and YAML disable one by one; links that are disabled by default are no claim about pairs."""
    from_srdf = disabled_collisions(description.semantics.root) if description.semantics else []
    of_robots = [
        DisabledPair(f"{name}/{pair.link_a}", f"{name}/{pair.link_b}", pair.reason)
        for name in description.robots
        for pair in _declared(description.of_robot(name))
    ]
    return [*from_srdf, *description.disabled_pairs, *of_robots]


def _show_proposal(matrix: CollisionMatrix) -> None:
    counts = Counter(pair.reason for pair in matrix.pairs)
    print(f"{matrix.robot.name}: {len(matrix.pairs)} pairs of links, {len(matrix.configurations)} configurations\n")
    rows = [(reason, counts[reason]) for reason in REASONS] + [("to be tested", counts[None])]
    print(table(("leave out because", "pairs"), rows))


def _write(matrix: CollisionMatrix, description: RobotDescription, path: Path) -> None:
    if path.suffix in _YAML:
        joints = None if description.group is None else Robot.from_description(description).joint_names
        text = description_text(description, joints, yaml_text(matrix.disabled()), path)
    else:
        root = None if description.semantics is None else description.semantics.root
        text = srdf_text(matrix.robot.model.name, matrix.disabled(), root)
    write_atomically(path, lambda aside: aside.write_text(text, encoding="utf-8"))
    print(f"\n{len(matrix.disabled())} disabled pairs written to {path}")


def _show_audit(matrix: CollisionMatrix, description: RobotDescription, options: argparse.Namespace) -> int:
    declared = _declared(description)
    if not declared:
        raise PlannercheckError(f"robot {matrix.robot.name!r} disables no pairs, so that there is nothing to audit")
    found = audit(matrix, declared)
    if options.prove is not None:
        rows, decisions = acm_proofs.audited(matrix, found, options.prove)
        print(f"{matrix.robot.name}: {_summary(found)}; {len(matrix.configurations)} configurations\n")
        acm_proofs.show_audited(rows, options.robot)
        if options.output is not None:
            _write_audit(rows, description, options.output)
        if options.proofs is not None:
            acm_proofs.write_proofs(matrix, decisions, options.prove, options.proofs)
        return 1 if any(row.answer == "collides" and not row.adjacent for row in rows) or found.hopeless else 0
    as_meshes = _mesh_counter(matrix, description, options.meshes)
    print(f"{matrix.robot.name}: {_summary(found)}; {len(matrix.configurations)} configurations\n")
    for pair in found.suspects:
        _show_suspect(matrix, pair, as_meshes)
    for alone in found.hopeless:
        print(f"{alone.link_a} and {alone.link_b} are tested and collide in every state: none is valid")
    if found.spared:
        print(
            f"{len(found.spared)} pairs are tested though they never meet within the limits, by proof (checkers know)"
        )
    return 1 if found.suspects or found.hopeless else 0


def _write_audit(rows: list[acm_proofs.DecisionRow], description: RobotDescription, path: Path) -> None:
    if path.suffix in _JSON:
        write_record(path, rows)
        return
    if description.semantics is None:
        raise PlannercheckError("--output .srdf needs a robot with an SRDF: its YAML disables the pairs")
    comments = {frozenset((row.link_a, row.link_b)): acm_proofs.comment_of(row) for row in rows}
    text = commented_srdf(description.semantics.root, comments)
    write_atomically(path, lambda aside: aside.write_text(text, encoding="utf-8"))


def _summary(found: Audit) -> str:
    without = sum(pair.found is None for pair in found.disabled)
    return (
        f"{len(found.disabled)} pairs of links are disabled, {without} of them of links without collision bodies; "
        f"{len(found.suspects)} collide in some states"
    )


def _show_suspect(matrix: CollisionMatrix, pair: AuditedPair, as_meshes: Callable[[LinkPair], str]) -> None:
    assert pair.found is not None
    reason = f" ({pair.declared.reason})" if pair.declared.reason else ""
    print(
        f"{pair.found.link_a} and {pair.found.link_b} are disabled{reason}, yet they collide in "
        f"{100 * pair.found.share:.2f} % of states{as_meshes(pair.found)}"
    )
    example = ", ".join(f"{value:.4g}" for value in matrix.example(pair.found).values())
    print(f"    e.g. at [{example}]")


def _mesh_counter(matrix: CollisionMatrix, description: RobotDescription, most: int) -> Callable[[LinkPair], str]:
    """A function that says how many of a pair's colliding configurations, `most` of them, collide as meshes."""
    if not most:
        return lambda pair: ""
    share = _mesh_share(matrix, description, most)
    return lambda pair: f", as meshes in {100 * share(pair):.2f} %"


def _mesh_share(matrix: CollisionMatrix, description: RobotDescription, most: int) -> Callable[[LinkPair], float]:
    """A function that estimates in which part of all configurations a pair collides as meshes."""
    robot = with_all_joints(of_meshes(description))

    def share(pair: LinkPair) -> float:
        tried = matrix.configurations[matrix.colliding_rows(pair)[:most]]
        return pair.share * len(colliding_rows(robot, tried, pair.link_a, pair.link_b)) / len(tried)

    return share


def _audit_shipped(options: argparse.Namespace) -> int:
    """Prints a row a robot that disables pairs."""
    given = given_options(options) + (["--proofs"] if options.proofs is not None else [])
    if given:
        raise PlannercheckError(f"{' and '.join(given)} need --robot")
    rows = [_row(name, options) for name in shipped_robots() if _declared(description_of(name))]
    columns: dict[str, Callable[[AuditRow], object]] = {
        "robot": lambda row: row.robot,
        "from": lambda row: row.declared_by,
        "pairs of links": lambda row: row.link_pairs,
        "disabled": lambda row: row.disabled,
        "collide, not adjacent": lambda row: row.colliding,
        "of them 'never'": lambda row: row.never,
        "most frequent": lambda row: row.most,
    }
    if options.prove is not None:
        columns["proved never"] = lambda row: row.proved_never
        columns["collide"] = lambda row: row.collide
        columns["open"] = lambda row: row.open
        columns["s"] = lambda row: f"{row.seconds or 0:.1f}"
    if options.meshes:
        columns["as meshes"] = lambda row: row.colliding_meshes
        columns["most frequent of them"] = lambda row: row.most_meshes
    print(table_of(rows, columns))
    if options.output is not None:
        write_record(options.output, rows)
    return 0


def _row(name: str, options: argparse.Namespace) -> AuditRow:
    description = description_of(name)
    matrix = _matrix(description, options)
    found = audit(matrix, _declared(description))
    never = [pair for pair in found.suspects if pair.declared.reason.lower().startswith("never")]
    worst = [pair.found for pair in found.suspects if pair.found is not None]
    row = AuditRow(
        name,
        "SRDF" if description.srdf else "YAML",
        len(matrix.pairs),
        len(found.disabled),
        len(found.suspects),
        len(never),
        _worst([(pair, pair.share) for pair in worst]),
    )
    if options.prove is not None:
        start = time.process_time()
        answers = Counter(row.answer for row in acm_proofs.audited(matrix, found, options.prove)[0])
        spent = time.process_time() - start
        proved, collide, unknown = answers["never"], answers["collides"] + answers["always"], answers["open"]
        row = replace(row, proved_never=proved, collide=collide, open=unknown, seconds=spent)
    if not options.meshes:
        return row
    share = _mesh_share(matrix, description, options.meshes)
    real = [(pair, part) for pair in worst if (part := share(pair)) > 0]
    return replace(row, colliding_meshes=len(real), most_meshes=_worst(sorted(real, key=lambda item: -item[1])))


def _worst(pairs: list[tuple[LinkPair, float]]) -> str:
    if not pairs:
        return "-"
    pair, share = pairs[0]
    return f"{100 * share:.2f} % {pair.link_a}, {pair.link_b}"
