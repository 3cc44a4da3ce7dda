# kCompareBound: a filter `|value| > kCompareBound * size` decides a sign only where the exact value has it.
#
# error: climb: line 3, weight and sum 2, Mᵀ 2, difference, product (the last sum is not counted);
#        9 roundings of a term on its way, c; the value's own last rounding changes no sign, f.
# size:  the same, with the last sum, and times the constant:
#        11 roundings of a term of the sum of absolute values, s, that with the constant included.
# lost:  products that underflow, 2^-1075 each times sizes below 1e100, as part of a size above 1e-100.
# By hand: lemma "terms" (README.md), so that terms of sum 1 stand for all.
u = 1b-53;
error = 9*u*c + lost;
bound = @kCompareBound@*(1 + 11*u*s) / (1 + u*f);
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 /\ |f| <= 1.00000000000001 /\ |lost| <= 1e-110
  -> error - bound <= 0 }
