"""The stress suite: families of hard pairs, with every verdict compared with exact arithmetic.

The data flow: body_families, contact_poses -> sample_bodies, touching_neighbours -> random_cases -> run -> tables.
`posed_pairs` is what the stresses of solids and of sets of parts share. `run` calls `oracle` and, in
processes of their own (`supervised_process`), `other_libraries`; `failing_cases` keeps failures.
"""
