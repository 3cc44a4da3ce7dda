# _MULTIPLY u: a pose times a rotation, 3 x 3 both, Frobenius norm, as a part of the pose's norm.
#
# An entry by a product and two sums, p, each times |R| and |M| in the Frobenius norm, sqrt(3) both.
# By hand: "rows"; l: second order and the bound's own rounding, which _REST.g says.
{ |p| <= 1.00000000000001 /\ l in [0,1.0000000002] -> 3*sqrt(3)*sqrt(3)*p*l - @_MULTIPLY@*@_REST@ <= 0 }
