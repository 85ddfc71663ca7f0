"""Sums of products that stay in registers: what convolutions and dense layers spend their time in.

LLVM turns the innermost of a kernel's loops into SIMD code, and loads and stores each sum at every step of
the loop around it. Here the code for a whole tile of sums is written out for LLVM, as in libraries for
matrices (Goto & van de Geijn, "Anatomy of high-performance matrix multiplication", 2008): each number that is
loaded is used for several sums, which are stored once, at their end.
"""

# ruff: noqa: ANN401 - numba's own types

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import config
from numba.core.codegen import get_host_cpu_features
from numba.extending import intrinsic

import fcw.kernels.jit  # noqa: F401 - tells the compiler of the processor


def _tile_shape() -> tuple[int, int, int]:
    """Numbers in a register, registers side by side, and rows of them: as many sums as there is room for."""
    settings: Any = config  # its attributes are made when it is loaded
    features = settings.CPU_FEATURES or get_host_cpu_features()
    return (16, 3, 8) if "+avx512f" in features.split(",") else (8, 3, 4)


_code: Any = intrinsic  # by its type it would want the compiler's own argument of those who call
_LANES, _REGISTERS, TILE_ROWS = _tile_shape()
TILE_COLUMNS = _LANES * _REGISTERS


@_code
def sum_products(
    _context: Any,
    values: Any,
    first_value: Any,
    offsets: Any,
    weights: Any,
    first_weight: Any,
    weight_pitch: Any,
    sums: Any,
    first_sum: Any,
    sum_pitch: Any,
) -> Any:
    """A tile of `TILE_ROWS` by `TILE_COLUMNS` sums, for kernels to call; bounds are not checked.

    sums[first_sum + r sum_pitch + c] is set to the sum over k of
    values[first_value + offsets[k] + c] weights[first_weight + k weight_pitch + r].

    Args:
        values: flat float32.
        first_value: intp, as all places and pitches.
        offsets: (K,) intp; K is at least 1.
        weights: flat float32.
        first_weight: place of the first product's first weight.
        weight_pitch: elements from a product's weights to the next one's.
        sums: flat float32.
        first_sum: place of the tile's first sum.
        sum_pitch: elements from a row of the tile to the next.
    """
    place = types.intp
    signature = types.void(values, place, offsets, weights, place, place, sums, place, place)
    return signature, _write_tile


def _write_tile(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    def pointer(array: int, first: Any) -> Any:
        data = context.make_array(signature.args[array])(context, builder, arguments[array]).data
        return builder.gep(data, [first])

    index, lane = ir.IntType(64), ir.IntType(32)
    vector = ir.VectorType(ir.FloatType(), _LANES)
    undefined, to_all_lanes = ir.Constant(vector, ir.Undefined), ir.VectorType(lane, _LANES)
    offset_array = context.make_array(signature.args[2])(context, builder, arguments[2])
    count = builder.extract_value(offset_array.shape, 0)
    values, weights, sums = (pointer(array, arguments[first]) for array, first in ((0, 1), (3, 4), (6, 7)))

    def in_register(base: Any, register: int) -> Any:
        return builder.bitcast(
            builder.gep(base, [ir.Constant(index, register * _LANES)]), vector.as_pointer()
        )

    before, loop = builder.block, builder.append_basic_block("products")
    builder.branch(loop)
    builder.position_at_end(loop)
    k = builder.phi(index)
    k.add_incoming(ir.Constant(index, 0), before)
    tile = [[builder.phi(vector) for _ in range(_REGISTERS)] for _ in range(TILE_ROWS)]
    row_of_values = builder.gep(values, [builder.load(builder.gep(offset_array.data, [k]))])
    loaded = [builder.load(in_register(row_of_values, i), align=4) for i in range(_REGISTERS)]
    row_of_weights = builder.gep(weights, [builder.mul(k, arguments[5])])
    for row, row_of_sums in enumerate(tile):
        weight = builder.load(builder.gep(row_of_weights, [ir.Constant(index, row)]))
        everywhere = builder.shuffle_vector(
            builder.insert_element(undefined, weight, ir.Constant(lane, 0)),
            undefined,
            ir.Constant(to_all_lanes, [0] * _LANES),
        )
        for i, total in enumerate(row_of_sums):
            product = builder.fmul(loaded[i], everywhere, flags=("contract",))
            added = builder.fadd(total, product, flags=("contract",))  # one instruction
            total.add_incoming(ir.Constant(vector, [0.0] * _LANES), before)
            total.add_incoming(added, loop)
            row_of_sums[i] = added
    following = builder.add(k, ir.Constant(index, 1))
    k.add_incoming(following, loop)
    done = builder.append_basic_block("done")
    builder.cbranch(builder.icmp_signed("<", following, count), loop, done)
    builder.position_at_end(done)
    for row, row_of_sums in enumerate(tile):
        base = builder.gep(sums, [builder.mul(arguments[8], ir.Constant(index, row))])
        for i, total in enumerate(row_of_sums):
            builder.store(total, in_register(base, i), align=4)
    return context.get_dummy_value()
