# kSinCosError: a sine or cosine in floats (cpp/broad_phase/float_sincos.hpp), u = 2^-24, once the quarters of a turn are taken
# off in doubles: r, |r| <= pi/4 up to the quarter's own rounding, which errs by 2^-32; x, that in floats; r >= 0, for both are
# even or odd.
#
# By hand: sin x = x + x z (S + p), cos x = 1 - z/2 + z^2 (C + q), p and q the polynomials' own errors (float_sincos.hpp); sines
# of x and r differ by at most |x - r|, cosines by sin(pi/4) of it: e and f. g: the reduction. The fused ones are those of
# AVX-512, where a product that is added is not rounded.
@rnd = float<ieee_32, ne>;
u = 1b-24;
x = rnd(r);
z = rnd(x*x);
s2 = rnd(17894440b-31 + rnd(z*-26921392b-37));
s1 = rnd(-22369618b-27 + rnd(z*s2));
computed_sine = rnd(x + rnd(x*rnd(z*s1)));
c2 = rnd(-23860946b-34 + rnd(z*26990748b-40));
c1 = rnd(22369620b-29 + rnd(z*c2));
o = rnd(1 - rnd(0.5*z));
computed_cosine = rnd(o + rnd(rnd(z*z)*c1));
fs2 = rnd(17894440b-31 + z*-26921392b-37);
fs1 = rnd(-22369618b-27 + z*fs2);
fused_sine = rnd(x + x*rnd(z*fs1));
fc2 = rnd(-23860946b-34 + z*26990748b-40);
fc1 = rnd(22369620b-29 + z*fc2);
fused_cosine = rnd(o + rnd(z*z)*fc1);
Z = x*x;
S2 = 17894440b-31 + Z*-26921392b-37;
S1 = -22369618b-27 + Z*S2;
sine = x + x*(Z*S1);
C2 = -23860946b-34 + Z*26990748b-40;
C1 = 22369620b-29 + Z*C2;
cosine = (1 - 0.5*Z) + Z*Z*C1;
{ r in [1b-20,0.785398164] /\ |p| <= 2.5e-8 /\ |q| <= 2.5e-9 /\ |e| <= 1 /\ |f| <= 0.70711 /\ |g| <= 1b-32
  -> |(computed_sine - sine) + (x*Z*p + e*(x - r) + g)| <= @kSinCosError@ /\
     |(computed_cosine - cosine) + (Z*Z*q + f*(x - r) + g)| <= @kSinCosError@ /\
     |(fused_sine - sine) + (x*Z*p + e*(x - r) + g)| <= @kSinCosError@ /\
     |(fused_cosine - cosine) + (Z*Z*q + f*(x - r) + g)| <= @kSinCosError@ }
computed_cosine - cosine -> (computed_cosine - (o + rnd(rnd(z*z)*c1))) + ((o - (1 - rnd(0.5*z))) - (rnd(0.5*z) - 0.5*z) - 0.5*(z - Z) + (rnd(rnd(z*z)*c1) - Z*Z*C1));
fused_cosine - cosine -> (fused_cosine - (o + rnd(z*z)*fc1)) + ((o - (1 - rnd(0.5*z))) - (rnd(0.5*z) - 0.5*z) - 0.5*(z - Z) + (rnd(z*z)*fc1 - Z*Z*C1));
$ r in (1b-6, 0.125, 0.25, 0.375, 0.5, 0.625, 0.7);
