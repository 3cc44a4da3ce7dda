"""The stress suite of motions: contact by construction, and the certifier's verdicts on it.

The data flow: recipes, aims, tangents, trees, contacts, ends -> draws (and planar_draws, ompl_paths, unposed_robots) ->
subjects (the checkers) -> judges (by reasons and collisions) -> outcomes -> campaign; `cases` keeps failures.
Solids: mesh_states (coal, the oracle) -> solid_draws, planned_draws -> the same judges, and mesh_collisions.
"""
