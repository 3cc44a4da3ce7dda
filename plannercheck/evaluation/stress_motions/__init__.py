"""The stress suite of motions: contact by construction, and what the certifier says of it.

Data goes recipes, aims, tangents, trees, contacts, ends -> draws (and planar_draws, ompl_paths, unposed_robots) ->
subjects (what is asked) -> judges (by reasons and collisions) -> outcomes -> run -> tables; `cases` keeps what fails.
"""
