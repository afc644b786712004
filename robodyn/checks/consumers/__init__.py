"""What other programs make of a description."""
