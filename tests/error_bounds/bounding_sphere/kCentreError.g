# kCentreError: a ball that is posed in floats, u = 2^-24, holds the body posed in doubles, and tests with it leave it open.
#
# An entry of the centre: pose and centre rounded, a product, two sums and the last one, 6, p, of |c|, c the centre in the
# link, sqrt(3) as a vector; t is at most |x| + |c|, so its rounding and that of the last sum, t, are 2u of |x| and 1u of |c|.
# radius_at: entries' sum 2, kCentreError a power of two, room, radius and product 3: s, on the parts of |x|, |c| and the radius.
# test: difference, squares, root, sums of radii and their square: 6 of the radius, d.
# By hand: "terms", "rows", "vectors"; poses in doubles are within 2^-40 of all this, in l; 1e-37 covers what underflows.
u = 1b-24;
K = @kCentreError@;
{ |p| <= 1.00001 /\ |t| <= 1 /\ |s| <= 1.00001 /\ |d| <= 1.00001 /\ l in [0,1.00002]
  -> sqrt(3)*(6 + 1)*u*p*l - K*(1 + K)*(1 - 3*u*s) <= 0 /\ sqrt(3)*2*u*t*l - K*(1 + K)*(1 - 6*u*s) <= 0 /\
     1 + 6*u*d - (1 + K)*(1 - 2*u*s) <= 0 }
