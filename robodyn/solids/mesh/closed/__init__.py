"""Whether a surface is closed and one shell, proven in one pass over its triangles."""
