"""Which products a program forms inside the sums that use them, as fused multiply-add."""

from __future__ import annotations

from collections import defaultdict

from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, CONSTANT, INPUT, MUL, SUB


def fused_products(program: Program) -> dict[int, int]:
    """For each sum or difference that takes in a product: the position of that product.

    A product is taken in where every use of it is a sum that has not yet taken in another: then it is never formed on
    its own. Products used once come first, for they cost nothing twice. The choice depends on the program alone, so
    every processor rounds alike.
    """
    users: dict[int, list[int]] = defaultdict(list)
    for k, (op, a, b) in enumerate(program.operations):
        if op is not INPUT and op is not CONSTANT:
            users[a].append(k)
            if b is not None:
                users[b].append(k)
    outputs = set(program.outputs)
    products = [k for k, (op, _, _) in enumerate(program.operations) if op is MUL and k not in outputs]
    taken: dict[int, int] = {}
    for product in sorted(products, key=lambda k: len(users[k])):
        sums = users[product]
        fitting = all(program.operations[k][0] in (ADD, SUB) and k not in taken for k in sums)
        if fitting and len(set(sums)) == len(sums):
            taken.update(dict.fromkeys(sums, product))
    return taken
