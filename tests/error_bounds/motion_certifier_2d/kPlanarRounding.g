# kPlanarRounding: what a gap of two polygons errs by on a motion (motion_grid_2d.cpp, kinematics_2d.cpp, swept_distance_2d.cpp),
# times (links + 1) `size` `turns`, all roundings of configurations and poses included.
#
# x: 1 / (links + 1), so links / (links + 1) is 1 - x; y: 1 / turns, with turns >= 1 for the sizes of all angles and sums of
# them. `size` for all coordinates and lengths of links, arms and vertices; two points differ by up to 2.
# angle:  a link's, two sums a link, b; columns: parameter 3, 1 - t, product, sum, whole turns 3: 9, c, of all columns.
# turn:   that, and cosine and sine by 1.1u each (kinematic_error/_SINCOS.g), sqrt(2) as a vector, e.
# pose:   the turn times the lengths along the chain; two products and a difference, sqrt(2), a, once for these lengths; a sum a
#         link and one for the body, m; the root's origin, way and arm: five roundings, o. Each as a vector, sqrt(2).
# Both bodies at the ends of an interval, and the computed poses of states between: four poses. The frame's turn acts on 2.
# gap:    the direction to the world, 2 roundings, sqrt(2), f, on 2; to a body's frame, twice; scan, two rounded products, 2
#         each, g; the difference, sqrt(2), d, and the product with the direction, 2, p, of 2; a body in the world: 3, sqrt(2), q.
# length: the direction's is within 4u of 1, n, for the chord deviation; threshold: three roundings, h, of 3.
# circle: of chords and boxes: nine operations on products of the chord with coordinates, up to 2 each way, r.
# bound: links + 1, size and turns are sums: the constant, sums and products, some 3 a link, 1e-12 of it.
# By hand: "terms", "rows", "vectors".
u = 1b-53;
angle = 2*u*b*(1 - x) + 9*u*c*x;
turn = angle + sqrt(2)*1.1*u*e*x*y;
pose = turn + sqrt(2)*2*u*a*x*y + sqrt(2)*u*m*y + sqrt(2)*5*u*o*x*y;
frame = turn*2;
gap = (sqrt(2)*2*u*f*2 + 2*(2*sqrt(2)*2*u*f + 2*2*u*g) + sqrt(2)*u*d*2 + 2*u*p*2 + sqrt(2)*3*u*q)*x*y;
circle = (9*sqrt(2)*u*r*4 + sqrt(2)*3*u*q)*x*y;
threshold = (4*u*n + 3*u*h*3)*x*y;
bound = @kPlanarRounding@*(1 - 1e-12);
{ x in [0,0.5] /\ y in [0,1] /\ |b| <= 1.00000000000001 /\ |c| <= 1.00000000000001 /\ |e| <= 1 /\ |a| <= 1.00000000000001 /\
  |m| <= 1.00000000000001 /\ |o| <= 1.00000000000001 /\ |f| <= 1.00000000000001 /\ |g| <= 1.00000000000001 /\ |d| <= 1 /\
  |p| <= 1.00000000000001 /\ |q| <= 1.00000000000001 /\ |n| <= 1.0001 /\ |h| <= 1.00000000000001 /\ |r| <= 1.00000000000001
  -> (4*pose + frame + gap + threshold) - bound <= 0 /\ (4*pose + circle + threshold) - bound <= 0 }
