# kDifferenceError: a filter `|value| > kDifferenceError * size` decides a sign only where the exact value has it.
#
# error: compare_block: difference, product, first sum;
#        3 roundings of a term on its way, c; the value's own last rounding changes no sign, f.
# size:  difference, product, two sums, times the constant, plus kUnderflow:
#        6 roundings of a term of the sum of absolute values, s, that with the constant included.
# lost:  nothing: products that underflow are below kUnderflow, which is added.
# By hand: lemma "terms" (README.md), so that terms of sum 1 stand for all.
u = 1b-53;
error = 3*u*c + lost;
bound = @kDifferenceError@*(1 + 6*u*s) / (1 + u*f);
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 /\ |f| <= 1.00000000000001 /\ |lost| <= 1e-80
  -> error - bound <= 0 }
