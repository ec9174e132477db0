"""The explicit scheme of the paper, Eqs. (53)-(57): its loop, its limits, and what it keeps between wall steps."""
