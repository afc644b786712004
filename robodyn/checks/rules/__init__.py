"""A file for each family of rules, a function for each rule, with its documentation and examples."""
