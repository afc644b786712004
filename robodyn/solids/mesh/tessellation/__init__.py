"""What facets leave out of the smooth body that they may stand for."""
