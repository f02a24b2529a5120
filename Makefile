# Every target works in a fresh clone: it makes its own virtual environment from pyproject.toml first.
PYTHON ?= $(firstword $(shell command -v python3.11 python3.12 python3.13 python3))
VENV ?= .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: demo test lint docs bench stability slow clean

demo: $(READY)
	$(BIN)/rig run protocols/fill_rate.yaml --out sessions/fill_rate --force

test: $(READY)
	$(BIN)/python -m pytest -n 2

slow: $(READY)
	$(BIN)/python -m pytest -n 2 -m slow

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(READY)
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs build/docs

bench: $(READY)
	$(BIN)/rig bench

stability: $(READY)
	$(BIN)/python -m benchmarks.stability

clean:
	rm -rf $(VENV) sessions build *.egg-info

$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed, found " + sys.version)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -e '.[dev,docs]'
	$(BIN)/python -m compileall -q rig daq analysis  # as an installer does with what it copies: ours is linked
	@touch $(READY)
