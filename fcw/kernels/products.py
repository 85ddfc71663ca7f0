"""Sums of products of bytes that stay in registers: what convolutions and dense layers spend their time in.

LLVM turns the innermost of a kernel's loops into SIMD code, and loads and stores each sum at every step of
the loop around it. Here the code for a whole tile of sums is written out for LLVM, as in libraries for
matrices (Goto & van de Geijn, "Anatomy of high-performance matrix multiplication", 2008): each number that is
loaded is used for several sums, which are stored once, at their end.

Four bytes lie in a word, and a word's four products are added at once: by one instruction (VPDPBUSD) where
the processor has it, by two and the parting of words into pairs on other x86 ones, by plain arithmetic
elsewhere. Sums of integers are exact, and so the same on all of them.
"""

# ruff: noqa: ANN401 - numba's and llvmlite's own types

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils, config
from numba.core.codegen import get_host_cpu_features
from numba.extending import intrinsic

import fcw.kernels.jit  # noqa: F401 - tells the compiler of the processor

WORD_BYTES = 4


def _processor_features() -> frozenset[str]:
    settings: Any = config  # its attributes are made when it is loaded
    told: str | None = settings.CPU_FEATURES  # none at all with NUMBA_CPU_NAME=generic
    return frozenset((get_host_cpu_features() if told is None else told).split(","))


_FEATURES = _processor_features()
_REGISTERS = 3
# Numbers in a register, and rows of registers: as many sums as there is room for. LLVM knows instructions for
# the longest registers only where it is told to use them (`in_whole_registers`).
_LANES, TILE_ROWS = (16, 8) if {"+avx512bw", "-prefer-256-bit"} <= _FEATURES else (8, 4)
TILE_COLUMNS = _LANES * _REGISTERS

_HAS_ONE_INSTRUCTION = "+avxvnni" in _FEATURES or {"+avx512vnni", "+avx512vl"} <= _FEATURES
_HAS_PAIRS = "+avx2" in _FEATURES

_INDEX, _WORD, _HALF = ir.IntType(64), ir.IntType(32), ir.IntType(16)
_WORDS, _HALVES = ir.VectorType(_WORD, _LANES), ir.VectorType(_HALF, 2 * _LANES)
_code: Any = intrinsic  # by its type it would want the compiler's own argument of those who call


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

    sums[first_sum + r sum_pitch + c] is set to the sum over k, and the four bytes of each word, of
    values[first_value + offsets[k] + c] weights[first_weight + k weight_pitch + r].

    Args:
        values: flat int32, words of four bytes without a sign.
        first_value: intp, as all places and pitches, in words.
        offsets: (K,) intp; K is at least 1.
        weights: flat int32, words of four bytes with a sign.
        first_weight: place of the first product's first weight.
        weight_pitch: words from a product's weights to the next one's.
        sums: flat int32.
        first_sum: place of the tile's first sum.
        sum_pitch: elements from a row of the tile to the next.
    """
    return _signature(values, offsets, weights, sums), _write_tile


@_code
def sum_products_of_signed(
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
    """As `sum_products`, of values with a sign and weights without."""
    return _signature(values, offsets, weights, sums), _write_signed_tile


def _signature(values: Any, offsets: Any, weights: Any, sums: Any) -> Any:
    place = types.intp
    return types.void(values, place, offsets, weights, place, place, sums, place, place)


def _write_tile(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _write(context, builder, signature, arguments, False)


def _write_signed_tile(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _write(context, builder, signature, arguments, True)


def _write(context: Any, builder: Any, signature: Any, arguments: Any, signed_values: bool) -> Any:
    def pointer(array: int, first: Any) -> Any:
        data = context.make_array(signature.args[array])(context, builder, arguments[array]).data
        return builder.gep(data, [first])

    offset_array = context.make_array(signature.args[2])(context, builder, arguments[2])
    count = builder.extract_value(offset_array.shape, 0)
    values, weights, sums = (pointer(array, arguments[first]) for array, first in ((0, 1), (3, 4), (6, 7)))

    def in_register(base: Any, register: int) -> Any:
        place = builder.gep(base, [ir.Constant(_INDEX, register * _LANES)])
        return builder.bitcast(place, _WORDS.as_pointer())

    before, loop = builder.block, builder.append_basic_block("products")
    builder.branch(loop)
    builder.position_at_end(loop)
    k = builder.phi(_INDEX)
    k.add_incoming(ir.Constant(_INDEX, 0), before)
    tile = [[builder.phi(_WORDS) for _ in range(_REGISTERS)] for _ in range(TILE_ROWS)]
    row_of_values = builder.gep(values, [builder.load(builder.gep(offset_array.data, [k]))])
    loaded = [
        _parted(builder, builder.load(in_register(row_of_values, i), align=4), signed_values)
        for i in range(_REGISTERS)
    ]
    row_of_weights = builder.gep(weights, [builder.mul(k, arguments[5])])
    for row, row_of_sums in enumerate(tile):
        weight = builder.load(builder.gep(row_of_weights, [ir.Constant(_INDEX, row)]))
        everywhere = _parted(builder, _in_all_lanes(builder, weight), not signed_values)
        for i, total in enumerate(row_of_sums):
            unsigned, signed = (everywhere, loaded[i]) if signed_values else (loaded[i], everywhere)
            added = _with_products(builder, total, unsigned, signed)
            total.add_incoming(ir.Constant(_WORDS, [0] * _LANES), before)
            total.add_incoming(added, loop)
            row_of_sums[i] = added
    following = builder.add(k, ir.Constant(_INDEX, 1))
    k.add_incoming(following, loop)
    done = builder.append_basic_block("done")
    builder.cbranch(builder.icmp_signed("<", following, count), loop, done)
    builder.position_at_end(done)
    for row, row_of_sums in enumerate(tile):
        base = builder.gep(sums, [builder.mul(arguments[8], ir.Constant(_INDEX, row))])
        for i, total in enumerate(row_of_sums):
            builder.store(total, in_register(base, i), align=4)
    return context.get_dummy_value()


def _in_all_lanes(builder: Any, word: Any) -> Any:
    one = builder.insert_element(ir.Constant(_WORDS, ir.Undefined), word, ir.Constant(_WORD, 0))
    to_all = ir.Constant(ir.VectorType(_WORD, _LANES), [0] * _LANES)
    return builder.shuffle_vector(one, ir.Constant(_WORDS, ir.Undefined), to_all)


def _filled(vector: Any, number: int) -> Any:
    return ir.Constant(vector, [number] * vector.count)


def _parted(builder: Any, words: Any, signed: bool) -> list[Any]:
    """Words as `_with_products` takes them: whole, or their bytes in so many vectors of wider numbers."""
    if _HAS_ONE_INSTRUCTION:
        return [words]
    vector, width = (_HALVES, 16) if _HAS_PAIRS else (_WORDS, 32)
    shift = builder.ashr if signed else builder.lshr
    words = builder.bitcast(words, vector)
    return [
        shift(builder.shl(words, _filled(vector, width - 8 - first)), _filled(vector, width - 8))
        for first in range(0, width, 8)
    ]


def _with_products(builder: Any, total: Any, unsigned: list[Any], signed: list[Any]) -> Any:
    """To each lane of a total the products of a word's four bytes."""
    if _HAS_ONE_INSTRUCTION:
        name = f"llvm.x86.avx512.vpdpbusd.{32 * _LANES}"
        function = ir.FunctionType(_WORDS, [_WORDS] * 3)
        return builder.call(
            cgutils.get_or_insert_function(builder.module, function, name), [total, *unsigned, *signed]
        )
    for left, right in zip(unsigned, signed, strict=True):
        if _HAS_PAIRS:
            name = "llvm.x86.avx512.pmaddw.d.512" if _LANES == 16 else "llvm.x86.avx2.pmadd.wd"
            function = ir.FunctionType(_WORDS, [_HALVES] * 2)
            products = builder.call(
                cgutils.get_or_insert_function(builder.module, function, name), [left, right]
            )
        else:
            products = builder.mul(left, right)
        total = builder.add(total, products)
    return total
