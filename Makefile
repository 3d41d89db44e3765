# `compare` and `test` are the README's two commands; the others need the environment that `test` makes.
.PHONY: compare test slow lint types imports checks docs docs-rooms docs-results same-bits

compare:
	python3 -m venv .venv && .venv/bin/pip install -q -c constraints.txt . && .venv/bin/gyroctl compare

test:
	python3 -m venv .venv && .venv/bin/pip install -q -c constraints.txt -e ".[dev]" && .venv/bin/python -m pytest -n 2 -m "not slow"

# the long ones, in CI as well
slow:
	.venv/bin/python -m pytest -n 2 -m slow

checks: lint types imports

lint:
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .

types:
	.venv/bin/mypy

imports:
	.venv/bin/lint-imports

# the pages, the reference and the figures as a site: open build/site/index.html
docs:
	.venv/bin/python docs/build_site.py

# the picture in docs/architecture.md
docs-rooms:
	.venv/bin/python docs/draw_rooms.py

# tables, sentences and pictures of the pages from docs/results
docs-results:
	.venv/bin/python docs/write_results.py

# hashes of a fixed experiment; after a move: make same-bits AGAINST=before.json
same-bits:
	mkdir -p results
	.venv/bin/python benchmarks/same_bits.py --out results/same_bits.json $(if $(AGAINST),--against $(AGAINST))
