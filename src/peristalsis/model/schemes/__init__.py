"""What a step asks of the grid of the wall: of one column, or of the whole surface."""
