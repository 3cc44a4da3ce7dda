# kFacetHeightError: what a face's height loses in doubles beside its normal's error, in units of |a|.
#
# norm:    three squares, half of it after the root, and the root: 2.5u, n; its inverse, i; the product with an entry, e.
# product: with a corner, p.   minus: the height less the bound, m.
# bound:   |a| rounded, products and sum: s.
# By hand: "terms" and "vectors" (README.md).
u = 1b-53;
{ |n| <= 1.0000001 /\ |i| <= 1.00000000000001 /\ |e| <= 1.00000000000001 /\ |p| <= 1.00000000000001 /\
  |m| <= 1.00000000000001 /\ |s| <= 1.00000000000001
  -> 2.5*u*n + u*i + u*e + 3*u*p + u*m - @kFacetHeightError@*(1 + 6*u*s) <= 0 }
