"""Motions between configurations, sampled or proved free, and the checker that users meet.

Read `checker` first (a `StateChecker` that knows motions, too), then `motion_ends` (the short way round), `sampling`
(states dense enough for a given step), `joint_chains` and `certifier_pairs` (what bounds how far two bodies move
against each other), `certifier` (motions that the core proves free) with `certifier_answers` (what it says) and
`rounding_bounds` (how far computed poses are off), and `explanation` (one motion explained). `proof_builder` writes a
motion's proof down, `proof_model` its robot and scene, and `proof_confirmation` compares these with files.
"""
