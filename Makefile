# Everything a newcomer needs: `make demo`, `make test`, `make serve`.
# The first of these that can make an environment, else the first that starts. 3.11 has the fastest pictures (see
# README). The system's own before another of the same name: that one may have been compiled without optimisations
# (pyenv does so), which takes a quarter more time.
PYTHON ?= $(shell for can in 'import ensurepip' ''; do for p in /usr/bin/python3.11 python3.11 python3.13 python3.12 \
  python3; do $$p -c "$$can" 2>/dev/null && echo $$p && exit; done; done)
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

CATALOGUES := $(patsubst %.po,%.mo,$(wildcard rrp_sheets/locale/*/LC_MESSAGES/*.po))

.PHONY: help setup demo test test-slow lint house bench strips texts traces soak serve lock clean

help:  ## this list
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 10

setup: $(STAMP) $(CATALOGUES)  ## make .venv with everything in it

$(STAMP): requirements.lock pyproject.toml
	@sh .ci/python-check "$(PYTHON)"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps -e .
	@$(BIN)/python -m compileall -q -j 0 rrp_sheets
	@touch $(STAMP)

%.mo: %.po | $(STAMP)
	@$(BIN)/python -c 'from pathlib import Path; from hatch_build import compile_texts; compile_texts(Path())'

demo: setup  ## run a workbook on the simulated NAO and say where everything is
	$(BIN)/rrp-sheets run workbooks/simple-tracking.xlsx --fast --out "runs/demo-$$(date +%Y%m%d-%H%M%S)"

serve: setup  ## open the grid on copies of the workbooks, in my-workbooks
	@mkdir -p my-workbooks
	@for book in workbooks/*.xlsx; do [ -e "my-workbooks/$${book##*/}" ] || cp "$$book" my-workbooks/; done
	$(BIN)/rrp-sheets serve my-workbooks

PYTEST := $(BIN)/python -m pytest -n 4 --dist loadfile --no-loadscope-reorder

test: setup  ## install what the tests need, and run them; not the slow ones
	@sh .ci/apt-packages
	$(PYTEST) -m "not soak and not slow"

test-slow: setup  ## run the slow tests, which reach nothing that the others do not
	@sh .ci/apt-packages
	$(PYTEST) -m "slow and not soak"

lint: setup  ## style, types, layers
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

house: setup  ## how the code reads: each measure today and wanted
	$(BIN)/python tests/house.py

bench: setup  ## the benchmarks, with their ratios
	$(BIN)/python -m pytest tests/benchmarks -s -o python_files='bench_*.py' -o addopts=-q

strips: setup  ## film strips of gestures, postures, walking and trackers, in runs/strips, to be looked at
	$(BIN)/python tests/benchmarks/strips.py runs/strips

texts: setup  ## renew the catalogues of rrp_sheets/locale: new texts come in untranslated, old ones go
	$(BIN)/python tests/translations.py

traces: setup  ## the traces of all workbooks beside those of other Pythons: make traces OTHERS="DIR/bin/python …"
	$(BIN)/python tests/benchmarks/traces.py $(BIN)/python $(OTHERS)

soak: setup  ## what is too long for every day, and property tests with examples that are newly drawn
	$(BIN)/python -m pytest -m "soak or hypothesis" --hypothesis-profile=drawn

lock:  ## renew requirements.lock (needs uv)
	uv pip compile --universal --python-version 3.11 --generate-hashes --extra dev --no-emit-index-url \
	  --no-emit-find-links --no-annotate --custom-compile-command "make lock" -o requirements.lock pyproject.toml

clean:  ## remove what was made here
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis rrp_sheets/_vendor $(CATALOGUES) \
	  rrp_sheets/locale/*/LC_MESSAGES/scripts.json
