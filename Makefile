# `make help` lists the targets. Everything is installed into .venv; nothing outside of this folder is changed.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

# Three tests at a time: many wait for processes that they started, so that two processors are not busy with two.
PARALLEL := -n 3 --dist worksteal

# Tests start hundreds of processes: compiled modules are kept, where the environment says otherwise, too.
unexport PYTHONDONTWRITEBYTECODE

SIM ?= mujoco
ROUNDS ?= 25

.DEFAULT_GOAL := help
.PHONY: help install demo test test-all test-more test-lowest test-ros2 chaos lint format goldens docs dist man pictures ui editors bench experiment-localisation experiment-engines clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-23s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "seoro needs Python 3.11 or newer; choose one with: make PYTHON=python3.x ..." >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) \
		|| { echo "Python's venv module is missing; on Debian: apt-get install python3-venv" >&2; rm -rf $(VENV); exit 1; }

$(VENV)/.user: pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing seoro with the MuJoCo simulator and the language server into $(VENV)"
	@$(INSTALL) --editable '.[mujoco,lsp]'
	@touch $@

$(VENV)/.dev: pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing seoro with what its tests need into $(VENV)"
	@$(INSTALL) --editable '.[mujoco,pybullet,lsp,dev]'
	@touch $@ $(VENV)/.user

$(VENV)/.docs: pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing what the documentation needs into $(VENV)"
	@$(INSTALL) --editable '.[node,ros2,lsp,docs]'
	@touch $@

install: $(VENV)/.user  ## set up .venv with seoro, the MuJoCo simulator and the language server

demo: $(VENV)/.user  ## run the obstacle scenario in MuJoCo; pictures and results go to out/
	@$(BIN)/seoro exec scenarios/navigation/obstacle.osc --sim mujoco --rate max -o out/

test: lint  ## check the code and run the tests
	@$(BIN)/pytest $(PARALLEL)

test-all: lint  ## the same, with the long tests
	@$(BIN)/pytest --timeout 3600 -m ""

chaos: $(VENV)/.dev  ## play rounds of faults against a real lab, and check what must hold; resumes its journal
	@$(BIN)/python -m tests.chaos --rounds $(ROUNDS)

test-more: $(VENV)/.dev  ## tests marked `more`, and a choice of the long ones: faults at random, kills, genuine nodes of ROS 2
	@timeout 1200 $(BIN)/pytest $(PARALLEL) --timeout 800 -m "more and not slow"
	@timeout 1500 $(BIN)/pytest --timeout 1200 -m "slow or ros2" tests/chaos tests/bridges/ros2/genuine
	@timeout 900 $(BIN)/pytest $(PARALLEL) --timeout 800 -m slow tests/sim_nodes/test_determinism.py \
		tests/executor/test_load.py::test_many_clients_lose_no_run_and_record

test-lowest:  ## the tests with the lowest allowed versions of all packages, in an environment of their own, $(VENV)-lowest
	@$(PYTHON) -m venv $(VENV)-lowest
	@$(VENV)-lowest/bin/python -m tests.tools.lowest_versions > $(VENV)-lowest/versions.txt
	@$(VENV)-lowest/bin/python -m pip install --quiet --disable-pip-version-check --constraint $(VENV)-lowest/versions.txt \
		--editable '.[mujoco,pybullet,lsp,dev]'
	@$(VENV)-lowest/bin/pytest $(PARALLEL)

test-ros2: $(VENV)/.dev  ## the tests with nodes of ROS 2 itself, where ../shared/ros2 has what they need
	@$(BIN)/pytest -m ros2 tests/bridges/ros2/genuine

lint: $(VENV)/.dev  ## ruff, mypy and the direction of imports
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/mypy benchmarks
	@$(BIN)/lint-imports --no-cache
	@$(BIN)/python -m tests.tools.prose

format: $(VENV)/.dev  ## format the code
	@$(BIN)/ruff format .
	@$(BIN)/ruff check --fix .

goldens: $(VENV)/.dev  ## rewrite the golden files of tests; review the difference
	@$(BIN)/python -m seoro.bridges.wire.schema
	@$(BIN)/python -m tests.tools.json_schemas
	@SEORO_UPDATE_GOLDENS=1 $(BIN)/pytest tests/lang/test_diagnostics.py tests/lang/test_explain.py \
		tests/lang/format/test_formatter.py tests/editors/test_textmate.py

docs: $(VENV)/.docs  ## build the documentation in build/docs; broken links and other warnings are errors
	@$(BIN)/python -m sphinx -q -W --keep-going -b html -d build/doctrees docs build/docs
	@echo "open build/docs/index.html"

dist: $(VENV)/.dev  ## build wheel and sdist in dist/; the same commit gives the same bytes
	@rm -rf dist
	@SOURCE_DATE_EPOCH=$${SOURCE_DATE_EPOCH:-$$(git log -1 --format=%ct)} $(BIN)/python -m hatchling build --directory dist
	@cd dist && sha256sum *

man: $(VENV)/.dev  ## write manual pages of all commands to build/man
	@COLUMNS=72 $(BIN)/python docs/man_pages.py build/man

pictures: $(VENV)/.dev  ## make the pictures of the documentation anew, in MuJoCo; review the difference
	@$(BIN)/python docs/pictures.py

ui:  ## build the pages of reports and of `seoro ui` from ui/, with Node.js
	@npm --prefix ui ci --no-audit --no-fund --omit-lockfile-registry-resolved
	@npm --prefix ui run --silent check
	@npm --prefix ui run --silent build

editors: $(VENV)/.user  ## test and package the extension for VS Code, with Node.js 20
	@npm --prefix editors/vscode install --no-package-lock --no-audit --no-fund
	@SEORO=$(CURDIR)/$(BIN)/seoro npm --prefix editors/vscode test
	@npm --prefix editors/vscode run package
	@echo "install it with: code --install-extension editors/vscode/dist/seoro-osc.vsix"

bench: $(VENV)/.user  ## measure what the documentation quotes
	@$(BIN)/python benchmarks/obstacle.py
	@$(BIN)/python benchmarks/simulators.py
	@$(BIN)/python benchmarks/nodes.py
	@$(BIN)/python benchmarks/films.py
	@$(BIN)/python benchmarks/snapshots.py
	@$(BIN)/python benchmarks/editor.py
	@$(BIN)/python benchmarks/startup.py
	@$(BIN)/python benchmarks/runtime.py
	@$(BIN)/python benchmarks/traces.py
	@$(BIN)/python benchmarks/bags.py
	@$(BIN)/python benchmarks/ros2_wire.py
	@$(BIN)/python benchmarks/network.py

experiment-localisation: $(VENV)/.user  ## faults of a lidar and the error of the localisation: 360 runs, results in out/localisation
	@$(BIN)/seoro campaign run scenarios/experiments/localisation.yaml --sim $(SIM) -o out/localisation --overwrite || test $$? -eq 1
	@$(BIN)/python benchmarks/localisation_experiment.py out/localisation --simulator $(SIM)

experiment-engines: $(VENV)/.dev  ## compare scenarios in MuJoCo and PyBullet, as a table
	@$(BIN)/python benchmarks/engines.py

clean:  ## remove .venv, caches and results
	rm -rf $(VENV) out .mypy_cache .ruff_cache .pytest_cache .hypothesis
