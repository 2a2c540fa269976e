"""Plans played back in a physics simulation (Sec. 5.3), and exported to a controller."""
