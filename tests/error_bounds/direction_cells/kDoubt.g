# kDoubt: a candidate of a cell whose height is further than that below a leader's, along all corners, is not extreme there.
#
# x y z of two points in parts of the largest, 1 + 2^-50 for the quotient in doubles, rounded to floats; r c: a corner's
# entries, floats of a power of two, exact; heights as heights_of has them, their difference in floats. e: four times what a
# direction errs by, and points in doubles, below 2^-24 (static_assert).
# By hand: heights are linear over a cell, so corners are enough.
@single = float<ieee_32, ne>;
r = single(anyr);
c = single(anyc);
h1 = single(single(single(x1) + single(r*single(y1))) + single(c*single(z1)));
h2 = single(single(single(x2) + single(r*single(y2))) + single(c*single(z2)));
exact1 = x1 + r*y1 + c*z1;
exact2 = x2 + r*y2 + c*z2;
difference = single(h1 - h2);
{ |r| <= 1 /\ |c| <= 1 /\ |x1| <= 1.000000000000001 /\ |y1| <= 1.000000000000001 /\ |z1| <= 1.000000000000001 /\
  |x2| <= 1.000000000000001 /\ |y2| <= 1.000000000000001 /\ |z2| <= 1.000000000000001 /\ |e| <= 1b-24
  -> |((difference - (h1 - h2)) + ((h1 - exact1) - (h2 - exact2))) + e| <= @kDoubt@ }
