"""Where the object touches its environment, and which contacts slide."""
