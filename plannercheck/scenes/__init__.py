"""Scenes: obstacles, attached objects and allowed collisions, by hand or from files.

Read `scene` first (the public `Scene`, and our own format), then `contents` (obstacles, attached objects, allowed
collisions). `scene_files` reads our format, `written_scenes` writes it; `moveit_scene` reads planning scenes of MoveIt,
with the other `moveit_` modules. `motion_bench_maker` reads problem sets; `declared_states` holds the starts, goals and
samples that a scene gives for a robot.
"""
