# kBallRounding: ball_gap, posed centres, their distance and the radii, times all that enters.
#
# posed: product and three sums, √3 as a vector, twice, c; difference, d; norm, n; the radii's sums and products, r; two
# differences, e.
# By hand: "terms", "rows", "vectors"; kTrustedLength covers what underflows.
u = 1b-53;
{ |c| <= 1.00000000000001 /\ |d| <= 1 /\ |n| <= 1.0001 /\ |r| <= 1.00000000000001 /\ |e| <= 1.00000000000001 /\ |s| <= 1.00000000000001
  -> (sqrt(3)*4*u*c + u*d + 2.5*u*n + 5*u*r + 2*u*e)*(1 + 1e-5) - @kBallRounding@*(1 + 9*u*s) <= 0 }
