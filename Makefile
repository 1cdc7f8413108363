# Two commands do all the set-up: `make demo` and `make test`.
.PHONY: test check

test:
	cmake --preset release
	cmake --build --preset release
	ctest --test-dir build/release --output-on-failure

check:
	@true
