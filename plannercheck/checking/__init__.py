"""The pairs of bodies that a checker tests, and its verdict on one configuration.

Read `pair_table` first (all pairs). `pair_proofs` and `unreachable_pairs` prove which of them never meet within the
limits, by the bounds of `reach_bounds`; `apart_cells` proves for which values of two joints a pair is apart;
`robot_reach` keeps the results that do not depend on obstacles. `prepared_bodies`, `compiled_pairs` and
`compiled_tables` hold the core's data, and `verdicts` the results of a checker. `built_checker` puts these together,
and `state_checker` answers; its other base classes are in `checker_base` (names and certificates, in space and in the
plane), `clearance`, `point_queries` and `carrying_checker`. `padding` and `settings` hold its arguments, and
`touching_pairs` its warnings. `left_out_pairs` lists all places where a pair may be left out, and `collision_matrix`
proposes pairs to leave out. `protocols` says what checkers in
space and in the plane have in common.
"""
