"""What is not known exactly: ranges, the worlds within them, and an instant in such a world."""
