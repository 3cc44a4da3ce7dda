"""Robots: from a URDF to the poses of links.

Read `robot` first (the public `Robot`), then `loading` (its parts), `description` (robots/<name>.yaml), `urdf` and
`srdf` (the contents of these files), `planning_groups` and `configurations` (which numbers drive which joints),
`forward_kinematics`, `kinematics` (the compiled kernel's joint table) and `kinematic_error` (how far its rounding can
move a point). `self_pairs` and `carried_objects` choose the bodies of the robot and of its carried objects that are
tested against each other; `objects_in_frames` places objects. `link_geometry` takes meshes as hulls, pieces or solids,
and `geometry_choices` makes a robot of each to compare them. `robot_memory` keeps what checkers compute of a robot
alone.
"""
