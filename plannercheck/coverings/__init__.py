"""Coverings: spheres, capsules and boxes that stand for the links of a robot, and proofs that they hold them.

Read `covering` first (the public `Covering`), then `primitives` (the cover of one link), `regions` (what has to be
covered), `search` (branch and bound over their parts, which proves or finds the point furthest outside), `audits`,
`excess` (how far a cover sticks out) and `fitting`. `neighbours` adds what other links' covers hold in every
configuration. `curobo_files`, `urdf_files` and `plain_files` are the formats of models.
"""
