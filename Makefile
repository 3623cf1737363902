# SPDX-License-Identifier: Apache-2.0
# The front door. `make help` lists what there is.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

JOBS ?= $(shell nproc)
# Tests of servers and workers wait for much of their time.
TEST_JOBS = $$(($(JOBS) + 1))
RELEASE := build/release
# Every source of ours; generated files and the build folders are not among them.
SOURCES = git ls-files -co --exclude-standard -- '*.h' '*.cc' | while read -r f; do [ -f "$$f" ] && echo "$$f"; done

# clang takes a quarter less time where it keeps freed memory, in huge pages.
FOR_CLANG := GLIBC_TUNABLES=glibc.malloc.hugetlb=1:glibc.malloc.mmap_threshold=33554432:glibc.malloc.trim_threshold=1073741824

# The page is tested in a browser, which is installed for it. BROWSER=no leaves that out.
BROWSER ?= yes
export BROWSER

.NOTPARALLEL:
.PHONY: help demo test bench check lint check-format tidy standalone format release build asan tsan fuzz soak cluster-test \
  packages browser web package package-test clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

packages:  ## install the Debian packages that are missing
	@scripts/install_packages.sh packages.txt

browser: packages  # Chromium, Node and the page's npm packages
ifneq ($(BROWSER),no)
	@scripts/install_packages.sh scripts/browser_packages.txt
	@scripts/install_node_modules.sh
endif

release: packages  ## build what is shipped, into build/release
	@scripts/build.sh release $(JOBS)

build: release

demo: packages  ## make a small world, map it, serve it, localize three photos over HTTP
	@scripts/build.sh release $(JOBS) waystone
	@$(RELEASE)/cli/waystone demo

test: release browser  ## build and run every test; BROWSER=no leaves out the page's
	@scripts/install_packages.sh scripts/test_packages.txt
	@scripts/run_tests.py $(RELEASE) --parallel $(TEST_JOBS)

# What fails or has no data keeps its earlier result; the page says of which day and commit each is.
BENCHES ?=
bench: browser  ## run the benchmarks and write docs/benchmarks.md; BENCHES="world pairs" runs some
	@scripts/install_packages.sh scripts/bench_packages.txt
	@scripts/install_packages.sh scripts/test_packages.txt
	@scripts/build.sh release $(JOBS) waystone waystone-bench waystone-speed
	@$(RELEASE)/bench/waystone-speed
	@scripts/bench.py $(RELEASE) $(BENCHES) || status=$$?; \
	 scripts/benchmark_tables.py $(RELEASE)/bench/results; exit $${status:-0}

check: lint test asan tsan  ## everything: lint, the tests, and these with sanitizers

lint: check-format tidy standalone  ## format, clang-tidy, each source by itself; warnings are errors

check-format: packages  # by .clang-format
	@scripts/install_packages.sh scripts/lint_packages.txt
	@$(SOURCES) | xargs clang-format --dry-run -Werror

tidy: packages  # clang-tidy
	@scripts/install_packages.sh scripts/lint_packages.txt
	@$(FOR_CLANG) scripts/tidy.py $(JOBS)

standalone: packages  # no source leans on those it is compiled together with
	@$(FOR_CLANG) scripts/compile_each.py $(JOBS)

asan: packages  ## all but the end-to-end tests with AddressSanitizer and UndefinedBehaviorSanitizer
	@scripts/build.sh asan $(JOBS) short_tests
	@LSAN_OPTIONS=suppressions=$(CURDIR)/scripts/lsan.supp:print_suppressions=0 \
	 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
	 scripts/run_tests.py build/asan --parallel $(TEST_JOBS) -L program -LE long

tsan: packages  ## the server's tests and the layers' on several threads, with ThreadSanitizer
	@scripts/build.sh tsan $(JOBS) threaded_tests
	@TSAN_OPTIONS=suppressions=$(CURDIR)/scripts/tsan.supp:print_suppressions=0 \
	 scripts/run_tests.py build/tsan --parallel $(TEST_JOBS) -L threaded

# What breaks a reader goes to build/fuzz/crashes, with a line how to try it again.
SECONDS ?= 3600
SEED ?= 0
fuzz: packages  ## libFuzzer on every reader of what strangers send; SECONDS=3600 for each
	@scripts/install_packages.sh scripts/fuzz_packages.txt
	@$(FOR_CLANG) scripts/build.sh fuzz $(JOBS) fuzz
	@scripts/fuzz.py build/fuzz $(SECONDS) $(JOBS) $(SEED)

# PRESET=tsan runs the server that is built with ThreadSanitizer. The released program makes the
# maps and the answers to compare with.
MINUTES ?= 30
PRESET ?= release
soak: packages  ## honest and hostile clients on a server with changing maps; MINUTES=30
	@scripts/build.sh release $(JOBS) waystone
	@[ $(PRESET) = release ] || scripts/build.sh $(PRESET) $(JOBS) waystone
	@TSAN_OPTIONS=suppressions=$(CURDIR)/scripts/tsan.supp:print_suppressions=0 \
	 tests/soak/soak.py --program build/$(PRESET)/cli/waystone --offline $(RELEASE)/cli/waystone \
	 --seconds $$(($(MINUTES) * 60)) --folder $(RELEASE)/soak $(if $(filter release,$(PRESET)),,--slower 10)

# Its maps stay in build/release/cluster for the next time.
cluster-test: packages  ## PostgreSQL, HAProxy, three servers and two workers, killed one after another
	@scripts/install_packages.sh scripts/test_packages.txt
	@scripts/build.sh release $(JOBS) waystone
	@tests/cluster/cluster_test.py --program $(RELEASE)/cli/waystone --folder $(RELEASE)/cluster \
	 --json $(RELEASE)/cluster.json

format: packages  ## lay out every source file by .clang-format
	@scripts/install_packages.sh scripts/lint_packages.txt
	@$(SOURCES) | xargs clang-format -i

web:  ## build the page anew into server/web/dist (the result is committed)
	@scripts/install_packages.sh scripts/browser_packages.txt
	@/usr/bin/python3 scripts/generate_js_client.py clients/openapi.yaml clients/js
	@scripts/install_node_modules.sh
	@cd server/web && npm run --silent check && npm run --silent build

package: packages  ## make build/release/package/waystone_*.deb
	@scripts/build.sh release $(JOBS) waystone package_files
	@cd $(RELEASE) && cpack --config CPackConfig.cmake

package-test: package  ## unpack the .deb into a folder and run what is in it
	@tests/package/package_test.sh $(RELEASE)/package/waystone_*.deb

clean:  ## remove the build folder
	@rm -rf build
