# kSideBound: a filter `|value| > kSideBound * size` decides a sign only where the exact value has it.
#
# error: PlanarSigns::side: (M (to − from)) 3, (X − Y) 4 (product, two sums and this difference), product and difference;
#        9 roundings of a term on its way, c; the value's own last rounding changes no sign, f.
# size:  line.size_dx 3, point.size_y 3, their sum, product, sum, and times the constant:
#        10 roundings of a term of the sum of absolute values, s, that with the constant included.
# lost:  products that underflow, 2^-1075 each times sizes below 1e100, as part of a size above 1e-100.
# By hand: lemma "terms" (README.md), so that terms of sum 1 stand for all.
u = 1b-53;
error = 9*u*c + lost;
bound = @kSideBound@*(1 + 10*u*s) / (1 + u*f);
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 /\ |f| <= 1.00000000000001 /\ |lost| <= 1e-110
  -> error - bound <= 0 }
