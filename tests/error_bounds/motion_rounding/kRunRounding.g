# kRunRounding: what a gap of two bodies errs by on a motion (motion_filters.cpp, swept_distance.cpp), times `size`, besides
# the errors of kinematics, placements off rigid and lengths off 1, which the other terms of motion_rounding are for.
#
# S <= size: how far points, bodies' origins and centres are from the world's origin, and swells; two points |w| <= 2 S.
# frame:   the turn of the computed pose of the link in whose frame a direction is, up to 800u, acts on w.
# parts:   a quaternion between the ends (normalised, product, log_of, exp_of, product) errs by 62u, its matrix by twice
#          that, where "8u of the ends' numbers", four of up to 1, has 54u: 71u more for each body, of two such parts.
# towards: the direction in the world, by a product and two sums, sqrt(3) as a vector, times w.
# threshold: the direction's length is within 4.5u of 1, as in gjk/kSupport.g; chord deviation, swells and slack by four roundings;
#          both of at most 4 S.
# gap:     of each body: the direction in its frame, twice; scan, two rounded products; vertex by a product and three sums;
#          origin by the last sum. Then the difference, of w, and the product with the direction.
# boxes:   of each body: origin, product, two sums and three more; corners' products: direction 3, half and middle 1,
#          product 1, difference 1, sums 3, of entries up to S, sqrt(3); the sum of both bodies, of 1 + sqrt(3) each.
# spheres: of each body: centre on its link by a product and three sums, posed by a product and two sums, its origin by 2;
#          difference; turned back; squares, products and sums 6, of at most 3 times the square at hand ("chord").
# box:     one centre; less the body's origin; turned back; square and root, 3.
# path:    one centre, grown by four sums; a corner of a body that stands still by a product and four sums.
# way: no less than what each of these five takes.
# c: chains of roundings; h: norms and thresholds; s: the bound's own sums and products, 12.
# By hand: "terms", "rows", "vectors", "scan", "chord"; "sizes": that S <= size.
u = 1b-53;
w = 2*l;
frame = 800*u*w + 2*2*71*u*l;
towards = sqrt(3)*3*u*c*w;
threshold = 4.5*u*h*4*l + 4*u*h*4*l;
centre = (sqrt(3)*4 + 1 + sqrt(3)*3 + 2)*u*c*l;
gap = 2*(2*sqrt(3)*3*u*c + 2*3*u*c + sqrt(3)*4*u*c + u*c)*l + u*c*w + 3*u*c*w;
boxes = 2*(6*u*c + sqrt(3)*9*u*c + (1 + sqrt(3))*u*c)*l;
spheres = 2*centre + u*c*w + sqrt(3)*3*u*c*w + 6*3*u*c*l;
box = centre + u*c*w + sqrt(3)*3*u*c*w + 3*u*h*w;
path = centre + 4*u*h*4*l + (sqrt(3)*5 + 2)*u*c*l;
way = 70*u;
bound = @kRunRounding@*(1 + 12*u*s);
{ |c| <= 1.00000000000001 /\ |s| <= 1.00000000000001 /\ |h| <= 1.0000001 /\ l in [0,1.00001]
  -> towards + gap - way <= 0 /\ towards + boxes - way <= 0 /\ spheres - way <= 0 /\ box - way <= 0 /\
     path - way <= 0 /\ frame + way + threshold - bound <= 0 }
