# Builds and runs the self-test of @NAME@: make test
RUSTC ?= rustc

test: selftest
	./selftest vectors.csv

selftest: selftest.rs @NAME@.rs
	$(RUSTC) --edition 2021 -O -o selftest selftest.rs

clean:
	rm -f selftest

.PHONY: test clean
