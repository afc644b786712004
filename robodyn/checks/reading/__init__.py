"""What a description says, as far as it can be read: links, joints, numbers, the tree, the names in an SRDF."""
