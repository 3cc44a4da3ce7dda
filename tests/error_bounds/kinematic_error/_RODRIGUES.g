# _RODRIGUES u: the matrix c + (1 - c) a a^T + s [a], |a| = 1, Frobenius norm.
#
# 1 - c and two products, p, on (1 - c) |a a^T| = 1 - c; s a, one product, q, on |s| |[a]| = sqrt(2) |s|; the last sum of each
# entry, e, of the matrix, sqrt(3). 3 (1 - c) + sqrt(2) |s| <= 3 + sqrt(11), which is 3 + |(3, sqrt(2))|: c = x, s = y.
# By hand: "terms", Cauchy-Schwarz: 3 |x| + sqrt(2) |y| <= sqrt(11) z if x^2 + y^2 = z^2.
{ |p| <= 1.00000000000001 /\ |e| <= 1 /\ z in [0,1] /\ l in [0,1.0000000002]
  -> ((3 + sqrt(11)*z)*p + sqrt(3)*e)*l - @_RODRIGUES@*@_REST@ <= 0 }
