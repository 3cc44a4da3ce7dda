"""Scenes: obstacles, attached objects and allowed collisions, by hand or from files.

Read `scene` first (the class that users meet, and our own format), then `contents` (what it holds), which are filled by
`scene_files` (our format) and `moveit_scene` (planning scenes of MoveIt, by the other `moveit_` modules).
`motion_bench_maker` reads problem sets; `declared_states` are starts, goals and samples that a scene gives for a robot.
"""
