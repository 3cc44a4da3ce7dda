# kMixing: a mixture of four corners with weights of sum W, times W and the size.
#
# corner: as in kDifference.g. mixed: product and three sums, m (the first sum, with 0, is exact). whole: three sums, w.
# size: in doubles, s; in `measure` kLengthRounding is for lengths and sums of weights in doubles.
# By hand: "terms"; any positive weights are weights ("mixture").
u = 1b-53;
e = @double_double/kDoubleDoubleError@;
corner = sqrt(3)*3*e*c*l + e*a*l + 2*e*b*l;
mixed = 4*e*m*l + 3*e*w*l;
bound = @kMixing@*(1 + 12*u*s);
{ |c| <= 1.00000000000001 /\ |a| <= 1 /\ |b| <= 1 /\ |m| <= 1.00000000000001 /\ |w| <= 1.00000000000001 /\
  |s| <= 1.00000000000001 /\ l in [0,1.000003]
  -> corner + mixed - bound <= 0 }
