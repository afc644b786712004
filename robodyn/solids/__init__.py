"""Mass properties: the laws of inertia (inertia/) and meshes (mesh/); `mass_properties` is the door."""
