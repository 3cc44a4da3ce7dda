# kInflationAlong: of the swell along a direction whose length is 1 up to 4.5u, what the constant leaves open is below 4u of the
# height, which kSupport has left: it proves 26.6u, see kSupport.g.
u = 1b-53;
{ |n| <= 1.0000001 /\ |v| <= 1.00000000000001 -> (1 + 4.5*u*n) - @kInflationAlong@*(1 + 3*u*v) - 4*u <= 0 }
