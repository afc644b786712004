"""Surfaces put right: bad faces, holes, winding, nesting and overlaps."""
