"""The stress of solids: pairs of concave bodies, with every verdict compared with exact arithmetic.

The data flow: surfaces -> solid_families, convex_families, faults -> bodies -> placing, common_frames -> draws ->
judges -> campaign. The truth is cpp/oracle's (mesh_pairs.hpp), by `bodies`; `other_libraries` counts the misses of FCL
and coal.
"""
