
# Library for @NAME@.py.
library: lib@NAME@.so

lib@NAME@.so: @NAME@.c @NAME@.h
	$(CC) $(CFLAGS) -fPIC -shared -o lib@NAME@.so @NAME@.c -lm

test-python: library
	python3 @NAME@.py vectors.csv

.PHONY: library test-python
