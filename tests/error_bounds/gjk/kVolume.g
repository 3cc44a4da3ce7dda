# kVolume: a determinant of three corners, times the largest |.|_1 to the third power.
#
# error: surely_inside, dot(a, cross(b, c)): product, difference, product, two sums, c.
# bound: largest: two sums of norm_1, three times; three products, s; and the sum with the other terms.
# By hand: "terms", with Σ |a_i b_j c_k| <= |a|_1 |b|_1 |c|_1. What underflows is below 1e-300, which is added.
u = 1b-53;
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 -> 5*u*c - @kVolume@*(1 + 11*u*s) <= 0 }
