# kScanError: a rounded product of a direction u and a vertex p is off by at most that times |u|_1 largest_coordinate.
#
# dot(u, p), extreme_of_few, the scans' comparisons in doubles: product and two sums, c; and the sizes' own rounding, s.
# By hand: "terms", with Σ |u_k p_k| <= |u|_1 largest_coordinate.
u = 1b-53;
{ |c| <= 1.00000000000001 -> 3*u*c - @kScanError@ <= 0 }
