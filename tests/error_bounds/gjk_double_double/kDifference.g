# kDifference: a corner's difference in DoubleDouble, as a vector, times the pair's size.
#
# turned: corner_at, turn: three products and two sums, c, √3 as a vector; two more sums, a and b; the shift's rounding, b.
# inside: as in gjk/kDifference.g, with x the part that the true error is of the constant.
# size:   in doubles, s.
# By hand: "terms", "rows", "vectors". Below the size's range nothing is trusted.
u = 1b-53;
e = @double_double/kDoubleDoubleError@;
bound = @kDifference@*(1 + 8*u*s);
turned = sqrt(3)*3*e*c*l + e*a*l + 2*e*b*l;
{ |c| <= 1.00000000000001 /\ |a| <= 1 /\ |b| <= 1 /\ |s| <= 1.00000000000001 /\ l in [0,1.000002]
  -> turned - 0.6*bound <= 0 /\ e*b - bound <= 0 }
