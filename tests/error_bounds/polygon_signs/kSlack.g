# kSlack: a sum of positive terms that are bounds, computed with at most 16 roundings, s, times this is no less than it.
u = 1b-53;
{ |s| <= 1.00000000000001 -> 1 - @kSlack@*(1 + 16*u*s) <= 0 }
