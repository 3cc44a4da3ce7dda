"""Which pairs of bodies are tested, and what is said about one configuration.

Read `pair_table` first (all pairs), then `pair_proofs` and `unreachable_pairs` (which of them never meet within the
limits, by the bounds of `reach_bounds`), `prepared_bodies`, `compiled_pairs` and `compiled_tables` (what the core
judges configurations with) and `verdicts` (what a checker says), and `state_checker`, which puts these together.
`checker_base` (names and certificates, in space and in the plane), `clearance` and `carrying_checker` are what it
stands on; `padding` and `settings` are what it is built with, `touching_pairs` what it warns of. `left_out_pairs` lists
all places where a pair may be left out, `collision_matrix` proposes which ones to leave out; `hull_fidelity` says what
hulls refuse that meshes would not; `protocols` are what code
for checkers in space and in the plane asks of them.
"""
