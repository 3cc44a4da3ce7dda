"""Scenes: obstacles, attached objects and allowed collisions, by hand or from files.

Read `scene` first (the class that users meet, and our own format), then `scene_files` (which reads and writes that),
`moveit_scene` (planning scenes of MoveIt, by the other `moveit_` modules) and `motion_bench_maker` (its problem sets).
`declared_states` are the starts, goals and samples that a scene gives for a robot.
"""
