# kCrossError: a cross product of two differences of vertices, times the sum of its terms' absolute values.
#
# error: PlanarSigns::meeting, planar_turn: two differences, product, difference, c (counted, as `meeting` hands it on).
# bound: products of rounded differences, sum, times the constant, added or compared, s.
# By hand: "terms". What underflows is below 2^-1074 of sizes above 1e-100.
u = 1b-53;
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 -> 4*u*c - @kCrossError@*(1 + 6*u*s) <= 0 }
