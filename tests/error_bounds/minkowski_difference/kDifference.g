# kDifference: a corner's difference fl(fl(M_P p) − fl(M_R r)) + fl(t_P − t_R)), as a vector, times r_P + r_R + |w|.
#
# turned: an entry of M p by a product and two sums, c, of Σ |m p| <= |row| |p|; √3 of that as a vector (MinkowskiDifference,
#         corner); both subtractions round what was turned, a and b.
# shift:  t_P − t_R rounded, w; and the second subtraction.
# mixed:  NearestPoints::shared and descend allow twice the constant for a mixture of four: its corners, products and
#         sums, m, the weights' sum (quotient and three sums), g, a norm, n (kNormAbove is for `shared` besides).
# size:   norm_1 and three sums, times the constant, plus kDenormalError, s.
# inside: determinants of three corners, each off by x = 0.6 of `error` in units of the largest |.|_1, L: 3 error L² exceeds
#         what that makes of one, up to x = 1/5; beyond, 3 error L² is more than L³.
# By hand: "terms", "rows" and "vectors" (README.md); |row| and |column| <= 1 + 2e-6 (l). kDenormalError: underflow.
u = 1b-53;
K = @kDifference@;
turned = sqrt(3)*3*u*c*l + u*a*l + u*b*l;
shift = u*w + u*b;
bound = K*(1 + 8*u*s);
mixture = 4*u*m*l + 4*u*g*l;
{ |c| <= 1.00000000000001 /\ |a| <= 1.00000000000001 /\ |b| <= 1.00000000000001 /\ |w| <= 1 /\ |s| <= 1.00000000000001 /\
  |m| <= 1.00000000000001 /\ |g| <= 1.00000000000001 /\ |n| <= 4.5001 /\ l in [0,1.000002] /\ x in [0,0.2]
  -> turned - bound <= 0 /\ shift - bound <= 0 /\ turned - 0.6001*bound <= 0 /\
     turned + mixture + u*n*l - 2*bound <= 0 /\ shift + mixture + u*n*l - 2*bound <= 0 /\
     3 + 3*x + x*x - 3 / 0.6001 <= 0 /\ 1 - 3*0.2 / 0.6001 <= 1e-3 }
