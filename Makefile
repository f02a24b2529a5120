# Every target works in a fresh clone: it makes its own virtual environment from pyproject.toml and lock.txt first.
# The Pythons that lock.txt is made for; a command that is there but does not run (a version manager's) is passed over.
PYTHONS := 3.11 3.12 3.13 3.14
PYTHON ?= $(firstword $(foreach p,python3.11 python3.12 python3.13 python3.14 python3,$(shell $p -c 'print("$p")' 2>/dev/null)))
VENV ?= .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: demo test lint docs dist old-hdf5 dem bench stability slow lock lowest newest clean

demo: $(READY)
	$(BIN)/rig run protocols/fill_rate.yaml --out sessions/fill_rate --force

test: $(READY)
	$(BIN)/python -m pytest -n 2 --dist worksteal

slow: $(READY)
	$(BIN)/python -m pytest -n 2 --dist worksteal -m slow

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(READY)
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs build/docs

dist: $(READY)
	rm -rf build/dist && mkdir -p build
	$(LOCKED) $(BIN)/python -m build --outdir build/dist . > build/dist.log 2>&1 || { cat build/dist.log; exit 1; }
	$(BIN)/python -m twine check --strict build/dist/*
	$(BIN)/python .ci/wheel_content build/dist/*.whl

# An HDF5 before 2.0 reads what today's writes: by the versions of its own lock, the same on any day.
OLD_HDF5 := build/old-hdf5
old-hdf5: $(READY)
	$(BIN)/rig run protocols/nulls.yaml --set repeats=1 --set acquire.record=4 --out build/for-old-hdf5 --force >/dev/null || test $$? = 1
	$(BIN)/python -m venv $(OLD_HDF5)
	$(OLD_HDF5)/bin/pip install --quiet --disable-pip-version-check --only-binary :all: -r .ci/old-hdf5.txt
	$(OLD_HDF5)/bin/python tests/daq/read_with_old_hdf5.py tests/data/session-v1.h5 build/for-old-hdf5/session.h5

dem:
	.ci/dem

bench: $(READY)
	$(BIN)/rig bench

stability: $(READY)
	$(BIN)/python -m rig.benchmarks.stability

lock:
	.ci/lock $(PYTHONS)

lowest:
	.ci/lowest

newest:
	.ci/newest

clean:
	rm -rf $(VENV) sessions build *.egg-info

# Old pips read the versions of build tools from PIP_CONSTRAINT, new ones from PIP_BUILD_CONSTRAINT; neither minds the
# other. (No hashes: pip then refuses to install the project itself from its folder.)
LOCKED := PIP_CONSTRAINT=lock.txt PIP_BUILD_CONSTRAINT=lock.txt

$(READY): pyproject.toml setup.py lock.txt
	@case " $(PYTHONS) " in *" $$($(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>&1) "*) ;; \
	*) echo "The locked versions are for Python $(PYTHONS); found: $$({ $(PYTHON) --version || echo none; } 2>/dev/null)." \
	"Say which to take: make PYTHON=python3.11" >&2; exit 1;; esac
	$(PYTHON) -m venv $(VENV)
	$(LOCKED) $(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev,docs]'
	$(BIN)/python -m compileall -q rig daq analysis  # as an installer does with what it copies: ours is linked
	@touch $(READY)
