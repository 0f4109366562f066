# `make demo` and `make test` install what is missing, build, and run. See README.md.

.PHONY: help demo test test-all setup lint doc clean

help:
	@echo 'make demo      show the walking T-rex in a window, or as pictures in out/ without a display'
	@echo 'make test      run the tests of what users rely on'
	@echo 'make test-all  run every test'
	@echo 'make lint      check formatting, clippy and documentation; warnings are errors'
	@echo 'make setup     only install what the others need'

setup:
	@scripts/setup all

demo:
	@scripts/setup build
	@scripts/demo

test:
	@scripts/setup all
	@scripts/test

test-all: test
	@scripts/test long

lint:
	@scripts/setup build
	cargo fmt --all --check
	cargo clippy --locked --workspace --all-targets -- -D warnings
	@# As `make demo` builds without a display. The selection is that of the line above, so only the command is checked again.
	cargo clippy --locked --workspace --lib --bins --test app --no-default-features --features leadr-vk/cli,leadr-gpu/watch -- -D warnings
	$(MAKE) doc

doc:
	RUSTDOCFLAGS=-Dwarnings cargo doc --locked --workspace --exclude leadr-wgpu --no-deps

clean:
	cargo clean
	rm -rf out
