# kNormAbove: NearestPoints::shared, |v| is at most norm(v) times this.
#
# norm: three squares (product and two sums, half of it after the root) and the root; the product and sum that follow, and
# the swell's own sum: n and c.
u = 1b-53;
{ |n| <= 1.00000000000001 /\ |c| <= 1.00000000000001 -> 1 - @kNormAbove@*(1 + 2.5*u*n)*(1 + 3*u*c) <= 0 }
