# kSideDoubleDoubleBound: sides and climbs in DoubleDouble; differences of coordinates are exact there.
#
# error: side_of: M (to − from) 2, X − Y: 2 and the offset and this difference, 4, product and difference, 2: c. finer_compare:
#        line 2, body_a 2, product and difference 2, weight and sum 2: as many. finer_mixed: products of two sides, each off
#        by the same part g of its permanent, and three operations more (of which the bound has as much again).
# bound: the permanent in doubles, at most 11 roundings and the constant, s; f: the high part rounded to a double.
# By hand: "terms". Sizes are above 1e-100, so that low parts are normal.
u = 1b-53;
e = @double_double/kDoubleDoubleError@;
K = @kSideDoubleDoubleBound@;
error = 8*e*c;
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 /\ |f| <= 1 /\ |d| <= 1.00000000000001
  -> error - K*(1 + 12*u*s) / (1 + u*f) <= 0 /\ error + 3*e*d - 2*K*(1 + 12*u*s) / (1 + u*f) <= 0 }
