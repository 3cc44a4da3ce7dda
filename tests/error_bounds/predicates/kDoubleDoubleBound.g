# kDoubleDoubleBound: a filter `|value| > kDoubleDoubleBound * size` decides a sign only where the exact value has it.
#
# error: wedge_side in DoubleDouble, the longest: product, difference, product, difference, product, two sums;
#        7 roundings of a term on its way, c; the value's own last rounding changes no sign, f.
# size:  in doubles as above:
#        10 roundings of a term of the sum of absolute values, s, that with the constant included.
# lost:  nothing: sizes are above 1e-150, so that low parts are normal.
# By hand: lemma "terms" (README.md), so that terms of sum 1 stand for all.
u = 1b-53;
e = @double_double/kDoubleDoubleError@;
error = 7*e*c + lost;
bound = @kDoubleDoubleBound@*(1 + 10*u*s) / (1 + u*f);
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 /\ |f| <= 1.00000000000001 /\ |lost| <= 1e-80
  -> error - bound <= 0 }
