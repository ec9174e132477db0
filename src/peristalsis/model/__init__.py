"""The only place where two kinds of physics meet: state, equilibrium and the coupled step."""
