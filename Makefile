# make demo | test | test-app | lint | coverage | verify | matrix | mutants | bench | robust | docs | audit | wheel | clean
#
# Everything runs in .venv, made once and made again only when pyproject.toml or constraints.txt change.
# Another interpreter: make demo PYTHON=python3.12

PYTHON ?= python3

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

export MPLBACKEND := Agg
# One thread a run: reproducible to the bit, and runs side by side do not fight for the cores.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1

# .ready is written last, with the place and the interpreter. An environment that lacks it was interrupted, one
# that names another place was moved here, and both are made anew; so is one asked for with another PYTHON.
made_in := $(shell test -x $(BIN)/python && sed -n 1p $(READY) 2>/dev/null)
made_by := $(shell test -x $(BIN)/python && sed -n 2p $(READY) 2>/dev/null)
remake :=
ifneq "$(made_in)" "$(CURDIR)"
remake := yes
else ifneq "$(origin PYTHON)" "file"
ifneq "$(made_by)" "$(PYTHON)"
remake := yes
endif
endif

.PHONY: help demo test test-app lint coverage verify matrix mutants bench robust docs audit wheel clean FORCE
.DELETE_ON_ERROR:

help:
	@echo "make demo     run the baseline experiment and draw its pictures into out/baseline"
	@echo "make test     the quick tests"
	@echo "make test-app the page of the app in the system's Chromium, which it installs where it may"
	@echo "make lint     ruff and mypy"
	@echo "make coverage the quick tests, and which branches they reach"
	@echo "make verify   the quick tests, every exact problem (writes docs/verification), the slow tests"
	@echo "make matrix   every Python that is found with the newest and the lowest libraries (goes on where it was stopped)"
	@echo "make mutants  small errors put into the kernels one at a time: does the suite notice? (hours)"
	@echo "make bench    what runs cost (writes docs/benchmarks; goes on where it was stopped; half an hour)"
	@echo "make robust   440 random configurations, run and judged (goes on where it was stopped; three quarters of an hour on"
	@echo "              two cores); make robust ARGS='--quick --workers 2' for every day; ARGS=--help says the rest"
	@echo "make docs     this documentation as a site, its notebooks carried out, into out/site"
	@echo "make audit    known vulnerabilities and licences of the libraries in the environment (asks the net)"
	@echo "make wheel    a wheel with compiled kernels, into dist (some minutes): a first run then compiles nothing"
	@echo "make clean    remove .venv, caches and builds (results in out/ stay)"

demo: $(READY)
	@$(BIN)/peristalsis run baseline --out out/baseline --overwrite
	@echo "Pictures:"
	@find out/baseline -type f \( -name '*.png' -o -name '*.gif' -o -name '*.mp4' \) | LC_ALL=C sort | sed 's/^/  /'

# Two workers take the tests by turns. Kernels are compiled beforehand, or each of them would compile all of them.
TEST_WORKERS ?= 2

test: $(READY)
	@$(BIN)/peristalsis warm-up --surface
	@$(BIN)/python -m pytest -q -n $(TEST_WORKERS) --dist worksteal

# Chromium is the system's: Playwright drives it and brings none of its own.
test-app: $(READY)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt playwright
	@command -v chromium >/dev/null 2>&1 || command -v google-chrome >/dev/null 2>&1 || \
	  { command -v apt-get >/dev/null 2>&1 && test "$$(id -u)" = 0 && apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium; } || \
	  { echo "make: no Chromium here; install it as root: apt-get install chromium" >&2; exit 1; }
	@$(BIN)/peristalsis warm-up
	@$(BIN)/python -m pytest -q -m "browser" tests/app

lint: $(READY)
	$(BIN)/python -m ruff check .
	$(BIN)/python -m ruff format --check .
	$(BIN)/python -m mypy

# Everything that keeps results and reads input must be reached by the tests; of the rest nineteen branches in twenty.
KEPT := $(foreach name,storing/disk storing/manifest storing/store storing/packing storing/checkpoint inputs/config/* inputs/consistency many/plan,*/peristalsis/$(name).py)
comma := ,
space := $(subst x, ,x)

coverage: $(READY)
	@rm -f .coverage .coverage.*
	@$(BIN)/python -m coverage run -m pytest -q
	@$(BIN)/python -m coverage combine -q
	@mkdir -p out && $(BIN)/python -m coverage json -q -o out/coverage.json
	@$(BIN)/python -m coverage report --skip-covered --fail-under=95
	@$(BIN)/python -m coverage report --fail-under=100 --include='$(subst $(space),$(comma),$(strip $(KEPT)))'

verify: test
	@$(BIN)/python -m verification --full --out docs/verification
	@$(BIN)/python -m pytest -q -m "slow and not problem"

matrix: $(READY)
	@$(BIN)/python tools/matrix.py

mutants: $(READY)
	@cd evidence && ../$(BIN)/python mutants.py

bench: $(READY)
	@$(BIN)/python -m benchmarks --full --out docs/benchmarks

ARGS ?= --workers 2 --halving 20
robust: $(READY)
	@$(BIN)/python -m robustness $(ARGS)

# A warning is an error, and so is a link within the site that leads nowhere.
docs: $(READY)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[docs]'
	@$(BIN)/peristalsis warm-up
	@rm -rf out/site
	@$(BIN)/python -m sphinx -q -W --keep-going -b html -c docs/site -d out/site-pages docs out/site
	@$(BIN)/python docs/site/links.py out/site

audit: $(READY)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt pip-audit
	@$(BIN)/python tools/licences.py
	@$(BIN)/python tools/audit.py

wheel: $(READY)
	@$(BIN)/python tools/wheel.py --surface --explicit

clean:
	rm -rf $(VENV) build dist .coverage .coverage.* .mypy_cache .pytest_cache .ruff_cache .hypothesis src/*.egg-info
	find src tests verification benchmarks examples -type d -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true

$(READY): pyproject.toml constraints.txt $(if $(remake),FORCE)
	@command -v "$(PYTHON)" >/dev/null 2>&1 || { \
	  echo "make: no interpreter named '$(PYTHON)'; install Python 3.11 or newer, or name one: make PYTHON=python3.12" >&2; \
	  exit 1; }
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "make: peristalsis needs Python 3.11 or newer and '$(PYTHON)' is $$("$(PYTHON)" -V 2>&1 | head -n 1); name another: make PYTHON=python3.12" >&2; \
	  exit 1; }
	@"$(PYTHON)" -c 'import venv, ensurepip' 2>/dev/null || { \
	  echo "make: '$(PYTHON)' cannot make environments: install the Debian package python3-venv (or $$("$(PYTHON)" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')), then run make again" >&2; \
	  exit 1; }
	@if [ -n "$(remake)" ]; then \
	  echo "Making the environment in $(VENV) (once, about a minute)"; \
	  rm -rf $(VENV) && "$(PYTHON)" -m venv $(VENV); \
	else \
	  echo "Bringing the environment in $(VENV) up to date"; \
	  rm -f $(READY); \
	fi
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@printf '%s\n%s\n' '$(CURDIR)' '$(PYTHON)' > $(READY)

FORCE:
