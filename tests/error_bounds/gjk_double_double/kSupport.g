# kSupport: a height in DoubleDouble, less that times |d|_1 and the size, is below that of all differences along d.
#
# turn: d in a body's frame: product and two sums, c, √3 as a vector; it moves the vertex found and the lowest one, which are
#       compared exactly. corner: as in kDifference.g. product: d·w, p. size: in doubles, and norm_1 of the rounded d, s.
# By hand: "terms", "rows", "vectors", "scan".
u = 1b-53;
e = @double_double/kDoubleDoubleError@;
turn = 2*sqrt(3)*3*e*c*l;
corner = sqrt(3)*3*e*c2*l + e*a*l + 2*e*b*l;
product = 3*e*p*l;
bound = @kSupport@*(1 + 12*u*s);
{ |c| <= 1.00000000000001 /\ |c2| <= 1.00000000000001 /\ |a| <= 1 /\ |b| <= 1 /\ |p| <= 1.00000000000001 /\
  |s| <= 1.00000000000001 /\ l in [0,1.000003]
  -> turn + corner + product - bound <= 0 }
