# _REST: all that is not of first order in u, and the rounding of the bound itself, as a part of the bound.
#
# Up to 16 roundings one after another on an entry, c. What is multiplied is off already: |R'| <= |R| + turn, products of two
# errors, turn times theirs: turn is at most _LARGEST_TURN, x y, of norms above 0.99, as links may be off rigid by 3.6e-6. A
# joint takes the bound up to 16 operations in doubles, s, of 100,000 joints in a row.
# By hand: every term is at most so much larger at each joint, not once more a joint: all are compared with the first order.
u = 1b-53;
T = @_LARGEST_TURN@/0.99;
{ |c| <= 1.00000000000001 /\ |x| <= 1 /\ |y| <= 1 /\ |s| <= 1.000001
  -> (1 + 16*u*c)*(1 + T*x)*(1 + T*y)*(1 + 1600000*u*s) - @_REST@ <= 0 }
