# kDoubleDoubleError: a sum and a product of DoubleDouble (double_double.hpp, operator+ and operator*).
#
# Sum: scaled by a power of two so that the larger of |a| and |b| is at most 1 and at least 1/2; the error is then held
# against 1/2 <= |a| + |b|. s, sl: two_sum(a.high, b.high); t, tl: two_sum(a.low, b.low); v, w: quick_two_sum(s, sl + t);
# the last quick_two_sum adds without error.
# Product: scaled so that both factors are in [1, 2], low parts being half a unit in the last place, as quick_two_sum leaves
# them; q: what is left of a b but for the product of both low parts. (gjk_double_double.cpp, measure, divides weights: their low
# parts may be twice that, and a product's error a quarter more, which kMixing has room for five times over.)
# By hand: two_sum, quick_two_sum and two_product are exact (Knuth; Dekker; for quick_two_sum(s, c) here: Joldes, Muller
# and Popescu 2017, "Tight and rigorous error bounds for basic building blocks of double-word arithmetic", theorem 3.1),
# so that their low parts are written as exact differences. A product's low part underflows where |a b| < 2^-969: the
# filters trust no size below 1e-150.
@rnd = float<ieee_64, ne>;
s = rnd(ah + bh);
sl = -(s - (ah + bh));
t = rnd(al + bl);
tl = -(t - (al + bl));
c = rnd(sl + t);
v = rnd(s + c);
w = -(v - (s + c));
low = rnd(tl + w);
sum = v + low;
p = rnd(fh*gh);
pl = -(p - fh*gh);
qa = rnd(fh*gl);
qb = rnd(fl*gh);
q = rnd(qa + qb);
r = rnd(pl + q);
product = p + r;
{ |ah| <= 1 /\ |bh| <= 1 /\ |al| <= 1b-53 /\ |bl| <= 1b-53 /\
  fh in [1,2] /\ gh in [1,2] /\ |fl| <= 1b-53 /\ |gl| <= 1b-53
  -> |2*(sum - (ah + al + bh + bl))| <= @kDoubleDoubleError@ /\
     |(product - (fh + fl)*(gh + gl)) * (1 + 1b-50)| <= @kDoubleDoubleError@ }
sum - (ah + al + bh + bl) -> (low - (tl + w)) + (c - (sl + t));
product - (fh + fl)*(gh + gl) -> (r - (pl + q)) + (q - (qa + qb)) + (qa - fh*gl) + (qb - fl*gh) - fl*gl;
