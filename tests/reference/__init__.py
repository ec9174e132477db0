"""Two implementations of docs/equations.md that share no code with the package, and their agreement with it."""
