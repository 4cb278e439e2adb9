# Every command sets up what it needs: a virtual environment in .venv with pinned versions.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready

.PHONY: demo test test-all lint bench verify trust mutants docs vendor clean

demo: $(READY)            ## 60 deployments, a surrogate learned from them, demo/report.html
	$(BIN)/billow demo --out demo

test: $(READY)            ## the test suite without tests of half a minute and more, in two processes
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "not slow"

test-all: $(READY)        ## the whole test suite
	$(BIN)/python -m pytest -n 2 --dist worksteal

lint: $(READY)            ## style and likely mistakes
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

verify: $(READY)          ## closed-form cases: measured, expected, tolerance
	$(BIN)/billow verify

bench: $(READY)           ## the measurements quoted in the README
	$(BIN)/python benchmarks/run.py

trust: $(READY)           ## reliability goals as a table: determinism, restart, faults, fuzzing, kills, locks, full disks
	$(BIN)/python -m trust

mutants: $(READY)         ## mistakes put into a copy of the package: each is caught by its test
	$(BIN)/python -m trust.mutants

docs: $(READY)            ## regenerate the references of commands, cases, studies, decks and errors, and build the site: build/site/index.html
	$(BIN)/python docs/make_reference.py
	$(BIN)/python docs/make_study.py
	$(BIN)/python docs/make_decks.py
	$(BIN)/python docs/make_errors.py
	$(BIN)/python docs/make_commands.py
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[docs]'
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs build/site

vendor:                   ## bundle three.js and uPlot again, after a change in vendor/; needs npm
	$(PYTHON) vendor/build.py

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit("Billow needs Python 3.11 or newer; set PYTHON=/path/to/python3.11" if sys.version_info < (3, 11) else 0)'
	test -d $(VENV) || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[train,dev]'
	touch $@

clean:
	rm -rf $(VENV) demo .pytest_cache .ruff_cache
