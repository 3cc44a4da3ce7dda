# _TURN u: a pose with columns a, b replaced by c a + s b and c b - s a, Frobenius norm, as a part of the pose's norm.
#
# products: one rounding, p, of |(|a|, |b|)| <= sqrt(2) times |(c s; s c)| = sqrt(2); sums: one, a, of two columns, sqrt(2).
# By hand: "terms", "rows"; l: second order and the bound's own rounding, which _REST.g says.
{ |p| <= 1 /\ |a| <= 1 /\ l in [0,1.0000000002] -> (2*p + sqrt(2)*a)*l - @_TURN@*@_REST@ <= 0 }
