"""`plannercheck acm --prove`: pairs of links proved never to collide, or shown to collide, in place of sampled.

In: a collision matrix, pairs, how long to search. Out: the matrix with what was proved; decisions in words, in rows, in
comments of an SRDF, and as files of proofs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from plannercheck.checking.collision_matrix import Audit, CollisionMatrix, LinkPair
from plannercheck.cli.common import table
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.progress import report
from plannercheck.motions.pair_decisions import PairDecider, PairDecision
from plannercheck.motions.pair_proof_builder import pair_proofs
from plannercheck.proofs.link_pairs import save_pair_proofs

# A proof may take so many times as long as the decision: this proves 100,000 boxes a second, the verifier a thousand.
_BUILDING = 1000


@dataclass(frozen=True)
class DecisionRow:
    """A disabled pair, for files.

    Attributes:
        link_a: A link.
        link_b: Another link.
        declared: The reason that the SRDF or YAML gives.
        answer: "never", "always", "collides" or "open", see `PairDecision`.
        adjacent: Whether a joint connects the links.
        joints: The joints between them.
        cells: Boxes of these joints' values that were proved free.
        open_share: The share of the joints' box that is not proved free.
        example: Values by joint name, rad and m, of a configuration that collides; None if none was found.
    """

    link_a: str
    link_b: str
    declared: str
    answer: str
    adjacent: bool
    joints: tuple[str, ...]
    cells: int
    open_share: float
    example: dict[str, float] | None


def decided(matrix: CollisionMatrix, pairs: Sequence[LinkPair], seconds: float) -> list[PairDecision]:
    """A decision for each pair, after so many seconds of processor time at most."""
    decider, found = PairDecider(matrix.robot), []
    for k, pair in enumerate(pairs):
        report(k, len(pairs), "pairs of links")
        found.append(decider.decide(pair.link_a, pair.link_b, seconds))
    report(len(pairs), len(pairs), "pairs of links")
    return found


def with_proofs(matrix: CollisionMatrix, seconds: float) -> tuple[CollisionMatrix, list[PairDecision]]:
    """The matrix in which pairs never seen to collide are decided: their reason becomes "proved never", or goes."""
    seen = [pair for pair in matrix.pairs if pair.reason == "never"]
    decisions = decided(matrix, seen, seconds)
    changed = {pair: _with_reason(pair, each) for pair, each in zip(seen, decisions, strict=True)}
    return replace(matrix, pairs=tuple(changed.get(pair, pair) for pair in matrix.pairs)), decisions


def _with_reason(pair: LinkPair, decision: PairDecision) -> LinkPair:
    if decision.answer == "open":
        return pair
    return replace(pair, reason="proved never" if decision.answer == "never" else None)


def audited(matrix: CollisionMatrix, found: Audit, seconds: float) -> tuple[list[DecisionRow], list[PairDecision]]:
    """A row and a decision for each disabled pair whose links have bodies."""
    known = [(pair.declared, pair.found) for pair in found.disabled if pair.found is not None]
    decisions = decided(matrix, [pair for _, pair in known], seconds)
    rows = [
        DecisionRow(
            pair.link_a,
            pair.link_b,
            declared.reason,
            each.answer,
            pair.reason == "adjacent",
            each.joints,
            each.cells,
            each.open_share,
            None if each.example is None else dict(zip(matrix.robot.joint_names, each.example.tolist(), strict=True)),
        )
        for (declared, pair), each in zip(known, decisions, strict=True)
    ]
    return rows, decisions


def write_proofs(matrix: CollisionMatrix, decisions: Sequence[PairDecision], seconds: float, path: Path) -> None:
    """Writes the proofs of decisions to a file, and says of how many there is none."""
    proofs = pair_proofs(PairDecider(matrix.robot), decisions, _BUILDING * seconds)
    if not proofs.pairs:
        raise PlannercheckError("no proof was found in time: give --prove more seconds")
    save_pair_proofs(proofs, path)
    known = {(pair.link_a, pair.link_b) for pair in proofs.pairs}
    missing = [each for each in decisions if each.answer != "open" and (each.link_a, each.link_b) not in known]
    still_open = len(decisions) - len(known) - len(missing)
    print(f"\n{len(known)} proofs written to {path}; without one are {still_open} open pairs and {len(missing)} others")
    for each in missing:
        print(f"{each.link_a} and {each.link_b}: no proof of {each.answer!r} was found in time")


def comment_of(row: DecisionRow) -> str:
    """A decision in words."""
    if row.answer == "open":
        return f"open in {row.open_share:.2%} of the joints' values"
    if row.answer != "collides":
        return f"proved {row.answer} to collide within the joint limits"
    values = row.example or {}
    return "collides at " + (", ".join(f"{name}={values[name]!r}" for name in row.joints) or "every configuration")


def show_proposed(decisions: Sequence[PairDecision]) -> None:
    """Prints what became of pairs that no sampled configuration has seen collide."""
    counts = Counter(each.answer for each in decisions)
    print(
        f"\nof {len(decisions)} pairs that no sampled configuration saw collide: {counts['never']} proved never to, "
        f"{counts['collides']} collide, {counts['open']} open"
    )
    for each in decisions:
        if each.answer == "collides":
            print(f"{each.link_a} and {each.link_b} collide, though no sampled configuration did")
        if each.answer == "open":
            print(f"{each.link_a} and {each.link_b}: open in {each.open_share:.2%} of their joints' values")


def show_audited(rows: Sequence[DecisionRow], robot: str) -> None:
    """Prints how many disabled pairs are proved, and those that collide though they are not adjacent."""
    counts = Counter((row.answer, row.adjacent) for row in rows)
    words = {
        "never": "proved never to collide",
        "always": "proved to collide always",
        "collides": "collide in some configuration",
        "open": "open",
    }
    cells = [(text, counts[answer, True], counts[answer, False]) for answer, text in words.items()]
    print(table(("disabled pairs", "adjacent", "others"), cells))
    for row in rows:
        if row.answer == "collides" and not row.adjacent:
            assert row.example is not None
            values = ", ".join(f"{name}={row.example[name]:.4g}" for name in row.joints)
            print(f"{row.link_a} and {row.link_b} ({row.declared or 'no reason'}) collide at {values}")
            given = ",".join(f"{row.example[name]!r}" for name in row.joints)
            print(f"    plannercheck view --robot {robot} --group {','.join(row.joints)} --q={given}")
        if row.answer == "open":
            print(f"{row.link_a} and {row.link_b}: open in {row.open_share:.2%} of their joints' values")
