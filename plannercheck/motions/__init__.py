"""Motions between configurations, sampled or proved free, and the public `Checker`.

Read `checker` first (a `StateChecker` that also checks motions), then `motion_ends` (the short way round), `sampling`
(how many states a motion needs), `joint_chains` (bounds on how two bodies move relative to each other), `robot_chains`
(those of a robot, kept) and `certifier_pairs` (both for the core), `certifier` (motions that the core proves free) with
`certifier_answers` (its results) and `rounding_bounds` (the error of computed poses), and `explanation` (one motion
explained). `proof_builder` makes the proof of a motion, `proof_model` describes its robot and scene, and
`proof_confirmation` compares that description with files. `pair_decisions` decides pairs of links at all
configurations, `pair_proof_builder` makes their proofs.
"""
