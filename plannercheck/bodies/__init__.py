"""Convex bodies, and what two of them have to do with each other.

Read `shapes` first (what a link or an obstacle is made of), then `polytope` (prepared for queries: the exact hull and
its hierarchies), `intersection` (the test of one pair), `certificates` (what proves its verdict), `distance` and
`penetration_depth`. `objects` are posed shapes that move as one. `meshes` and `convex_decomposition` make shapes from
files; `exact_reference` and `fcl_bodies` are what verdicts are held against.
"""
