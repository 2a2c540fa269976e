"""The robot hand behind the fingertips: its file, kinematics, collisions; it plans nothing."""
