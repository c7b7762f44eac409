"""Formulas that the program wrote itself, as a person would write them."""

from __future__ import annotations

import ast


def tidied(text: str) -> str:
    """A formula without signs, parentheses, factors and summands that change nothing.

    ``(((1*((+ (v)) - (+ (v))**3/6 + 0*(+ (v))**5/120)) - (w)))`` becomes ``v - v**3/6 - w``.

    Args:
        text: a formula that was accepted before; it is read as Python's grammar reads it, and not evaluated.
    """
    tree = _Tidier().visit(ast.parse(text.strip(), mode="eval"))
    shown = ast.unparse(tree)
    for operator in ("**", "*", "/"):
        shown = shown.replace(f" {operator} ", operator)
    return shown


class _Tidier(ast.NodeTransformer):
    """Leaves out ``+v``, ``1*v``, ``0*v`` and zeros that are added."""

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.UAdd) or _is(node.operand, 0):
            return node.operand
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        left, right = node.left, node.right
        match node.op:
            case ast.Mult() if _is(left, 0) or _is(right, 0):
                return ast.Constant(0)
            case ast.Mult() if _is(left, 1):
                return right
            case ast.Mult() | ast.Div() if _is(right, 1):
                return left
            case ast.Div() if _is(left, 0):
                return left
            case ast.Add() if _is(left, 0):
                return right
            case ast.Add() | ast.Sub() if _is(right, 0):
                return left
            case ast.Sub() if _is(left, 0):
                return ast.UnaryOp(ast.USub(), right)
        return node


def _is(node: ast.expr, value: int) -> bool:
    return isinstance(node, ast.Constant) and node.value == value and not isinstance(node.value, bool)
