"""Robots: from a URDF to the poses of links.

Read `robot` first (the class that users meet), then `loading` (what it is made of), `description` (robots/<name>.yaml),
`urdf` and `srdf` (what the files say), `planning_groups` and `configurations` (which numbers drive which joints),
`forward_kinematics`, `kinematics` (the compiled kernel's joint table) and `kinematic_error` (how far its rounding can
move a point). `self_pairs`, `anchored_objects` and `carried_objects` say which bodies of the robot, and of what it
carries, are tested against each other.
"""
