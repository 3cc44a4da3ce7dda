# kFineHeightError: of a height in double-double, rounded to doubles and divided by the length of the rounded normal.
#
# high: without its low part, h.   normal: each entry without its low part, n.   norm: 2.5u, r, and in units of the largest
# entry two quotients' worth more, l.   quotient: q.   minus: the height less the bound, m.   bound: s.
u = 1b-53;
{ |h| <= 1.00000000000001 /\ |n| <= 1.00000000000001 /\ |r| <= 1.0000001 /\ |l| <= 1.0000001 /\ |q| <= 1.00000000000001 /\
  |m| <= 1.00000000000001 /\ |s| <= 1.00000000000001
  -> u*h + u*n + 2.5*u*r + 2*u*l + u*q + u*m - @kFineHeightError@*(1 + 4*u*s) <= 0 }
