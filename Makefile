# SPDX-License-Identifier: Apache-2.0
# The front door. Each target is a short script of scripts/; CMake presets do the building.
export PATH

.PHONY: help deps build demo test bench results lint check-long peers references check-peers check-viewer bench-error bench-denoiser bench-learn bench-ablation bench-view screenshots sheets install clean

help:
	@echo 'make deps         install the Debian packages of packages.txt, when some are missing'
	@echo 'make build        build/release/lumenaut'
	@echo 'make demo         train the bundled scene for two minutes, then draw sheet and curves'
	@echo 'make test         tests, house rules, sanitizers; ends with one line of counts'
	@echo 'make bench        measure tracing, training and frames on this machine'
	@echo 'make bench-error  time to equal error beside Mitsuba 3 (after make bench; an hour)'
	@echo 'make bench-denoiser MODELS="A.lmn B.lmn"  frames beside path tracing and a denoiser'
	@echo 'make bench-learn  how fast the methods of training learn (many hours; stops and goes on)'
	@echo 'make bench-ablation  the improved method without each of its parts (two hours; the same)'
	@echo 'make bench-view MODELS="A.lmn B.lmn"  frames and latency of the viewer, in a real page'
	@echo 'make results      active exploration beside uniform draws: four trainings of 15 minutes'
	@echo 'make lint         the house rules alone (format, includes, headers, symbols, text)'
	@echo 'make check-long   every test, all of them under ASan+UBSan, and TSan'
	@echo 'make peers        .venv with the programs that we compare with (Mitsuba 3, PyTorch, ...)'
	@echo 'make references   regenerate the small reference files of the tests from the peers'
	@echo 'make check-peers  compare images, gradients and metrics with the peers afresh'
	@echo 'make check-viewer  the viewer used for an hour, and ten minutes of a fuzzer under ASan+UBSan'
	@echo 'make screenshots  the viewer in a real page, into docs/results'
	@echo 'make sheets       the shared scenes beside Mitsuba and Tungsten, into docs/results'
	@echo 'make install      into PREFIX=/usr/local, with DESTDIR'
	@echo 'make clean        remove build/'

deps:
	@sh scripts/deps.sh packages.txt

build: deps
	@sh scripts/build.sh release

demo: build
	@sh scripts/demo.sh

test: deps
	@sh scripts/test.sh

lint: build
	@sh scripts/test.sh --lint

check-long: deps
	@sh scripts/test.sh --long

bench: build
	@sh scripts/bench.sh

# Done scenes are kept: run it again after an interruption.
bench-error: build peers
	@.venv/bin/python scripts/peers/bench_error.py
	@[ ! -d build/bench ] || /usr/bin/python3 scripts/bench_report.py build/bench bench/RESULTS.md

bench-denoiser: build peers
	@.venv/bin/python scripts/peers/bench_denoiser.py --json build/peers/denoiser.json \
	    --markdown docs/results/denoiser.md $(MODELS)

bench-learn: build
	@sh scripts/bench_learn.sh

bench-view: build
	@/usr/bin/python3 scripts/bench_view.py --json build/view.json $(MODELS)

bench-ablation: build
	@sh scripts/bench_ablation.sh

check-viewer: build
	@cmake --preset asan >/dev/null && cmake --build --preset asan --target fuzz_messages
	@build/asan/tests/viewer/fuzz_messages 600
	@/usr/bin/python3 tests/viewer/hour.py build/release/lumenaut

screenshots: build
	@/usr/bin/python3 scripts/screenshots.py

sheets: build peers
	@.venv/bin/python scripts/peers/sheets.py

results: build
	@sh scripts/results.sh

peers:
	@sh scripts/peers/setup.sh

references: build peers
	@sh scripts/references/run.sh

check-peers: build peers
	@sh scripts/peers/check.sh

PREFIX ?= /usr/local
install: build
	@cmake --install build/release --prefix '$(PREFIX)'

clean:
	@rm -rf build
