"""The rigid pellet: its shape, contact with the wall, friction and motion."""
