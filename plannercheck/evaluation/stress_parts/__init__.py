"""The stress of sets of parts, half-spaces and ellipsoids: every verdict is compared with exact arithmetic.

The data flow: pieces, given -> bodies -> set_families -> half_space_truth -> half_space_placing -> draws -> truth,
ellipsoid_truth, judges -> campaign. The truth is from cpp/oracle, part by part, or from whole numbers; `given` computes
the places of the parts from the drawn numbers, without the core.
"""
