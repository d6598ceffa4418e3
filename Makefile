# Everything a developer or a batch run needs; `make help` lists it.

PYTHON ?= python3
VENV ?= .venv
# Where the batch run writes, what it computes, and which figures it draws.
OUT ?= out
CONFIGS ?= $(sort $(wildcard configs/*.toml))
FIGURES ?= area gci region
# Those of one configuration, where none are asked for.
FIGURES_pentapod ?= $(if $(filter file,$(origin FIGURES)),share gci volume region,$(FIGURES))
FORMAT ?= png
SWEEP_OPTIONS ?=
PLOT_OPTIONS ?=
# Conditions of the optimum region, one `--where` each, and those of one configuration.
REGION ?= --where 'usable_workspace_area>=24' --where 'gci>=0.62'
REGION_passive-leg ?= --where 'usable_workspace_area>=12' --where 'gci>=0.55'
REGION_pentapod ?= --where 'usable_share>=0.5' --where 'gci>=0.02'
FIGURES_pentapod-small-motions ?= $(FIGURES_pentapod)
REGION_pentapod-small-motions ?= --where 'largest_limb_force<=12' --where 'gci>=0.02'

BIN := $(VENV)/bin
ATLAS := $(BIN)/atlas
NAMES := $(notdir $(basename $(CONFIGS)))
RESULTS := $(NAMES:%=$(OUT)/%.h5)
figures_of = $(or $(FIGURES_$(1)),$(FIGURES))
PICTURES := $(foreach name,$(NAMES),$(patsubst %,$(OUT)/$(name)-%.$(FORMAT),$(call figures_of,$(name))))

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.SECONDARY:

.PHONY: help
help: ## List the targets
	@awk 'BEGIN {FS = ":.*## "} /^[a-z-]+:.*## / {printf "  %-14s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))
	@printf '\nVariables: PYTHON=%s VENV=%s OUT=%s FIGURES="%s" FORMAT=%s\n' \
		'$(PYTHON)' '$(VENV)' '$(OUT)' '$(FIGURES)' '$(FORMAT)'

# One stamp for each set of extras: a target installs what it needs and nothing else.
$(VENV)/.python:
	$(PYTHON) -m venv $(VENV)
	touch $@

$(ATLAS): $(VENV)/.python pyproject.toml
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --editable .
	touch $@

$(VENV)/.extra-%: $(VENV)/.python pyproject.toml
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --editable '.[$*]'
	touch $@

.PHONY: install
install: $(VENV)/.extra-test,check,bench,docs ## Make the virtual environment with the package and all extras

.PHONY: check
check: $(VENV)/.extra-test,check ## Lint, formatting, types and the layer contract
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --strict fivebar_atlas
	$(BIN)/lint-imports

.PHONY: test
test: $(VENV)/.extra-test ## Run the test suite, on all cores
	$(BIN)/python -m pytest -n auto --maxprocesses 8 --dist loadfile

.PHONY: test-nojit
test-nojit: $(VENV)/.extra-test ## Run the kernels as plain Python on small inputs, with coverage
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -m nojit --cov-report=term-missing \
		--cov=fivebar_atlas/numerics --cov=fivebar_atlas/mechanisms

.PHONY: bench
bench: $(VENV)/.extra-bench ## Speed and accuracy, side by side with a plain NumPy grid
	$(BIN)/python benchmarks/bench.py

.PHONY: docs
docs: $(VENV)/.extra-docs ## Build the documentation; a warning is an error
	$(BIN)/sphinx-build -W --keep-going -b html docs docs/_build/html

.PHONY: atlases
atlases: $(RESULTS) $(PICTURES) ## Every configuration: sweep to HDF5, then the figures

# A sweep that was interrupted goes on with its finished blocks.
$(OUT)/%.h5: configs/%.toml | $(ATLAS)
	@mkdir -p $(OUT)
	$(ATLAS) sweep $< -o $@ $(if $(wildcard $@.partial),--resume) --overwrite $(SWEEP_OPTIONS)

# What a kind of figure needs beyond the file and the output.
options_region = $(or $(REGION_$*),$(REGION))

define picture
$(OUT)/%-$(1).$(FORMAT): $(OUT)/%.h5 | $(ATLAS)
	$$(ATLAS) plot $(1) $$< -o $$@ --overwrite $$(options_$(1)) $$(PLOT_OPTIONS)
endef
$(foreach figure,$(sort $(foreach name,$(NAMES),$(call figures_of,$(name)))),$(eval $(call picture,$(figure))))

.PHONY: picture
picture: $(OUT)/paper.h5 ## Redraw the picture of the README
	@mkdir -p docs/images
	$(ATLAS) plot area $< -o docs/images/area.png --overwrite

.PHONY: clean
clean: ## Remove what was built, but neither the environment nor results
	rm -rf build dist docs/_build docs/_generated .coverage .pytest_cache .mypy_cache .ruff_cache
	rm -rf .import_linter_cache .hypothesis
	find fivebar_atlas tests benchmarks docs -name __pycache__ -type d -prune -exec rm -rf {} +
