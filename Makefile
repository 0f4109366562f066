# `make demo` and `make test` install what is missing, build, and run. See README.md.

.PHONY: help demo test setup lint doc clean

help:
	@echo 'make demo    show the walking T-rex in a window, or as pictures in out/ without a display'
	@echo 'make test    run every test'
	@echo 'make lint    check formatting, clippy and documentation; warnings are errors'
	@echo 'make setup   only install what the others need'

setup:
	@scripts/setup all

demo:
	@scripts/setup build
	@scripts/demo

test:
	@scripts/setup all
	@scripts/test

lint:
	@scripts/setup build
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings
	RUSTDOCFLAGS=-Dwarnings cargo doc --locked --no-deps
	RUSTDOCFLAGS=-Dwarnings cargo doc --locked --no-deps --features internals

clean:
	cargo clean
	rm -rf out
