"""Sums of products of bytes that stay in registers: the inner loops of convolutions and dense layers.

LLVM vectorises the innermost loop of a kernel, but loads and stores each sum at every step of the loop around
it. Here the code for a whole tile of sums is generated for LLVM, as in libraries for matrices (Goto & van de
Geijn, "Anatomy of high-performance matrix multiplication", 2008): each number that is loaded is used for
several sums, which are stored once, at the end.

A word has four bytes, and its four products are added at once: by one instruction (VPDPBUSD) if the processor
has it, by two after splitting words into pairs on other x86 processors, and by plain arithmetic elsewhere.
Weights are split beforehand (`as_weights`). Sums of integers are exact, and so the same on all processors.
"""

# ruff: noqa: ANN401 - numba's and llvmlite's own types

from enum import Enum
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils, config
from numba.core.codegen import get_host_cpu_features
from numba.extending import intrinsic
from numpy.typing import NDArray

import fcw.kernels.jit  # noqa: F401 - tells the compiler of the processor

WORD_BYTES = 4


def _processor_features() -> frozenset[str]:
    settings: Any = config  # its attributes are made when it is loaded
    told: str | None = settings.CPU_FEATURES  # none at all with NUMBA_CPU_NAME=generic
    return frozenset((get_host_cpu_features() if told is None else told).split(","))


_FEATURES = _processor_features()
_HAS_ONE_INSTRUCTION = "+avxvnni" in _FEATURES or {"+avx512vnni", "+avx512vl"} <= _FEATURES
_HAS_PAIRS = "+avx2" in _FEATURES


def in_pairs() -> bool:
    """Whether bytes are multiplied as pairs of 16-bit numbers, as the processor lacks VPDPBUSD."""
    return _HAS_PAIRS and not _HAS_ONE_INSTRUCTION


# Numbers in a register, and rows of registers. LLVM uses the longest registers only if it is told to
# (`in_whole_registers`).
_LANES, TILE_ROWS = (16, 8) if {"+avx512bw", "-prefer-256-bit"} <= _FEATURES else (8, 4)
# As many registers of sums as there is room for beside the values, whose pairs take four of 16 registers.
_REGISTERS = 2 if in_pairs() and _LANES == 8 else 3
TILE_COLUMNS = _LANES * _REGISTERS

_INDEX, _WORD = ir.IntType(64), ir.IntType(32)
_WORDS, _HALVES, _BYTES = (ir.VectorType(ir.IntType(bits), 32 * _LANES // bits) for bits in (32, 16, 8))


def as_weights(steps: NDArray[np.int8]) -> NDArray[np.int32]:
    """Weights in the form that `sum_products` reads: whole words, or words split into pairs as by `_parted`.

    Args:
        steps: (..., `WORD_BYTES`) in the order in which they are read.
    """
    if in_pairs():
        return steps[..., [0, 2, 1, 3]].astype(np.int16).reshape(-1).view(np.int32)
    return np.ascontiguousarray(steps).reshape(-1).view(np.int32)


_code: Any = intrinsic  # by its type, callers would have to pass the compiler's own argument


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
        values: flat int32, words of four unsigned bytes.
        first_value: index into `values`. All indices and pitches are intp.
        offsets: (K,) intp; K is at least 1.
        weights: `as_weights` of words of four signed bytes.
        first_weight: index of the first product's first weight, in words before they were split.
        weight_pitch: words, before they were split, from one product's weights to the next one's.
        sums: flat int32.
        first_sum: index of the tile's first sum.
        sum_pitch: elements from one row of the tile to the next.
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
    """Like `sum_products`, for signed values and unsigned weights, which are whole words."""
    return _signature(values, offsets, weights, sums), _write_signed_tile


@_code
def sum_products_of_pairs(
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
    """Like `sum_products`, for words of two signed 16-bit numbers; weights are such words, too."""
    return _signature(values, offsets, weights, sums), _write_tile_of_pairs


def _signature(values: Any, offsets: Any, weights: Any, sums: Any) -> Any:
    place = types.intp
    return types.void(values, place, offsets, weights, place, place, sums, place, place)


def _write_tile(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _write(context, builder, signature, arguments, _Words.UNSIGNED, _Words.PARTED)


def _write_signed_tile(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _write(context, builder, signature, arguments, _Words.SIGNED, _Words.UNSIGNED)


def _write_tile_of_pairs(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _write(context, builder, signature, arguments, _Words.PAIRS, _Words.PAIRS)


class _Words(Enum):
    """The contents of a word, or of the words that it was split into."""

    UNSIGNED = "four bytes without a sign"
    SIGNED = "four bytes with a sign"
    PARTED = "the latter, as `as_weights` gives them"
    PAIRS = "two numbers of 16 bits with a sign"


def _write(
    context: Any, builder: Any, signature: Any, arguments: Any, of_values: _Words, of_weights: _Words
) -> Any:
    def pointer(array: int, first: Any) -> Any:
        data = context.make_array(signature.args[array])(context, builder, arguments[array]).data
        return builder.gep(data, [first])

    def after(base: Any, place: int) -> Any:
        return builder.gep(base, [ir.Constant(_INDEX, place)])

    def in_register(base: Any, register: int) -> Any:
        return builder.bitcast(after(base, register * _LANES), _WORDS.as_pointer())

    together = 2 if of_weights is _Words.PARTED and in_pairs() else 1

    def in_words(place: Any) -> Any:
        return builder.mul(place, ir.Constant(_INDEX, together))

    offset_array = context.make_array(signature.args[2])(context, builder, arguments[2])
    count = builder.extract_value(offset_array.shape, 0)
    values, sums = pointer(0, arguments[1]), pointer(6, arguments[7])
    weights, weight_pitch = pointer(3, in_words(arguments[4])), in_words(arguments[5])

    before, loop = builder.block, builder.append_basic_block("products")
    builder.branch(loop)
    builder.position_at_end(loop)
    k = builder.phi(_INDEX)
    k.add_incoming(ir.Constant(_INDEX, 0), before)
    tile = [[builder.phi(_WORDS) for _ in range(_REGISTERS)] for _ in range(TILE_ROWS)]
    row_of_values = builder.gep(values, [builder.load(builder.gep(offset_array.data, [k]))])
    loaded = [
        _factors(builder, [builder.load(in_register(row_of_values, i), align=4)], of_values)
        for i in range(_REGISTERS)
    ]
    row_of_weights = builder.gep(weights, [builder.mul(k, weight_pitch)])
    for row, row_of_sums in enumerate(tile):
        words = [builder.load(after(row_of_weights, row * together + i)) for i in range(together)]
        everywhere = _factors(builder, [_in_all_lanes(builder, word) for word in words], of_weights)
        for i, total in enumerate(row_of_sums):
            left, right = (everywhere, loaded[i]) if of_values is _Words.SIGNED else (loaded[i], everywhere)
            added = _with_products(builder, total, left, right)
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


def _factors(builder: Any, words: list[Any], what: _Words) -> list[Any]:
    """Words as `_with_products` takes them: bytes, or vectors of numbers as wide as are multiplied."""
    vector = _HALVES if _HAS_PAIRS else _WORDS
    if what is _Words.PAIRS:
        return [builder.bitcast(words[0], vector)] if _HAS_PAIRS else _parted(builder, words[0], 16, True)
    if _HAS_ONE_INSTRUCTION:
        return [builder.bitcast(words[0], _BYTES)]
    if what is _Words.PARTED and _HAS_PAIRS:
        return [builder.bitcast(word, vector) for word in words]
    # On other processors, too, LLVM multiplies faster if it can tell that the numbers have few bits.
    return _parted(builder, builder.bitcast(words[0], vector), 8, what is not _Words.UNSIGNED)


def _parted(builder: Any, numbers: Any, bits: int, signed: bool) -> list[Any]:
    """Split the numbers of a vector into fields of some bits, each in its own vector, the lowest first."""
    shift, width = builder.ashr if signed else builder.lshr, numbers.type.element.width
    return [
        shift(
            builder.shl(numbers, _filled(numbers.type, width - bits - first)),
            _filled(numbers.type, width - bits),
        )
        for first in range(0, width, bits)
    ]


def _with_products(builder: Any, total: Any, left: list[Any], right: list[Any]) -> Any:
    """Add the products of a lane's numbers to its total; if they are bytes, the left ones are unsigned."""
    for one, other in zip(left, right, strict=True):
        if one.type == _WORDS:
            total = builder.add(total, builder.mul(one, other))
        elif one.type == _BYTES:
            name = f"llvm.x86.avx512.vpdpbusd.{32 * _LANES}"
            as_words = [builder.bitcast(numbers, _WORDS) for numbers in (one, other)]
            total = _call(builder, name, [total, *as_words])
        else:
            name = "llvm.x86.avx512.pmaddw.d.512" if _LANES == 16 else "llvm.x86.avx2.pmadd.wd"
            total = builder.add(total, _call(builder, name, [one, other]))
    return total


def _call(builder: Any, name: str, arguments: list[Any]) -> Any:
    function = ir.FunctionType(_WORDS, [argument.type for argument in arguments])
    return builder.call(cgutils.get_or_insert_function(builder.module, function, name), arguments)
