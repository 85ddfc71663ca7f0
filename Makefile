# `make demo` runs the whole job on the shipped drive, `make check` passes what is quick, `make test` everything.
# All set up what they need in .venv first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ARGS ?=

# Two workers; each keeps to its half of the files while it can, so that what a file's tests share is made once.
PYTEST := $(BIN)/pytest -n 2 --dist worksteal

.PHONY: demo check test lint unit chromium bench format clean

demo: $(VENV)/.runtime-installed
	$(BIN)/fcw demo $(ARGS)

# Pyright has one thread only: the unit tests run beside it.
check: $(VENV)/.dev-installed
	@$(MAKE) --no-print-directory --jobs 2 lint unit

unit: $(VENV)/.dev-installed
	$(PYTEST) -m "not slow and not browser" $(ARGS)

test: check chromium
	$(PYTEST) -m "slow and not browser" $(ARGS)
	$(BIN)/pytest -m browser $(ARGS)  # a browser without a graphics card needs both cores

lint: $(VENV)/.dev-installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

# The tests of the pages drive a real Chromium; on a new machine root gets Debian's, others are told.
chromium:
	@if [ -n "$$FCW_CHROMIUM" ] || command -v chromium >/dev/null || command -v chromium-browser >/dev/null; then :; \
	elif [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
		echo "Installing Chromium for the browser tests (once)"; \
		apt-get update -qq && \
		DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium >/dev/null; \
	else echo "No Chromium, so the browser tests are skipped. For them: sudo apt-get install chromium"; fi

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
