# kFineError: FineDirection::sign in DoubleDouble, times |a − b|_1, entries of the direction below kLargestEntry.
#
# error: of a direction that stands for a dyadic one 2^-105 an entry (dyadic.cpp, direction_of: two doubles of 53 bits),
#        product and two sums, c. The differences of doubles are exact.
# bound: norm_1(e) in doubles, difference and two sums, and times the constant, s; f: the high part rounded to a double.
# By hand: "terms", with Σ |d_k e_k| <= kLargestEntry |e|_1. Nothing underflows between kSmallestFine and kLargestFine.
u = 1b-53;
e = @double_double/kDoubleDoubleError@;
error = @kLargestEntry@*(3*e*c + 1b-105*d);
bound = @kFineError@*(1 + 4*u*s) / (1 + u*f);
{ |c| <= 1.00000000000001 /\ |d| <= 1 /\ |s| <= 1.00000000000001 /\ |f| <= 1 -> error - bound <= 0 }
