"""JSON of every result: stable keys, SI units, full precision."""
