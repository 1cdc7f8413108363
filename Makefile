# Two commands do all the set-up: `make demo` and `make test`. docs/architecture.md says more.
.PHONY: help packages fuzz build demo test test-all check format bench bench-tables test-references check-cases tsan docs web-demo addon

GLOWWORM := build/release/bin/glowworm
JOBS := $(shell nproc)
# Some tests wait for processes rather than compute.
TEST_JOBS := $(shell expr $(JOBS) + 1)

help:
	@echo 'make demo             builds, and renders the Cornell box to out/'
	@echo 'make test             builds, and runs the tests of every room but the slow ones'
	@echo 'make test-all         builds, and runs every test'
	@echo 'make check            formatting, include arrows, code, the manual and its commands, fast tests with Clang and sanitizers'
	@echo 'make format           formats every C++ file'
	@echo 'make docs             the manual and the API reference, into build/docs/'
	@echo 'make web-demo         bakes scenes and shows them in a headless browser, into out/web/; needs npm and chromium'
	@echo 'make addon            the Blender add-on as a zip file, into out/'
	@echo 'make tsan             the fast tests under the thread sanitizer'
	@echo 'make fuzz             what reads scene files and textures under libFuzzer, 10 minutes for each format'
	@echo 'make bench            the micro-benchmarks'
	@echo 'make bench-tables     the tables of the papers, into bench/results/'
	@echo 'make test-references  pictures against those of another renderer, where ../shared has them'
	@echo 'make check-cases      small inputs against their right values, where ../shared has them'

packages:
	@scripts/install-packages

build: packages
	cmake --preset release $(CMAKE_OPTIONS)
	cmake --build --preset release

demo: packages
	cmake --preset release
	cmake --build --preset release --target glowworm
	@mkdir -p out
	$(GLOWWORM) render builtin:cornell -o out/cornell.exr -o out/cornell.png
	@echo 'The picture is in $(CURDIR)/out/cornell.exr (linear) and $(CURDIR)/out/cornell.png.'

test: build
	ctest --preset release -j $(TEST_JOBS) -LE slow

test-all: build
	ctest --preset release -j $(TEST_JOBS)

check: packages
	scripts/check-format
	scripts/check-includes --self-test
	scripts/check-includes
	scripts/check-code --self-test
	scripts/check-code
	scripts/check-docs --self-test
	scripts/check-docs
	scripts/check-commands --self-test
	cmake --preset release
	cmake --build --preset release --target glowworm
	scripts/check-commands
	cmake --preset asan
	cmake --build --preset asan
	ctest --preset asan -j $(TEST_JOBS)

format: packages
	scripts/check-format --fix

web-demo: build
	scripts/web-demo

addon:
	@mkdir -p out
	rm -rf addons/blender/glowworm/__pycache__
	cd addons/blender && python3 -m zipfile -c ../../out/glowworm-blender.zip glowworm
	@echo 'The add-on is in $(CURDIR)/out/glowworm-blender.zip.'

docs:
	@scripts/install-packages packages-docs.txt
	scripts/build-docs

tsan: packages
	cmake --preset tsan
	cmake --build --preset tsan
	ctest --preset tsan -j $(JOBS)

fuzz: packages
	scripts/fuzz

bench: build
	scripts/run-benchmarks

bench-tables: build
	scripts/run-benchmarks --tables

test-references: build
	scripts/test-references

check-cases: build
	scripts/check-cases
