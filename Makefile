# SPDX-License-Identifier: Apache-2.0
# The front door. `make help` lists what there is.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

JOBS ?= $(shell nproc)
RELEASE := build/release
# Every source of ours; generated files and the build folders are not among them.
SOURCES = git ls-files -co --exclude-standard -- '*.h' '*.cc' | while read -r f; do [ -f "$$f" ] && echo "$$f"; done

.PHONY: help demo test bench format lint release build asan tsan packages web package package-test clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z].*## / {printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

packages:  ## install the Debian packages that are missing
	@scripts/install_packages.sh packages.txt

release: packages  ## build what is shipped, into build/release
	@scripts/build.sh release $(JOBS)

build: release

demo: packages  ## make a small world, map it, serve it, localize three photos over HTTP
	@scripts/build.sh release $(JOBS) waystone
	@$(RELEASE)/cli/waystone demo

test: release  ## build and run every test
	@ctest --test-dir $(RELEASE) --parallel $(JOBS) --output-on-failure --no-tests=error

bench: packages  ## build and run the benchmarks (waystone-bench alone lists them)
	@scripts/build.sh release $(JOBS) waystone waystone-bench
	@$(RELEASE)/bench/waystone-bench all

asan: packages  ## the tests under AddressSanitizer and UndefinedBehaviorSanitizer
	@scripts/build.sh asan $(JOBS)
	@LSAN_OPTIONS=suppressions=$(CURDIR)/scripts/lsan.supp:print_suppressions=0 ctest --test-dir build/asan --parallel $(JOBS) --output-on-failure --no-tests=error

tsan: packages  ## the tests under ThreadSanitizer
	@scripts/build.sh tsan $(JOBS)
	@ctest --test-dir build/tsan --parallel $(JOBS) --output-on-failure --no-tests=error

format: packages  ## lay out every source file by .clang-format
	@scripts/install_packages.sh scripts/lint_packages.txt
	@$(SOURCES) | xargs clang-format -i

lint: packages  ## layout, clang-tidy and compiler warnings; each one is an error
	@scripts/install_packages.sh scripts/lint_packages.txt
	@$(SOURCES) | xargs clang-format --dry-run -Werror
	@scripts/build.sh dev $(JOBS)
	@scripts/tidy.sh $(JOBS)

web:  ## build the page anew into server/web/dist (needs Node 20 and npm; the result is committed)
	@/usr/bin/python3 scripts/generate_js_client.py clients/openapi.yaml clients/js
	@cd server/web && npm ci --no-audit --no-fund && npm run --silent check && npm run --silent build

package: packages  ## make build/release/package/waystone_*.deb
	@scripts/build.sh release $(JOBS) waystone package_files
	@cd $(RELEASE) && cpack --config CPackConfig.cmake

package-test: package  ## unpack the .deb into a folder and run what is in it
	@tests/package/package_test.sh $(RELEASE)/package/waystone_*.deb

clean:  ## remove the build folder
	@rm -rf build
