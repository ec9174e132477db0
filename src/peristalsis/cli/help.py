"""What the help texts of the command line say beside its options: examples and exit codes."""

from __future__ import annotations

from .app_command import EXAMPLES as APP_EXAMPLES
from .bench_command import EXAMPLES as BENCH_EXAMPLES
from .dose_command import EXAMPLES as DOSE_EXAMPLES
from .fit_command import EXAMPLES as FIT_EXAMPLES
from .map_command import EXAMPLES as MAP_EXAMPLES
from .paper_command import EXAMPLES as PAPER_EXAMPLES
from .passes_command import EXAMPLES as PASSES_EXAMPLES
from .study_command import EXAMPLES as STUDY_EXAMPLES

EXIT_CODES = (
    "Exit codes: 0 finished, whatever the pellet did; 1 a check ran and failed; 2 bad input; "
    "3 the run diverged, or points of a batch or study have no result; "
    "4 a result could not be written; 130 interrupted."
)

EXAMPLES = {
    "": ("peristalsis list", "peristalsis run baseline", "peristalsis compare out/baseline out/reflex_only"),
    "run": (
        "peristalsis run baseline",
        "peristalsis run baseline --reading stretched --out out/stretched",
        "peristalsis run baseline --set 'pellet.viscous_friction=120 mN*s/cm' --out out/thin",
        "peristalsis run baseline --set reflex.enabled=false --set 'run.duration=1 s' --out out/short",
        "peristalsis run baseline --integrator explicit --set 'wall.surface_density=26.14 g/cm^2' "
        "--set grid.n_z_wall=100 --out out/explicit",
        "peristalsis run baseline --drug 'nifedipine 30 nM' --drug 'lubricant 0.5' --out out/treated",
        "peristalsis run --config my.toml --out out/mine --json",
        "peristalsis run --config my.toml --out out/mine --resume",
        "peristalsis run baseline --set 'run.duration=1 s' --certain --out out/sure",
    ),
    "list": ("peristalsis list", "peristalsis list cells", "peristalsis list laws --json", "peristalsis list drugs"),
    "show": (
        "peristalsis show baseline",
        "peristalsis show baseline pellet --reading printed",
        "peristalsis show segmentation --set 'rings.period=4 s' --toml",
    ),
    "schema": ("peristalsis schema",),
    "validate": ("peristalsis validate my.toml",),
    "cite": ("peristalsis cite baseline", "peristalsis cite out/baseline"),
    "plot": (
        "peristalsis plot out/baseline",
        "peristalsis plot out/baseline overview --format pdf --format svg",
    ),
    "film": ("peristalsis film out/baseline", "peristalsis film out/baseline --out baseline.gif"),
    "scene": ("peristalsis scene out/baseline", "peristalsis scene out/baseline --time '1.2 s' --out squeeze.png"),
    "export": (
        "peristalsis export out/baseline",
        "peristalsis export out/baseline --out tables",
        "peristalsis export out/baseline --format vtk",
    ),
    "bundle": (
        "peristalsis bundle out/baseline",
        "peristalsis bundle out/baseline --out b.zip --agent 'A. Researcher' --license https://spdx.org/licenses/CC-BY-4.0",
    ),
    "compare": (
        "peristalsis compare out/baseline out/thin",
        "peristalsis compare out/baseline out/thin out/reflex_only --out out/compared",
    ),
    "check": ("peristalsis check out/baseline", "peristalsis check out/baseline out/thin --quarantine"),
    "dose-response": DOSE_EXAMPLES,
    "app": APP_EXAMPLES,
    "fit": FIT_EXAMPLES,
    "map": MAP_EXAMPLES,
    "paper": PAPER_EXAMPLES,
    "passes": PASSES_EXAMPLES,
    **STUDY_EXAMPLES,
    "bench": BENCH_EXAMPLES,
    "warm-up": ("peristalsis warm-up", "peristalsis warm-up --set tissue.cell=hodgkin_huxley"),
    "version": ("peristalsis version",),
}
"""Examples of the help texts, by command; the tests run them."""

WITHOUT_WORDS = ("--help",)
"""What an empty command line stands for."""


def epilog(command: str) -> str:
    """Examples, one a line: the mark keeps the lines as they are."""
    examples = "\n".join(("\b", "Examples:", *EXAMPLES[command]))
    return f"{examples}\n\n{EXIT_CODES}" if command in ("", "run") else examples
