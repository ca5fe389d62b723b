# `make demo` runs the main job, `make test` the tests, `make docs` builds the site in site/; each
# makes its own .venv first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT := out/demo
SITE := site

# The tests start hundreds of processes: without bytecode each compiles the package anew.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: demo test lint docs check clean

demo: $(VENV)/.simtip
	rm -rf $(OUT)
	$(BIN)/simtip run scenes/01_single_tip.yaml -o $(OUT)

test: $(VENV)/.simtip-test
	$(BIN)/pytest -n auto --dist worksteal

lint: $(VENV)/.simtip-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# What mkdocs says of its own future is no fault of a page.
docs: $(VENV)/.simtip-test
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet --site-dir $(SITE)

check: lint docs test

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo 'simtip needs Python 3.11 or newer; run make PYTHON=python3.11 (or newer) ...' >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.simtip: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	@touch $@

$(VENV)/.simtip-test: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test]'
	@touch $@ $(VENV)/.simtip

clean:
	rm -rf $(VENV) out $(SITE)
