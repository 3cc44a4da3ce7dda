# kHeightRounding: raise_lower_bound, a height in DoubleDouble divided by |d|, in doubles, times the height.
#
# d rounded to doubles, its norm (2.5u), the height's high part, the quotient; the subtractions and the product that follow: n.
u = 1b-53;
{ |d| <= 1 /\ |n| <= 1 /\ |h| <= 1 /\ |q| <= 1 /\ |s| <= 1.00000000000001
  -> u*d + 2.5001*u*n + u*h + u*q + 2*u*s - @kHeightRounding@*(1 + 4*u*s) <= 0 }
