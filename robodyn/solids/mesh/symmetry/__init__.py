"""Mirror planes and axes of symmetry: candidates by moments, verdicts by volumes."""
