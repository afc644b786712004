"""Mass properties: the laws of inertia (inertia/), meshes (mesh/), and bodies composed of others."""
