# Needs Python >= 3.11 and make; everything else is installed into .venv by the first target that needs it.
# Another interpreter: make PYTHON=python3.13 test

PYTHON ?= python3
BIN := .venv/bin
# An environment with a pip of today; the package alone, as a user needs it; with what the tests need; what lints it.
ENVIRONMENT := .venv/environment
PACKAGE := .venv/package
INSTALLED := .venv/installed
LINTERS := .venv/linters
# pip would compile every file of every package, one after the other: that took a third of its time. Files are compiled
# where they are first imported, by every worker of the tests; those that all import, which are many, only once, while
# pip installs the rest.
INSTALL := install -qq --no-compile --disable-pip-version-check --no-warn-conflicts -c constraints.txt
PIP_INSTALL := $(BIN)/python -m pip $(INSTALL)
# Large wheels that the tests alone need: unpacked on the second core while the package and what it needs are installed.
LARGE := .venv/large
LARGE_WHEELS := debugpy ipython jedi mujoco-core playwright z3-solver
COMPILE := $(BIN)/python -m compileall -q -x /tests/
COMPILED := symbolic analysis proofs reports \
    $(addprefix .venv/lib/python*/site-packages/,cvxpy fontTools jinja2 matplotlib numpy pydantic rich scipy sympy typer)
TOOLS := .venv/tools
# What some tests use beside Python; they say so when they are skipped without it.
TOOL_PACKAGES := fonts-dejavu-core texlive-latex-base
# Chromium without windows draws the same pages in half the processor time; where there is no package of it, the other.
BROWSERS := chromium-headless-shell chromium
TOOL_SECONDS := 300
REPORT := build/four-wheel.html
# For two cores: every further worker imports everything once more. On a larger machine: make WORKERS=8 test
WORKERS ?= 2
# `make lowest`: what touches each library, against its oldest version that pyproject.toml allows.
# Needs Python 3.11 or 3.12 (make PYTHON=python3.12 lowest): for later ones these versions were never built.
LOWEST := .venv-lowest
# `make release-check`: those of the support window (docs/stability.md) that are there.
PYTHONS := python3.11 python3.12 python3.13 python3.14
LOWEST_TESTS := tests/symbolic tests/analysis/test_minimizers.py tests/analysis/test_filippov.py \
    tests/analysis/test_trajectory.py tests/analysis/test_dynamics.py tests/proofs/test_theorem4.py \
    tests/proofs/test_translation.py tests/proofs/test_systems.py tests/proofs/test_ellipse.py \
    tests/proofs/test_driven_feedback.py tests/reports/interface tests/reports/test_cli.py \
    tests/reports/test_derivation.py tests/reports/test_html.py tests/reports/test_report_commands.py tests/test_api.py

# Bytecode is kept, whatever the shell says, but not beside the sources: tests and studies start many processes.
unexport PYTHONDONTWRITEBYTECODE
export PYTHONPYCACHEPREFIX := $(CURDIR)/.venv/bytecode

# Matrices are too small for threads of BLAS, which only wait for each other; commands ask for one themselves.
export OPENBLAS_NUM_THREADS ?= 1

# The last digits of paths, and with them their steps, depend on which kernels of OpenBLAS and NumPy a processor has:
# tests and the golden matrix compare with those of AVX2.
ifneq ($(findstring avx512f,$(shell grep -m1 flags /proc/cpuinfo 2> /dev/null)),)
export OPENBLAS_CORETYPE ?= Haswell
export NPY_DISABLE_CPU_FEATURES ?= X86_V4 AVX512_ICL AVX512_SPR
# The oldest NumPy has other names for the same kernels, and warns of names that it does not know: an error in tests.
lowest: export NPY_DISABLE_CPU_FEATURES := AVX512F AVX512_SKX
endif

.DEFAULT_GOAL := help
.PHONY: help demo test golden lowest tools lint format measure bench precision evidence gallery release-check site clean

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-13s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

demo: $(PACKAGE) ## check the four-wheel array under every contact rule and write its derivation report
	$(BIN)/nonsmooth check four-wheel
	$(BIN)/nonsmooth check four-wheel-side
	@# The theorem is about rule nearest: under the others it does not hold (exit status 1), and that is shown.
	$(BIN)/nonsmooth check four-wheel --rule all || test $$? -eq 1
	@mkdir -p $(dir $(REPORT))
	$(BIN)/nonsmooth derive four-wheel -o $(REPORT)
	@echo "The derivation report is in $(REPORT)"

test: $(INSTALLED) $(TOOLS) ## run the tests
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal --ignore=tests/benchmarks -m "not thorough" -q

golden: $(INSTALLED) ## compare what commands and calls say with what they said before (tests/golden; some minutes)
	$(BIN)/python -m tests.golden

lowest: $(LOWEST)/installed ## run a part of the tests with the oldest versions of all libraries
	$(LOWEST)/bin/python -m pytest -n 2 --dist worksteal -m "not thorough" -q $(LOWEST_TESTS)

tools: ## try to install Chromium and LaTeX, in which tests open the reports (Debian and Ubuntu, as root)
	@rm -f $(TOOLS)
	@$(MAKE) --no-print-directory $(TOOLS)

lint: $(INSTALLED) $(LINTERS) ## ruff and mypy, changing nothing
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy tests

format: $(LINTERS) ## format the code and mend what ruff can mend
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

measure: $(INSTALLED) ## size of the product beside the last row of tests/measure.csv; ROW="what was done" appends one
	@$(BIN)/python -m tests.measure $(if $(ROW),--row "$$ROW")

bench: $(INSTALLED) ## run what `make test` leaves out and the comparisons in tests/benchmarks; write docs/speed.md
	@$(PIP_INSTALL) --no-build-isolation -e '.[bench]'
	$(BIN)/python -m pytest -n 2 --dist worksteal --ignore=tests/benchmarks -m "thorough or hypothesis" --hypothesis-profile all -q
	$(BIN)/python -m pytest tests/benchmarks
	$(BIN)/python -m tests.speed_page docs

precision: $(PACKAGE) ## measure error against run time and write docs/precision.md (some minutes)
	$(BIN)/python -m tests.precision_page docs

evidence: $(INSTALLED) ## compare with data that others made and write docs/evidence.md (some minutes)
	$(BIN)/python -m tests.evidence.page docs

gallery: $(PACKAGE) ## rebuild docs/gallery.md and the reports in it
	$(BIN)/python -m tests.gallery docs

release-check: $(PACKAGE) ## build wheel and source distribution, install each for every Python that is there, and check
	@rm -rf build/release && mkdir -p build/release
	@$(PIP_INSTALL) build
	@$(BIN)/python -m build --no-isolation --outdir build/release . > build/release/build.log 2>&1
	@for python in $(PYTHONS); do $$python -c "import venv" > /dev/null 2>&1 || { echo "$$python: not there"; continue; }; \
	    for file in build/release/*.whl build/release/*.tar.gz; do \
	        $$python -m venv --clear build/release/venv && \
	        build/release/venv/bin/python -m pip install -qq --disable-pip-version-check -c constraints.txt "$$file" && \
	        (cd build/release && venv/bin/nonsmooth check four-wheel --certificate four.json > check.log && \
	            venv/bin/nonsmooth verify four.json > verify.log && \
	            venv/bin/python -c "import nonsmooth as ns; ns.load('relay-oscillator').check()") && \
	        echo "$$python: $$file installs, checks and verifies" || exit 1; \
	    done; done

site: $(PACKAGE) ## build the site of the documents into build/site, every link checked
	@$(PIP_INSTALL) --no-build-isolation -e '.[site]'
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "The site is in build/site: $(BIN)/python -m http.server -d build/site"

clean: ## remove all that make has built, .venv included
	rm -rf .venv $(LOWEST) build dist nonsmooth.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find symbolic analysis proofs reports tests -name __pycache__ -type d -prune -exec rm -rf {} +

# Tried once, for a limited time; without them the tests that need them are skipped, and say so.
$(TOOLS): | $(INSTALLED)
	@if (command -v chromium-headless-shell || command -v chromium) > /dev/null && command -v pdflatex > /dev/null; then :; \
	elif [ "$$(id -u)" = 0 ] && command -v apt-get > /dev/null; then \
	    echo "Installing Chromium and LaTeX for the tests that open reports (at most $(TOOL_SECONDS) s) ..."; \
	    timeout $(TOOL_SECONDS) sh -c 'export DEBIAN_FRONTEND=noninteractive; \
	        install="apt-get install -y -qq --no-install-recommends"; \
	        apt-get update -qq; $$install $(TOOL_PACKAGES); \
	        for browser in $(BROWSERS); do $$install $$browser && exit; done; exit 1' > /dev/null 2>&1 \
	        || echo "They could not be installed: the tests that need them will be skipped."; \
	else \
	    echo "Chromium or pdflatex is missing, so the tests that open reports are skipped; to run them," \
	         "as root: apt-get install $(TOOL_PACKAGES) $(lastword $(BROWSERS))"; \
	fi
	@touch $@

$(INSTALLED): pyproject.toml constraints.txt
	@$(MAKE) --no-print-directory -j2 $(PACKAGE) $(LARGE)
	@echo "Installing what the tests need into .venv (a minute, without a word) ..."
	@$(COMPILE) $(COMPILED) & $(PIP_INSTALL) --no-build-isolation -e '.[test]' && wait
	@touch $@

$(LOWEST)/installed: pyproject.toml constraints-lowest.txt
	@$(PYTHON) -m venv $(LOWEST)
	@$(LOWEST)/bin/python -m pip install -qq --disable-pip-version-check -c constraints-lowest.txt setuptools wheel
	@$(LOWEST)/bin/python -m pip install -qq --disable-pip-version-check -c constraints-lowest.txt \
	    --no-build-isolation -e . pytest pytest-xdist hypothesis
	@touch $@

$(LINTERS): $(PACKAGE)
	@$(PIP_INSTALL) --no-build-isolation -e '.[lint]'
	@touch $@

$(LARGE): $(ENVIRONMENT)
	@$(PIP_INSTALL) --no-deps $(LARGE_WHEELS)
	@touch $@

$(PACKAGE): $(ENVIRONMENT)
	@$(PIP_INSTALL) --no-build-isolation -e .
	@touch $@

$(ENVIRONMENT): pyproject.toml constraints.txt
	@command -v $(PYTHON) > /dev/null || { \
	    echo "error: $(PYTHON) was not found; install Python >= 3.11, or name one: make PYTHON=python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	    echo "error: required Python >= 3.11, received $$($(PYTHON) --version 2>&1)" \
	         "from $(PYTHON); name a newer one: make PYTHON=python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2> /dev/null || { \
	    echo "error: this Python cannot make virtual environments (venv or ensurepip is missing);" \
	         "on Debian and Ubuntu: apt install python3-venv" >&2; exit 1; }
	@echo "Installing into .venv (only now, and when pyproject.toml or constraints.txt change): a minute or two, without a word ..."
	@# Python 3.11 brings a pip that takes twice as long to choose versions.  Where a pip is there already it installs a
	@# newer one right away, which takes a third of the time that it takes to put the old one there first.
	@$(PYTHON) -m venv --without-pip .venv
	@$(PYTHON) -m pip --python $(BIN)/python $(INSTALL) pip setuptools wheel > /dev/null 2>&1 || \
	    { $(PYTHON) -m venv .venv && { $(PIP_INSTALL) -U pip setuptools wheel || $(PIP_INSTALL) setuptools wheel; }; }
	@touch $@
