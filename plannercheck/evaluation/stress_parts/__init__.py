"""The stress of sets of parts, half-spaces and ellipsoids: every verdict is compared with exact arithmetic.

The data flow: pieces, given -> bodies -> set_families -> half_space_truth -> half_space_placing -> draws -> truth,
ellipsoid_truth, judges -> campaign. The truth is cpp/oracle's, part by part, or that of whole numbers;
where the parts are is computed in `given` from the numbers that were drawn, not asked of the core.
"""
