# _SINCOS u: a computed cosine or sine (cpp/math/sincos.hpp), once the quarters of a turn are taken off: |r| <= pi/4, up to the
# quarter's own rounding (an angle of 1e6 rad by u), and a tail of half an ulp of r; r >= 0, for both are even or odd.
#
# s c: the polynomials, an operation each. w: what is added to 1 - z/2.
# By hand: sin r = r + r z (S + p), cos r = 1 - z/2 + z^2 (C + q), p and q the polynomials' own errors (sincos.hpp), f and g
# what cos r and sin r differ by from 1 - z/2 and r, k the tail's square; the reduced angle errs by u / 1000, e.
@rnd = float<ieee_64, ne>;
u = 1b-53;
r = rnd(anyr);
t = rnd(anyt);
z = rnd(r*r);
h = 0.5*z;
o = rnd(1 - h);
s5 = rnd(-1892809991408409b-76 + rnd(z*3079011286618233b-84));
s4 = rnd(1626696823951553b-69 + rnd(z*s5));
s3 = rnd(-3660068267760651b-64 + rnd(z*s4));
s2 = rnd(2401919801263577b-58 + rnd(z*s3));
s1 = rnd(-6004799503160661b-55 + rnd(z*s2));
computed_sine = rnd(r + rnd(rnd(rnd(r*z)*s1) + rnd(t*o)));
c5 = rnd(2523771209062315b-80 + rnd(z*-7045502782662705b-89));
c4 = rnd(-5205430057562425b-74 + rnd(z*c5));
c3 = rnd(1830034134088301b-66 + rnd(z*c4));
c2 = rnd(-6405119470037351b-62 + rnd(z*c3));
c1 = rnd(6004799503160661b-57 + rnd(z*c2));
rest = rnd(rnd(1 - o) - h);
w = rnd(rnd(rnd(z*z)*c1) - rnd(r*t));
v = rnd(rest + w);
computed_cosine = rnd(o + v);
Z = r*r;
S5 = -1892809991408409b-76 + Z*3079011286618233b-84;
S4 = 1626696823951553b-69 + Z*S5;
S3 = -3660068267760651b-64 + Z*S4;
S2 = 2401919801263577b-58 + Z*S3;
S1 = -6004799503160661b-55 + Z*S2;
sine = r + (r*Z*S1 + t*(1 - 0.5*Z));
C5 = 2523771209062315b-80 + Z*-7045502782662705b-89;
C4 = -5205430057562425b-74 + Z*C5;
C3 = 1830034134088301b-66 + Z*C4;
C2 = -6405119470037351b-62 + Z*C3;
C1 = 6004799503160661b-57 + Z*C2;
W = Z*Z*C1 - r*t;
cosine = 1 - 0.5*Z + W;
{ r in [0,0.7853981635] /\ |t| <= 1b-54 /\ |p| <= 3.2e-17 /\ |q| <= 2.4e-18 /\ f in [0,0.0159] /\ |g| <= 0.081 /\ |k| <= 1b-108 /\ |e| <= 1
  -> |((computed_sine - sine) - (r*Z*p + t*f + k + 0.001*u*e))/u| <= @_SINCOS@ /\
     |((computed_cosine - cosine) - (Z*Z*q + t*g + k + 0.001*u*e))/u| <= @_SINCOS@ }
(1 - o) - h -> -(o - (1 - h));
rnd(1 - o) - h -> (rnd(1 - o) - (1 - o)) - (o - (1 - h));
computed_cosine - cosine -> (computed_cosine - (o + v)) + ((v - (rest + w)) + ((rest + (o - (1 - h))) + ((w - W) - 0.5*(z - Z))));
rest + (o - (1 - h)) -> (rest - (rnd(1 - o) - h)) + (rnd(1 - o) - (1 - o));
$ r in (1b-12, 0.125, 0.5);
