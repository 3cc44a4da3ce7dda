"""The stress suite: families of hard pairs, with every verdict compared with exact arithmetic.

The data flow: body_families, contact_poses -> sample_bodies, touching_neighbours -> random_cases ->
campaign (with `oracle`, and `other_libraries` in processes of their own) -> tables.
"""
