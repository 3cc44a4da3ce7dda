# kDeterminantError: a filter `|value| > kDeterminantError * size` decides a sign only where the exact value has it.
#
# error: orientation: three differences, product and difference of the cross product, product and first sum;
#        7 roundings of a term on its way, c; the value's own last rounding changes no sign, f.
# size:  the same eight and times the constant (cone_side has a difference less, turn none of u):
#        9 roundings of a term of the sum of absolute values, s, that with the constant included.
# lost:  products that underflow, 2^-1075 each times factors below 1e80, as part of a size above 1e-150.
# By hand: lemma "terms" (README.md), so that terms of sum 1 stand for all.
u = 1b-53;
error = 7*u*c + lost;
bound = @kDeterminantError@*(1 + 9*u*s) / (1 + u*f);
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 /\ |f| <= 1.00000000000001 /\ |lost| <= 1e-80
  -> error - bound <= 0 }
