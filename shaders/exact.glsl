// Error-free sums and products of floats (Dekker 1971, Knuth): a pair (high, low) is the number
// high + low, |low| at most half an ulp of high. `precise` keeps compilers from contracting.

vec2 AddExactly(float a, float b) {
  precise float sum = a + b;
  precise float b_part = sum - a;
  precise float a_part = sum - b_part;
  precise float error = (a - a_part) + (b - b_part);
  return vec2(sum, error);
}

vec2 SplitFloat(float a) {
  precise float scaled = 4097.0 * a;
  precise float high = scaled - (scaled - a);
  precise float low = a - high;
  return vec2(high, low);
}

// a b - product, exact unless something underflows.
float ProductError(float a, float b, float product) {
  vec2 x = SplitFloat(a), y = SplitFloat(b);
  precise float error = ((x.x * y.x - product) + x.x * y.y + x.y * y.x) + x.y * y.y;
  return error;
}

vec2 AddPairs(vec2 a, vec2 b) {
  vec2 high = AddExactly(a.x, b.x), low = AddExactly(a.y, b.y);
  precise float carry = high.y + low.x;
  vec2 sum = AddExactly(high.x, carry);
  precise float rest = sum.y + low.y;
  return AddExactly(sum.x, rest);
}

vec2 MultiplyPairs(vec2 a, vec2 b) {
  precise float product = a.x * b.x;
  precise float rest = ProductError(a.x, b.x, product) + (a.x * b.y + a.y * b.x);
  return AddExactly(product, rest);
}
