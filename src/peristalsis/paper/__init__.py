"""The paper's experiments scored: its claims as data, the runs they need, rules, verdicts, and the report."""
