"""Bodies, and queries on pairs of them.

Read `shapes` first (collision shapes of links and obstacles), then `polytope` (a body prepared for queries: the exact
hull and its hierarchies), `intersection` (the test of one pair), `certificates` (proofs of its verdict; `exact_planes`
are theirs), `distance` and `penetration_depth`. `solids` are meshes that are not their hulls (`hull_equality` decides);
`solid_certificates` and `solid_separations` prove their verdicts. `placed` keeps a body's pose for many queries,
`given_bodies` asks the core at once. `objects` are posed shapes that move as one. `mesh_files` and
`convex_decomposition` make shapes from files; `piece_repair` makes convex `pieces` hold their mesh, as `exact_coverage`
decides, and `protrusion` bounds how far they stick out of it; `piece_recipes` say which triangles make a piece.
`exact_reference` and `fcl_bodies` check verdicts.
"""
