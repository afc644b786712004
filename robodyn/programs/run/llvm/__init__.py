"""Programs as machine code: explicit SIMD by LLVM, threads over blocks of samples."""
