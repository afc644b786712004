"""SDF -> Description."""
