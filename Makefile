# Every target works in a fresh clone: it makes its own virtual environment from pyproject.toml first.
PYTHON ?= $(firstword $(shell command -v python3.11 python3.12 python3.13 python3))
VENV ?= .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: demo test lint docs old-hdf5 bench stability slow clean

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

# The newest h5py whose HDF5 is 1.14, and the numpy of its time, read what today's writes.
OLD_HDF5 := build/old-hdf5
old-hdf5: $(READY)
	$(BIN)/rig run protocols/nulls.yaml --set repeats=1 --set acquire.record=4 --out build/for-old-hdf5 --force >/dev/null || test $$? = 1
	$(BIN)/python -m venv $(OLD_HDF5)
	$(OLD_HDF5)/bin/pip install --quiet --disable-pip-version-check --only-binary :all: 'h5py>=3.11,<3.15' 'numpy<2.3'
	$(OLD_HDF5)/bin/python tests/daq/read_with_old_hdf5.py tests/data/session-v1.h5 build/for-old-hdf5/session.h5

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
	@touch $(READY)
