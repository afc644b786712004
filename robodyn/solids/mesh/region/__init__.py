"""What overlapping or open surfaces enclose: columns of winding numbers, with error bars."""
