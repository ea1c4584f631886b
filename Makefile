# Everything runs in .venv, which the first command makes. Needed: Python 3.11 or newer, git, make.
PYTHON ?= python3
BIN := .venv/bin
SCENARIO ?= corridor

.PHONY: run test test-slow lint bench clean clean-kernels

run: .venv/run.stamp            ## one corridor episode: a table, a log and a report
	$(BIN)/crowdcosim run $(SCENARIO)

test: .venv/dev.stamp           ## the tests, but for the slow ones
	$(BIN)/python -m pytest -m "not slow"

test-slow: .venv/dev.stamp      ## the slow tests: a wheel, a cluster, other languages (needs cargo)
	$(BIN)/python -m pytest -m slow

lint: .venv/dev.stamp           ## style, types, and who imports whom
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: .venv/dev.stamp          ## speed, as ratios in one run
	for script in benchmarks/*.py; do $(BIN)/python $$script || exit 1; done

clean-kernels:                  ## compiled kernels; numba does not notice changes in what they call
	find . -name '*.nb[ic]' -not -path './.venv/*' -delete

clean: clean-kernels
	rm -rf .venv build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "crowdcosim needs Python 3.11 or newer; this is $$($(PYTHON) --version). Try: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	$(PYTHON) -m venv .venv

.venv/run.stamp: .venv/bin/python pyproject.toml constraints.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable .
	@touch $@

.venv/dev.stamp: .venv/bin/python pyproject.toml constraints.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	@touch $@ .venv/run.stamp
