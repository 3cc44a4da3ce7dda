# kRoundUp: |v| is at most norm_at_any_scale(v) times this, rounded.
#
# v / largest, three squares (1.5u after the root), the root, times largest: n; the product with the constant, p. A difference
# that was rounded before (body.cpp, largest_norm: p − from) is one more, d.
u = 1b-53;
{ |n| <= 1.00000000000001 /\ |p| <= 1 /\ |d| <= 1 -> 1 - @kRoundUp@*(1 + 4.5*u*n)*(1 + u*p)*(1 + u*d) <= 0 }
