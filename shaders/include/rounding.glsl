// Rounding that is the same bits everywhere.
// Reads: its argument.
#ifndef SUBPIXEL_ROUNDING_GLSL
#define SUBPIXEL_ROUNDING_GLSL

// `x` with |x| < 2^22 to the nearest integer, ties to even, in the low 22 bits of the result (two's complement): adding
// 1.5 * 2^23 leaves it there, where lavapipe would convert one lane at a time.
uint round_to_even(float x) {
  precise float shifted = x + 12582912.0;
  return floatBitsToUint(shifted);
}

#endif
