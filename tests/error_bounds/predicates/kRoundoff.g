# kRoundoff, u: every operation on doubles gives its exact result z (or x + y) times 1 + u e, |e| <= 1.
#
# z: of a product, quotient or square root in the normal range. Sums need none: what is below it is exact. A product
# below the normal range is off by 2^-1075 at most: each filter names the term that covers it.
@rnd = float<ieee_64, ne>;
x = rnd(anyx);
y = rnd(anyy);
{ |z| in [1b-1021,1b1023] /\ |small| <= 1b-1021 /\ |x| <= 1b1000 /\ |y| <= 1b1000
  -> |rnd(z) -/ z| <= @kRoundoff@ /\ |rnd(x + y) -/ (x + y)| <= @kRoundoff@ /\ |rnd(small) - small| <= 1b-1075 }
