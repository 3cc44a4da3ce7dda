"""The stress suite: families of hard pairs, and every verdict held against exact arithmetic.

Data goes body_families, contact_poses -> sample_bodies, touching_neighbours -> random_cases -> run, which asks
`oracle` and, in processes of their own (`supervised_process`), `other_libraries` -> tables; `failing_cases` keeps what
fails.
"""
