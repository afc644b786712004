"""What rules ask of a description beyond `robodyn.robot.urdf.view`: URDF's grammar, the tree of links, the SRDF."""
