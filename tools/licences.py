"""The licence of every distribution in this environment, as its own metadata state it."""

from __future__ import annotations

from importlib.metadata import distributions

CLASS = "License :: "


def licence(about: dict[str, list[str]]) -> str:
    """The licence that a distribution states: its expression, else its classifiers, else the first line of its text."""
    for expression in about.get("License-Expression", []):
        return expression
    classes = [text.split(" :: ")[-1] for text in about.get("Classifier", []) if text.startswith(CLASS)]
    if classes:
        return ", ".join(classes)
    return next((text.strip().splitlines()[0] for text in about.get("License", []) if text.strip()), "not stated")


if __name__ == "__main__":
    rows = set()
    for one in distributions():
        about = {name: one.metadata.get_all(name) or [] for name in ("License-Expression", "Classifier", "License")}
        rows.add((one.metadata["Name"], one.version, licence(about)))
    for name, version, words in sorted(rows, key=lambda row: row[0].lower()):
        print(f"{name:28} {version:14} {words}")
