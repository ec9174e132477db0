"""Random configurations, run and judged: `python -m robustness` from the root of the repository; see docs/robustness.md."""
