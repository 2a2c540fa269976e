# make demo     plan a scenario of the paper, check the plan, and write a page that shows it
# make test     the test suite
# make test-fast  the parts by themselves, in under a minute once compiled
# make verify   the long counts (hours); goes on where it was stopped
# make regression  holds the shipped scenarios to what the last release did
# make docs     the site, in build/site; a broken link is an error
# make gallery  the pictures in docs/, from the shipped scenarios
# make lint, make types, make clean

VENV := .venv
BIN := $(VENV)/bin
# The stamp makes a second call quick: nothing is installed again until pyproject.toml changes.
STAMP := $(VENV)/.installed
DEMO := build/demo-plan.json
DEMO_PAGE := build/demo.html
PIP := PIP_DISABLE_PIP_VERSION_CHECK=1 $(BIN)/python -m pip install -qq

.PHONY: demo test test-fast verify regression docs gallery lint types clean
.DELETE_ON_ERROR:

demo: $(STAMP)
	@mkdir -p build
	$(BIN)/gm-ompl plan paper/regrasp -o $(DEMO) --html $(DEMO_PAGE)
	$(BIN)/gm-ompl check $(DEMO)
	@echo "The plan is in $(DEMO); open $(DEMO_PAGE) in a browser to see it (no network needed)."

test: $(STAMP)
	$(BIN)/python -m pytest -n 2 --dist worksteal

test-fast: $(STAMP)
	$(BIN)/python -m pytest -n 2 tests/units tests/motion tests/holds \
	  tests/feasibility/test_steady_modes.py

verify: $(STAMP)
	$(BIN)/python -m tests.verify

regression: $(STAMP)
	$(BIN)/python -m tests.verify.regression

docs: $(STAMP)
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict
	@echo "Open build/site/index.html in a browser (no network needed)."

gallery: $(STAMP)
	$(BIN)/python -m docs.tables.gallery docs

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-cache

types: $(STAMP)
	$(BIN)/mypy

clean:
	rm -rf build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis *.egg-info

$(STAMP): pyproject.toml
	@echo "Preparing $(VENV) (once; takes a minute or two) ..."
	@.ci/find-python > /dev/null
	@[ -x $(BIN)/python ] || "$$(.ci/find-python)" -m venv $(VENV) || \
	  { rm -rf $(VENV); echo "python3 -m venv failed; on Debian or Ubuntu: apt-get install python3-venv" >&2; exit 1; }
	@$(PIP) --editable '.[dev]'
	@touch $@
