"""Plans as trajectories that are proved as they will be executed.

Read `rounded_path` first (corners become curves), then `time_law` (TOPP-RA, and even samples of it), `timed_section`
(points that keep the limits) and `time_path`, which shortens blends until all is proved.
"""
