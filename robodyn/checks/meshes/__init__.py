"""Files of meshes: where they are, what is in them, the units they are in."""
