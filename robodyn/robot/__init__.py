"""From a description to a model: URDF (urdf/), the tree of joints, poses, masses declared against shapes (masses/)."""
