"""The object's degrees of freedom: from coordinates q to poses and velocities."""
