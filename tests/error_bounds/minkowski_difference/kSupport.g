# kSupport: a height fl(d·ŵ), less that times r_P + r_R + |w|, is below that of all differences along d, for |d| = 1.
#
# turn:   d in a body's frame (rotate_back), an entry by a product and two sums, √3 as a vector, c; it moves the vertex
#         found and the lowest one.
# scan:   two rounded products of d and a vertex, s3; exact where a body has cells or levels.
# corner: as in kDifference.g, a b w.   product: d·ŵ, p.
# length: the norm of three squares (1.5u), its root, inverse and product with d: |d| is within 4.5u of 1, n. Heights as
#         distances, lower and depth: at most the sum of sizes, off by that.
# swell:  kInflationAlong times the swell, of both bodies, product and sum: 3 roundings, v, of what has to be |d| swell.
# size:   norm_1 and three sums, times the constant, plus kDenormalError, subtracted: s.
# By hand: "terms", "rows", "vectors", "scan" (README.md): the last says why one vertex of any number is enough.
u = 1b-53;
K = @kSupport@;
turn = 2*sqrt(3)*3*u*c*l;
scan = 2*3*u*s3*l;
corner = sqrt(3)*3*u*c2*l + u*a*l + u*b*l;
shift = u*w + u*b;
product = 3*u*p*l;
length = 4.5*u*n*l;
swell = (1 + 4.5*u*n) - @gjk/kInflationAlong@*(1 + 3*u*v);
bound = K*(1 + 9*u*s);
{ |c| <= 1.00000000000001 /\ |s3| <= 1.00000000000001 /\ |c2| <= 1.00000000000001 /\ |a| <= 1.00000000000001 /\
  |b| <= 1.00000000000001 /\ |w| <= 1 /\ |p| <= 1.00000000000001 /\ |n| <= 1.0000001 /\ |v| <= 1.00000000000001 /\
  |s| <= 1.00000000000001 /\ l in [0,1.000003]
  -> turn + scan + corner + product + length - bound <= 0 /\ shift + product + length - bound <= 0 /\
     turn + scan + corner + product + swell - bound <= 0 }
