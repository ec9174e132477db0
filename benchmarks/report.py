"""From findings to pages: a first page with every figure, a page a section, figures.csv and the plots."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from verification.prose import wrapped

from . import machine
from .ledger import Ledger
from .section import Effort, Figure, Findings, Plot, Section, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

FINDINGS = "findings of "
COLUMNS = ("section", "what", "measured", "aimed at", "met", "note")


def rows(section: Section, findings: Findings) -> list[tuple[str, ...]]:
    """Lines of the first page, in the order of COLUMNS."""
    return [(section.name, one.what, _measured(one), _aimed(one), _met(one), one.note) for one in findings.figures]


def number(value: Any) -> str:
    """A cell of a table: three significant digits, and a dash for what there is not."""
    if value is None:
        return "–"
    if isinstance(value, bool) or not isinstance(value, float):
        return str(value)
    if value == 0.0 or 1e-3 <= abs(value) < 1e5:
        text = f"{value:.3g}"
        return f"{value:.0f}" if "e" in text else text
    return f"{value:.2e}"


def _measured(one: Figure) -> str:
    return "not measured" if one.value is None else f"{number(one.value)}{_unit(one)}"


def _aimed(one: Figure) -> str:
    return one.aim if one.aim == "–" else f"{one.aim}{_unit(one)}"


def _unit(one: Figure) -> str:
    return f" {one.unit}" if one.unit else ""


def _met(one: Figure) -> str:
    return {True: "yes", False: "**no**", None: "–"}[one.met]


def collected(ledger: Ledger, effort: Effort, sections: Mapping[str, Section]) -> dict[str, Findings]:
    """The findings kept of this code, machine and effort, in the order of the page."""
    kept = ledger.current(effort)
    return {name: Findings.of(kept[f"{FINDINGS}{name}"]["value"]) for name in sections if f"{FINDINGS}{name}" in kept}


def pages(ledger: Ledger, effort: Effort, sections: Mapping[str, Section]) -> dict[str, str]:
    """File name to text of everything that is written beside the plots."""
    found = collected(ledger, effort, sections)
    written = {"README.md": _index(ledger, effort, sections, found), "figures.csv": _csv(sections, found)}
    for name, findings in found.items():
        written[f"{name}.md"] = _page(sections[name], findings)
    return written


def write(ledger: Ledger, effort: Effort, sections: Mapping[str, Section], folder: Path) -> list[Path]:
    """Write all pages and plots into a folder; other files there stay. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, text in pages(ledger, effort, sections).items():
        file = folder / name
        file.write_text(wrapped(text) if file.suffix == ".md" else text, encoding="utf-8")
        files.append(file)
    for findings in collected(ledger, effort, sections).values():
        for plot in findings.plots:
            file = folder / f"{plot.name}.png"
            draw(plot).savefig(file)
            files.append(file)
    return files


def table(head: Sequence[str], lines: Sequence[Sequence[Any]]) -> str:
    """A Markdown table."""

    def line(cells: Sequence[Any]) -> str:
        return "| " + " | ".join(number(cell).replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"

    return "\n".join([line(head), "|" + "---|" * len(head), *(line(one) for one in lines)])


def _index(ledger: Ledger, effort: Effort, sections: Mapping[str, Section], found: Mapping[str, Findings]) -> str:
    about = machine.about()
    kept = ledger.current(effort)
    days = sorted(str(entry["measured"]) for entry in kept.values())
    loads = [float(entry["load"]) for entry in kept.values()]
    when = f"{days[0]} to {days[-1]} (UTC)" if days else "never"
    lines = [line for name, findings in found.items() for line in rows(sections[name], findings)]
    missing = [name for name in sections if name not in found]
    text = [
        "# Benchmarks",
        "What a run costs, measured by `python -m benchmarks` (`make bench`); do not edit. A number of seconds belongs "
        "to the "
        "machine below and to how busy it was; ratios, exponents and costs per node and step were taken within one "
        "run, "
        "in turns, and carry further. *cpu* is time of the processor, *wall* time on the clock; both are medians.",
        table(("", ""), [(key, value) for key, value in about.items()]),
        f"Effort: {effort}. Measured {when}, with {_span(loads)} processes wanting to run on {about['cores']} "
        "processors.",
        "## Figures",
        table(COLUMNS, lines),
        "[figures.csv](figures.csv) · [measurements.json](measurements.json): every measurement with its time and load",
    ]
    if missing:
        text.append(f"Not run: {', '.join(missing)} (`python -m benchmarks {missing[0]}`).")
    text.append("## Sections")
    text.append("\n".join(f"- [{sections[name].title}]({name}.md)" for name in found))
    return "\n\n".join(text) + "\n"


def _span(loads: Sequence[float]) -> str:
    if not loads or min(loads) < 0.0:
        return "an unknown number of"
    return f"{min(loads):.1f} to {max(loads):.1f}"


def _page(section: Section, findings: Findings) -> str:
    text = [
        f"# {section.title}",
        "[All figures](README.md). Made by `make bench`; do not edit.",
        section.about,
    ]
    lines = [line[1:] for line in rows(section, findings)]
    if lines:
        text.append(table(COLUMNS[1:], lines))
    for plot in findings.plots:
        text.append(f"![{plot.title}]({plot.name}.png)")
    for one in findings.tables:
        text.append(_captioned(one))
    text += findings.notes
    return "\n\n".join(text) + "\n"


def _captioned(one: Table) -> str:
    return f"{one.caption}\n\n{table(one.head, one.rows)}"


def _csv(sections: Mapping[str, Section], found: Mapping[str, Findings]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(("section", "what", "value", "unit", "aim", "met", "note"))
    for name, findings in found.items():
        for one in findings.figures:
            value = "" if one.value is None else repr(float(one.value))
            met = "" if one.met is None else one.met
            writer.writerow((sections[name].name, one.what, value, one.unit, one.aim, met, one.note))
    return out.getvalue()


COLOURS = ("BLUE", "VERMILION", "GREEN", "ORANGE", "PURPLE", "SKY", "GREY", "BLACK")


def draw(plot: Plot) -> Canvas:
    """A plot with logarithmic axes in the style of every figure."""
    from matplotlib.figure import Figure as Canvas

    from peristalsis.plots import style

    with style.applied():
        canvas = Canvas(figsize=(style.WIDTH, 0.62 * style.WIDTH), dpi=style.DPI, layout="constrained")
        axes = canvas.add_subplot()
        for index, line in enumerate(plot.lines):
            colour = style.BLACK if line.marker == "*" else getattr(style, COLOURS[index % len(COLOURS)])
            size = 15 if line.marker == "*" else 5
            axes.plot(
                line.x,
                line.y,
                line.style or "none",
                marker=line.marker or "none",
                color=colour,
                label=line.label,
                markersize=size,
                zorder=3 if line.marker == "*" else 2,
            )
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel(plot.x)
        axes.set_ylabel(plot.y)
        axes.grid(visible=True, which="major", linewidth=0.4, alpha=0.5)
        axes.legend()
        canvas.suptitle(plot.title, x=0.01, ha="left")
        canvas.canvas.draw()  # while the settings hold
    return canvas
