"""Random configurations, run and judged: `python -m robustness` in the root of the repository (docs/robustness.md)."""
