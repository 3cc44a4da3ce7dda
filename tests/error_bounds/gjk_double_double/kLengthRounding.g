# kLengthRounding: measure, |mixture| / whole in doubles, times itself.
#
# high parts, a norm (4u with its scaling), the weights' high parts and three sums, the quotient, and what follows.
u = 1b-53;
{ |m| <= 1 /\ |n| <= 1 /\ |w| <= 1 /\ |q| <= 1 /\ |s| <= 1.00000000000001
  -> u*m + 4.0001*u*n + 4.0001*u*w + u*q + 2*u*s - @kLengthRounding@*(1 + 3*u*s) <= 0 }
