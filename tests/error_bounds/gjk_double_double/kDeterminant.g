# kDeterminant: a determinant of three corners in DoubleDouble, times the largest |.|_1 to the third power.
#
# error: tetrahedron(): product, difference, product, two sums, c; f: the high part. bound: in doubles, s.
# By hand: "terms", with Σ |a_i b_j c_k| <= |a|_1 |b|_1 |c|_1.
u = 1b-53;
e = @double_double/kDoubleDoubleError@;
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 /\ |f| <= 1
  -> 5*e*c - @kDeterminant@*(1 + 14*u*s) / (1 + u*f) <= 0 }
