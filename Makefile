# make demo   the main job on an example: fit, export, verify, a plot
# make test   everything the tests need, then all of them
# make prove  the exported C has no undefined behaviour, whatever the input (Frama-C, 1 GB)
# make mutants  changes the C runtime in one place after the other: do its unit tests notice?
# make coverage  which branches of the C runtime's sources its unit tests take
# make vcan   the SocketCAN node on a real vcan, in a kernel that runs as a process
PYTHON ?= python3
VENV ?= .venv
OUT ?= out
JOINT ?= examples/shoulder.toml

BIN := $(VENV)/bin
NAME := $(basename $(notdir $(JOINT)))

# libFuzzer is a package of its own; where it is missing, clang answers with the bare name.
FUZZER = $(shell clang -print-file-name=libclang_rt.fuzzer-$$(uname -m).a 2>/dev/null || echo libFuzzer)

# Programs and files that the tests need, as command or path:Debian package; other libraries go
# with their program.
TOOLS = gcc:gcc g++:g++ clang:clang clang-tidy:clang-tidy $(FUZZER):libclang-rt-dev cmake:cmake \
  arm-none-eabi-gcc:gcc-arm-none-eabi arm-none-eabi-gcc:libnewlib-arm-none-eabi \
  riscv64-unknown-elf-gcc:gcc-riscv64-unknown-elf \
  riscv64-unknown-elf-gcc:picolibc-riscv64-unknown-elf \
  avr-gcc:gcc-avr avr-gcc:avr-libc simavr:simavr simavr:libsimavr-dev \
  arduino-builder:arduino-builder arduino-builder:arduino-core-avr \
  qemu-system-arm:qemu-system-arm qemu-system-riscv32:qemu-system-misc gappa:gappa \
  chromium:chromium cppcheck:cppcheck

.PHONY: demo test prove mutants coverage vcan lint tools benchmark clean

demo: $(VENV)/.installed
	@mkdir -p $(OUT)
	@printf '\n== Weights for %s\n' $(JOINT)
	$(BIN)/ccgen fit $(JOINT) --plot $(OUT)/$(NAME).svg
	$(BIN)/ccgen fit $(JOINT) --plot $(OUT)/$(NAME).png >/dev/null
	@printf '\n== C for its microcontroller\n'
	$(BIN)/ccgen export $(JOINT) -o $(OUT)/$(NAME)
	@printf '\n== Proof that it computes the same\n'
	$(BIN)/ccgen verify $(OUT)/$(NAME) --target host
	@printf '\nSee %s/%s.svg and %s/%s/README.md\n' $(OUT) $(NAME) $(OUT) $(NAME)

test: tools $(VENV)/.test-installed lint
	$(BIN)/pytest -n 2 --dist worksteal

prove: TOOLS := frama-c:frama-c-base gcc:gcc
prove: tools $(VENV)/.installed
	tests/c/prove/run.sh $(BIN)/ccgen $(OUT)/prove

mutants: TOOLS := gcc:gcc clang:clang arm-none-eabi-gcc:gcc-arm-none-eabi \
  arm-none-eabi-gcc:libnewlib-arm-none-eabi riscv64-unknown-elf-gcc:gcc-riscv64-unknown-elf
mutants: tools $(VENV)/.test-installed
	$(BIN)/python tests/mutants/run.py

coverage: TOOLS := gcc:gcc gcov:gcc
coverage: tools $(VENV)/.test-installed
	$(BIN)/python tests/coverage/run.py

vcan: TOOLS := gcc:gcc linux.uml:user-mode-linux insmod:kmod ip:iproute2 candump:can-utils
vcan: tools $(VENV)/.test-installed
	$(BIN)/python tests/vcan/run.py

lint: $(VENV)/.test-installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# Installs what is missing where that is allowed, and otherwise names it.
tools:
	@missing=""; names=""; \
	for tool in $(TOOLS); do \
	  command -v "$${tool%%:*}" >/dev/null || [ -e "$${tool%%:*}" ] || { missing="$$missing $${tool#*:}"; names="$$names $${tool%%:*}"; }; \
	done; \
	if [ -n "$$missing" ]; then \
	  if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
	    apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $$missing; \
	  else \
	    printf 'missing:%s (Debian packages:%s); tests that need them will fail\n' "$$names" "$$missing"; \
	  fi; \
	fi

benchmark: $(VENV)/.test-installed
	@for file in tests/benchmarks/*.py; do printf '\n== %s\n' $$file; $(BIN)/python $$file || exit 1; done

$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -e .
	$(BIN)/python -m compileall -q ccgen
	@touch $@

$(VENV)/.test-installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -e '.[test]'
	@touch $@ $(VENV)/.installed

clean:
	rm -rf $(OUT) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
