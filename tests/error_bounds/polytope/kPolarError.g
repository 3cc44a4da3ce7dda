# kPolarError: a polar point n / h, as a vector, times its length.
#
# polar_point: numerators' high parts, rounded once, a, the height likewise, b, the quotient, c; and before 2^-60 of the largest
# numerator, √3 as a vector, x, and 2^-60 of the height, y, where its branch `precise` holds; exactly 0 else.
# By hand: why `precise` means 2^-60 (sizes times kDoubleDoubleError and some operations), "vectors".
u = 1b-53;
{ |a| <= 1 /\ |b| <= 1 /\ |c| <= 1 /\ |x| <= 1 /\ |y| <= 1
  -> (1 + u*a + sqrt(3)*1b-60*x)*(1 + u*c) / ((1 + u*b)*(1 + 1b-60*y)) - 1 - @kPolarError@ <= 0 }
