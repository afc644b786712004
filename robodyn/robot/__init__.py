"""From a description to a model: URDF (urdf/), MJCF (mjcf/), SDF (sdf/), joints, poses, declared masses (masses/)."""
