# kFinePlaneError: as kPlaneError, with N and a·N in double-double, of which an operation errs by e; in units of |a| E / |N|.
#
# normal:  products and their difference of exact differences, n: 2e an entry, √2 of that as a vector, twice.
# product: with a corner, p: e, and two sums, each e of what it adds: 3e |a| |N|, and |N| <= E.
# bound:   two norms and their product, quotient, |a|, product, sum: s.
e = @double_double/kDoubleDoubleError@;
u = 1b-53;
{ |n| <= 1.00000000000001 /\ |p| <= 1.00000000000001 /\ |s| <= 1.00000000000001
  -> 2*sqrt(2)*3*e*n + 4*e*p - @kFinePlaneError@*(1 + 16*u*s) <= 0 }
