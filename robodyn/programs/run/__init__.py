"""Executors of programs: NumPy, machine code (llvm/), double-double, multiprecision."""
