"""The linter: rules (one rule, one file), what they read, causes, fixes, baselines."""
