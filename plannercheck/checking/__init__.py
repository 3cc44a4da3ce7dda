"""Which pairs of bodies are tested, and what is said about one configuration.

Read `pair_table` first (all pairs), then `pair_proofs` and `unreachable_pairs` (which of them never meet within the
limits, by the bounds of `reach_bounds`), `compiled_pairs` (what the core judges configurations with) and `verdicts`
(what a checker says), and `state_checker`, which puts these together. `padding` and `settings` are what a checker is
built with, `collision_matrix` proposes which pairs to leave out, `protocols` are what checkers in space and in the
plane have in common.
"""
