# kMixtureError: of one more game of the walk, in q or x as a part of r_Q or of r_P + |shift|.
#
# normalise() of 16 weights: 15 sums and a quotient, w; play(): product and 15 sums, the first with 0 exact, 16, p; towards():
# 1 − t, product and sum, t: of what was mixed before and what is mixed now the larger, and that.
# bound: as in kPairError.g, s.
# By hand: "terms", "mixture"; over games the errors add up at most, so `mixtures` times the constant.
u = 1b-53;
{ |w| <= 1.00000000000001 /\ |p| <= 1.00000000000001 /\ |t| <= 1.00000000000001 /\ |s| <= 1.00000000000001 /\ l in [0,1.00002]
  -> (16*u*w + 16*u*p + 3*u*t)*l - @kMixtureError@*(1 + 12*u*s) <= 0 }
