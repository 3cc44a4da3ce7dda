# kPlaneError: what a face's height over the origin loses with its normal N in doubles, in units of |a| E / |N|.
#
# normal: differences of corners, d, and two products with their difference, p: 4u of |x_i y_j| + |x_j y_i| an entry, √2 of
#         that as a vector; once in a·N and once in |N|, of which the height is no more than |a|.
# bound:  two squared lengths and their root, the norm's inverse, |a| rounded, products and sum: s.
# By hand: the entries' bound as a vector, Σ (|x_i y_j| + |x_j y_i|)² <= 2 |x|² |y|² for the three pairs of axes i, j.
u = 1b-53;
normal = sqrt(2)*2*u*d + sqrt(2)*2*u*p;
{ |d| <= 1.00000000000001 /\ |p| <= 1.00000000000001 /\ |s| <= 1.00000000000001
  -> 2*normal - @kPlaneError@*(1 + 16*u*s) <= 0 }
