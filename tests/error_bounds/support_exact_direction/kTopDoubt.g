# kTopDoubt: a top vertex whose rounded product is further below the highest than that, times |u|_1 largest_coordinate, is
# not extreme along the fine direction.
#
# error: of two products: product and two sums, and the direction rounded, c; the comparison's own subtraction, d.
# bound: norm_1 (two sums), times the constant and the coordinate, s.
# By hand: "terms"; what underflows is below kUnderflow, which is subtracted besides.
u = 1b-53;
error = 2*4*u*c + u*d*(1 + 4*u*c);
bound = @kTopDoubt@*(1 + 4*u*s);
{ |c| <= 1.00000000000001 /\ |d| <= 1 /\ |s| <= 1.00000000000001 -> error - bound <= 0 }
