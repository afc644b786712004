"""Mesh files of all formats as triangles, with errors that name the line."""
