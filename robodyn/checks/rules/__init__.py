"""One rule, one file, with its documentation and examples in it."""
