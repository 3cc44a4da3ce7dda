# kMixedError: two products of sides or weights and their sum, times the sum of the products' absolute values.
#
# error: PlanarSigns::mixed and value: product and sum, c.
# bound: |first| + |second| of rounded products: product, sum, times the constant, added to the other bounds, s; kSlack is
#        for those.
# By hand: "terms". What underflows: sizes are above 1e-100 and products of two of them above 1e-200.
u = 1b-53;
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 -> 2*u*c - @kMixedError@*(1 + 4*u*s) <= 0 }
