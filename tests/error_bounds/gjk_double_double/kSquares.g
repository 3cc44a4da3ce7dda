# kSquares: the difference of two squares, times the larger, that separates() and within_swell() want to see positive.
#
# first:  above² or reach²: a product (and the factors' own sums and products, four at most), a.
# second: swell² |d|² or |mixture|²: products and sums, at most five, b, at most the first.
# the difference itself, times both, d; f: high parts.
u = 1b-53;
e = @double_double/kDoubleDoubleError@;
{ |a| <= 1.00000000000001 /\ |b| <= 1.00000000000001 /\ |d| <= 1 /\ |f| <= 1
  -> 5*e*a + 5*e*b + 2*e*d - @kSquares@*(1 + 3*u*f) <= 0 }
