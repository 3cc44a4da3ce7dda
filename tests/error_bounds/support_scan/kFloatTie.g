# kFloatTie: in a scan in floats a vertex whose product is further than that below the highest, times the direction's
# largest entry, is not extreme.
#
# Scaled by a power of two so that the largest entry L is in [1, 2]: dx dy dz are FloatDirection's entries (x, y, z),
# bx by bz a block's, points in parts of the largest coordinate: 1 + 2^-52 for the quotient in doubles. tie: of the two
# products the one found and the one that is extreme may each be off; best − tie is subtracted in floats. Underflow is
# in the model. By hand: a scan's maximum is that of its products, whatever their number.
@single = float<ieee_32, ne>;
x = single(single(L*dx)*single(bx));
y = single(single(L*dy)*single(by));
z = single(single(L*dz)*single(bz));
scanned = single(single(x + y) + z);
exact = L*dx*bx + L*dy*by + L*dz*bz;
tie = single(@kFloatTie@*single(L));
ties = single(best - tie);
{ L in [1,2] /\ |dx| <= 1 /\ |dy| <= 1 /\ |dz| <= 1 /\ |bx| <= 1.0000000001 /\ |by| <= 1.0000000001 /\ |bz| <= 1.0000000001 /\
  |best / L| <= 3.0001
  -> |scanned - exact| / L <= 14b-24 /\ (2*14b-24*L + (ties - (best - tie)) - tie) / L <= 0 }
$ L in 64;
