# kDefectRounding: ‖MᵀM − 1‖ as rigidity_defect computes it, in the Frobenius norm.
#
# entry: product and two sums of columns of length 1 + 2e-6 at most, c; three times that for nine entries; minus 1 rounds by u of
# what is left, below 1e-5, as do squares, sums and root, d; and the sum with the constant, s.
# By hand: "terms", "rows".
u = 1b-53;
{ |c| <= 1.00000000000001 /\ |d| <= 1.00000000000001 /\ |s| <= 1
  -> 3*3*u*c*(1 + 3e-6) + 16*u*d*1e-5 + 1e-5*u*s - @kDefectRounding@*(1 + u*s) <= 0 }
