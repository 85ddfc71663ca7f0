# `make demo` runs the whole job on the shipped drive, `make test` passes the tests.
# Both set up everything they need in .venv first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ARGS ?=

.PHONY: demo test lint bench format clean

demo: $(VENV)/.runtime-installed
	$(BIN)/fcw demo $(ARGS)

test: lint
	$(BIN)/pytest $(ARGS)

lint: $(VENV)/.dev-installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

bench: $(VENV)/.runtime-installed
	$(BIN)/fcw bench $(ARGS)

format: $(VENV)/.dev-installed
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf $(VENV)

$(VENV)/.runtime-installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "fcw needs Python 3.11 or newer; found $$($(PYTHON) --version). Set PYTHON=... to another one."; exit 1; }
	@echo "Setting up $(VENV) (one to two minutes, once)"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

$(VENV)/.dev-installed: $(VENV)/.runtime-installed
	$(BIN)/python -m pip install --quiet --group dev
	@touch $@
