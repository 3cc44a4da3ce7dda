# _STRETCH: the norm of a quaternion's or a pair's matrix, of length 1 + e, |e| <= UNIT_TOLERANCE; and what the length does
# to the roundings of its entries, which are of degree 2.
#
# A quaternion maps the plane at right angles to v by a length whose square is 1 + 4 |v|^2 (n - 1), n = (1 + e)^2, |v|^2 <= n
# (robots/unit_lengths.py). By hand: sqrt(1 + x) <= 1 + x/2.
n = (1 + e)*(1 + e);
{ e in [0,2e-7] -> 1 + 2*n*(n - 1) - @_STRETCH@ <= 0 /\ n - @_STRETCH@ <= 0 }
