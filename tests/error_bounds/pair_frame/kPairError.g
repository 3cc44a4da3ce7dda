# kPairError: what value > 1 + error and value < 1 − error have to allow, times r_Q (r_P + |w| + |c| + r_R), besides δ.
#
# (a) entries of fl(M_Rᵀ M_P) by a product and two sums, three times that in the Frobenius norm, m; map(): product and two
#     sums, √3 as a vector, p; the shift: t_P − t_R rounded, w; turned, product and two sums, √3, t; c subtracted, k; two sums
#     of map(), h.
# (b) the direction direction_a(q): product and two sums, √3, twice (vertex found and lowest one), d; scan: two rounded
#     products, s3; q·x: product and two sums, v. Over R: polar points by kPolarError; weights_of: a sum of eight (three
#     roundings), its inverse and product, 5, g; mixed(): product and three sums, but the first with 0, 4, j; 1 + error, o.
# (c) the same mixture of vertices, g and j; scan over the polar, s3; q·x, v; kPolarError.
# bound: the sizes' sums 5, constant, product, sums with the mixtures' part and 1: at most 12, s.
# δ: (1 + 1e-5) δ, times l for terms of second order, against 1.01 δ.
# By hand: "terms", "rows", "vectors", "mixture", "scan"; |q| <= r_Q (1 + 1e-9), in l; norm_1 is no less than a norm; r_Q r_R
# >= 1, and r_Q < 1e150, so that what underflows (2^-1075 a product, sizes above 1e-150) is below u² of the bound.
u = 1b-53;
K = @kPairError@;
polar = @polytope/kPolarError@;
matrix = 3*3*u*m*l;
mapped = sqrt(3)*3*u*p*l;
shift_w = u*w*l + sqrt(3)*3*u*t*l + u*k*l + 2*u*h*l;
shift_c = u*k*l + 2*u*h*l;
seen = 2*sqrt(3)*3*u*d*l + 2*3*u*s3*l + 3*u*v*l;
over_b = polar*l + 5*u*g*l + 4*u*j*l + u*o*l;
inside = 5*u*g*l + 4*u*j*l + 2*3*u*s3*l + 3*u*v*l + polar*l + u*o*l;
bound = K*(1 + 12*u*s);
{ |m| <= 1.00000000000001 /\ |p| <= 1.00000000000001 /\ |w| <= 1 /\ |t| <= 1.00000000000001 /\ |k| <= 1 /\
  |h| <= 1.00000000000001 /\ |d| <= 1.00000000000001 /\ |s3| <= 1.00000000000001 /\ |v| <= 1.00000000000001 /\
  |g| <= 1.00000000000001 /\ |j| <= 1.00000000000001 /\ |o| <= 1 /\ |s| <= 1.00000000000001 /\ l in [0,1.00002]
  -> matrix + mapped + seen - bound <= 0 /\ shift_w + 3*u*v*l - bound <= 0 /\ shift_c + 3*u*v*l - bound <= 0 /\
     over_b - bound <= 0 /\ matrix + mapped + inside - bound <= 0 /\ shift_w + inside - bound <= 0 /\
     shift_c + inside - bound <= 0 /\ (1 + 1e-5)*l - 1.01*(1 + 12*u*s) <= 0 }
