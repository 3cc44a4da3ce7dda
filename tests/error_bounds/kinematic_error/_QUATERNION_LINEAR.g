# _QUATERNION_LINEAR u s: of a quaternion's matrix, what the products of its vector v, |v|^2 = s, err by.
#
# Diagonal, 1 - (yy + zz) and so on: a product, then a sum, p, of entries 2 (y^2 + z^2), as a vector at most 2 sqrt(2) s, which
# one axis reaches: sqrt(32) s. Beside it xy, xz, yz, each in two entries: a product, q, of 2 |x| |y|, as a vector
# 2 sqrt(2) s / sqrt(3) at most: sqrt(8/3) s.
# By hand: "vectors"; x^2 y^2 + x^2 z^2 + y^2 z^2 <= s^2 / 3.
{ |p| <= 1.00000000000001 /\ |q| <= 1 /\ l in [0,1.0000000002]
  -> (2*2*sqrt(2)*p + 2*sqrt(2)/sqrt(3)*q)*l - @_QUATERNION_LINEAR@*@_REST@ <= 0 }
