# _SINCOS_PAIR u: a computed (cosine, sine), as a vector: each errs by _SINCOS u, e f.
#
# By hand: "vectors". _REST covers the rounding of the constant itself.
{ |e| <= @_SINCOS@ /\ |f| <= @_SINCOS@ -> sqrt(e*e + f*f) - @_SINCOS_PAIR@*@_REST@ <= 0 }
