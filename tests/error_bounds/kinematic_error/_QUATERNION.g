# _QUATERNION u: a unit quaternion's matrix, Frobenius norm.
#
# _QUATERNION_LINEAR s, p; w times the vector: one product, q, of 2 |w| |v| twice, sqrt(8) sqrt(s (1 - s)); the last operation
# of each entry, e, of the matrix, sqrt(3).
# By hand: A s + B sqrt(s (1 - s)) <= A/2 + |(A, B)|/2 (Cauchy-Schwarz on 2s - 1 and 2 sqrt(s (1 - s)), which are a unit vector).
A = @_QUATERNION_LINEAR@;
{ |p| <= 1 /\ |e| <= 1 /\ l in [0,1.0000000002]
  -> ((A + sqrt(A*A + 8))/2*p + sqrt(3)*e)*l - @_QUATERNION@*@_REST@ <= 0 }
