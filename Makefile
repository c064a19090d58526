# The README's commands. Python and packages live in .venv, made by .ci/setup when it lacks or pyproject.toml changes.
.PHONY: demo test training lint format bench demo-images extension real-blender clean setup

python := .venv/bin/python
DEMO := demo-out

# The half-views have a scale of their own, so they are a job of their own.
demo: setup
	.venv/bin/pavemark render assets/demo/job.toml --out $(DEMO)/full
	.venv/bin/pavemark render assets/demo/half/job.toml --out $(DEMO)/half
	.venv/bin/pavemark preview $(DEMO)/full
	.venv/bin/pavemark preview $(DEMO)/half
	@echo "Images and labels: $(CURDIR)/$(DEMO)/full and half"
	@echo "All at a glance:   $(CURDIR)/$(DEMO)/full/preview.png and half/preview.png"

# Slow tests measure time or use every core themselves, so they run alone.
test: setup
	$(python) -m pytest -m "not slow" --numprocesses 2
	$(python) -m pytest -m slow

# Trainings, which `make test` skips where there is no torch.
training: setup
	@.ci/torch
	build/torch/bin/python -m pytest tests/training tests/study

lint: setup
	$(python) -m ruff check .
	$(python) -m ruff format --check .

format: setup
	$(python) -m ruff check --fix .
	$(python) -m ruff format .

bench: setup
	$(python) tests/bench/bench.py

demo-images: setup
	$(python) -m blender_addon.carpark --out assets/demo

# Needs a Blender program ($BLENDER, or `blender` on PATH) and, for its window, $DISPLAY; skipped where there is none.
real-blender: setup
	$(python) -m pytest tests/real_blender --override-ini addopts=-q -rs

# For another Blender or platform: make extension FOR='--python 3.11 --platform windows-x64'
extension: setup
	$(python) .ci/extension.py $(FOR)

clean:
	rm -rf .venv build dist $(DEMO) *.egg-info .pytest_cache .ruff_cache .hypothesis

setup:
	@.ci/setup
