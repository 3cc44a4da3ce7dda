# kRounding: CentreAxis::decide and separates, a height of two posed vertices along an axis, times |axis| and the bodies'
# reaches and translations.
#
# posed: product and three sums, √3 as a vector, c (translations by the last sum alone, t); turned: the axis in a body's frame,
# √3, twice, a; scan: two rounded products, s3; difference, d; product with the axis, p. Balls and centres: posed, difference
# and square, less.
# room: norm of the axis, products and sums, s.
# By hand: "terms", "rows", "vectors", "scan"; kTrustedLength covers what underflows.
u = 1b-53;
posed = sqrt(3)*4*u*c*l;
seen = 2*sqrt(3)*3*u*a*l + 2*3*u*s3*l + u*d*l + 3*u*p*l;
bound = @kRounding@*(1 + 12*u*s);
{ |c| <= 1.00000000000001 /\ |a| <= 1.00000000000001 /\ |s3| <= 1.00000000000001 /\ |d| <= 1 /\ |p| <= 1.00000000000001 /\
  |t| <= 1 /\ |s| <= 1.00000000000001 /\ l in [0,1.00001]
  -> posed + seen - bound <= 0 /\ u*t*l + u*d*l + 3*u*p*l - bound <= 0 }
