# `make demo` runs the whole job on the shipped drive, `make check` passes what is quick, `make test` everything.
# All set up what they need in .venv first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ARGS ?=

# Four workers; each keeps to its part of the files while it can, so that what a file's tests share is made once.
# While one or two wait for a browser the others work.
PYTEST := $(BIN)/pytest -n 4 --dist worksteal
KERNELS := fcw/kernels/__pycache__/.compiled

# Where the shell forbids bytecode, every worker and every program that a test starts would compile all anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo check test lint unit whole browser chromium bench soak format clean

demo: $(VENV)/.runtime-installed
	$(BIN)/fcw demo $(ARGS)

# The tests run beside Pyright. More threads of it would each infer the same types again: twice the processor time.
check: $(VENV)/.dev-installed $(KERNELS)
	@$(MAKE) --no-print-directory --jobs 2 lint unit

test: $(VENV)/.dev-installed $(KERNELS) chromium
	@$(MAKE) --no-print-directory --jobs 2 lint whole

unit: $(VENV)/.dev-installed $(KERNELS)
	$(PYTEST) -m "not slow and not browser" --hypothesis-profile quick $(ARGS)

whole: $(VENV)/.dev-installed $(KERNELS)
	$(PYTEST) $(ARGS)

browser: $(VENV)/.dev-installed $(KERNELS)
	$(BIN)/pytest -m browser $(ARGS)

# Kept beside the sources, and used by all processes until a source of theirs changes.
$(KERNELS): $(shell find fcw/kernels fcw/detection fcw/simulation -name '*.py') | $(VENV)/.dev-installed
	@echo "Compiling the kernels (one to two minutes, once)"
	@$(BIN)/python tests/kernels/compile_kernels.py
	@mkdir -p $(@D)
	@touch $@

# Pyright makes many short-lived objects: with room for them it takes a seventh less processor time.
lint: $(VENV)/.dev-installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	NODE_OPTIONS=--max-semi-space-size=128 $(BIN)/pyright

# The tests of the pages drive a real Chromium; on a new machine root gets Debian's, others are told. Its headless
# shell is enough and the quickest; any other Chromium that is there is taken as well.
INSTALL := DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends
chromium:
	@if [ -n "$$FCW_CHROMIUM" ]; then exit; fi; \
	for name in chromium-headless-shell chromium chromium-browser; do command -v $$name >/dev/null && exit; done; \
	if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
		echo "Installing Chromium for the browser tests (once)"; \
		apt-get update -qq && { $(INSTALL) chromium-headless-shell || $(INSTALL) chromium; } >/dev/null; \
	else echo "No Chromium, so the browser tests are skipped. For them: apt-get install chromium-headless-shell"; fi

bench: $(VENV)/.runtime-installed
	$(BIN)/fcw bench $(ARGS)

# Faults at ten moments of every command, the fuzz corpus for ten minutes a format, and ten hours of drive.
soak: $(VENV)/.dev-installed $(KERNELS)
	$(BIN)/python tests/fuzz/faults.py --moments $(or $(MOMENTS),10)
	$(BIN)/python tests/fuzz/soak.py --seconds $(or $(SECONDS_EACH),600) --each --drive-hours $(or $(HOURS),10)

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
