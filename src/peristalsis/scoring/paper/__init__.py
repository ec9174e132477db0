"""The paper as a source: its claims, the experiments they need, figures and tables, as data."""
