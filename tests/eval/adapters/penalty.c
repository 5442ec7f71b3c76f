/* The penalty method: in what is solid of a closed mesh a spring pulls the hand to the nearest place of the surface. Every
 * triangle is looked at in every tick.
 *   cc -O2 -ffp-contract=off -shared -fPIC -o penalty.so penalty.c -lm */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "haptics_method.h"

typedef struct {
  double x, y, z;
} vec;

static struct haptics_scene scene;
static struct haptics_body* bodies;
static double* solid_above; /* for each body, of all solid angles together */

static vec at(const double* v) { return (vec){v[0], v[1], v[2]}; }
static vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static vec sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static vec mul(vec a, double s) { return (vec){a.x * s, a.y * s, a.z * s}; }
static double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec cross(vec a, vec b) { return (vec){a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y}; }

static vec rotate(const double* q, double sign, vec v) {
  const vec u = {sign * q[1], sign * q[2], sign * q[3]}, uv = cross(u, v);
  return add(v, mul(add(mul(uv, q[0]), cross(u, uv)), 2));
}

static vec corner(const struct haptics_body* body, uint32_t triangle, int k) {
  const float* v = body->vertices + 3 * body->triangles[3 * triangle + k % 3];
  return (vec){v[0], v[1], v[2]};
}

/* The nearest place of a triangle: its foot in the plane, or on the nearest of the edges that h is beyond. */
static vec nearest_on(const struct haptics_body* body, uint32_t t, vec h) {
  const vec a = corner(body, t, 0), edge2 = sub(a, corner(body, t, 2));
  const vec normal = cross(edge2, sub(corner(body, t, 1), a));
  vec best = sub(h, mul(normal, dot(normal, sub(h, a)) * (1 / dot(normal, normal))));
  double least = INFINITY;
  for (int k = 0; k < 3; ++k) {
    const vec from = corner(body, t, k), edge = sub(corner(body, t, k + 1), from);
    if (dot(cross(normal, edge), sub(h, from)) > 0) continue;
    const double along = dot(sub(h, from), edge), end = dot(edge, edge);
    const vec on = along <= 0 ? from : end <= along ? corner(body, t, k + 1) : add(from, mul(edge, along / end));
    const double distance = dot(sub(h, on), sub(h, on));
    if (distance < least) least = distance, best = on;
  }
  return best;
}

/* Of the sphere about h, as h sees the triangle. Those of a closed mesh are together 4 pi where h is inside and 0 where it is
 * outside; of a room, whose triangles face inwards, -4 pi and 0. */
static double solid_angle(const struct haptics_body* body, uint32_t t, vec h) {
  const vec a = sub(corner(body, t, 0), h), b = sub(corner(body, t, 1), h), c = sub(corner(body, t, 2), h);
  const double la = sqrt(dot(a, a)), lb = sqrt(dot(b, b)), lc = sqrt(dot(c, c));
  return 2 * atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

static double volume(const struct haptics_body* body) {
  double sum = 0;
  for (uint32_t t = 0; t < body->triangle_count; ++t)
    sum += dot(corner(body, t, 0), cross(corner(body, t, 1), corner(body, t, 2)));
  return sum / 6;
}

static const char* load(const struct haptics_scene* given) {
  scene = *given;
  bodies = realloc(bodies, (scene.body_count + 1) * sizeof *bodies);
  memcpy(bodies, given->bodies, scene.body_count * sizeof *bodies);
  solid_above = realloc(solid_above, (scene.body_count + 1) * sizeof *solid_above);
  for (uint32_t i = 0; i < scene.body_count; ++i) solid_above[i] = copysign(6.283185307179586, volume(&bodies[i]));
  return NULL;
}

static void place(const double* hip) { (void)hip; /* It remembers nothing. */ }

static void tick(const struct haptics_pose* poses, const double* hip_m, struct haptics_answer* answer) {
  const vec hip = at(hip_m);
  vec ihip = hip, force = {0, 0, 0};
  double deepest = 0;
  for (uint32_t i = 0; i < scene.body_count; ++i) {
    const struct haptics_body* body = &bodies[i];
    const vec h = rotate(poses[i].rotation, -1, sub(hip, at(poses[i].position)));
    vec foot = h;
    double least = INFINITY, angle = 0;
    for (uint32_t t = 0; t < body->triangle_count; ++t) {
      const vec on = nearest_on(body, t, h);
      const double distance = dot(sub(h, on), sub(h, on));
      if (distance < least) least = distance, foot = on;
      angle += solid_angle(body, t, h);
    }
    answer->triangles += body->triangle_count;
    if (!body->is_closed || angle < solid_above[i] || sqrt(least) <= deepest) continue;
    deepest = sqrt(least);
    ihip = add(rotate(poses[i].rotation, 1, foot), at(poses[i].position));
    force = mul(sub(ihip, hip), body->stiffness_N_per_m);
    answer->flags = HAPTICS_TOUCHING;
  }
  memcpy(answer->ihip_m, &ihip, sizeof ihip);
  memcpy(answer->force_N, &force, sizeof force);
}

static const struct haptics_method_functions functions = {HAPTICS_METHOD_ABI,
                                                          HAPTICS_MOVING_BODIES | HAPTICS_OPEN_MESHES | HAPTICS_EDITS,
                                                          "penalty_c",
                                                          "example",
                                                          load,
                                                          place,
                                                          tick};

const struct haptics_method_functions* haptics_method(void) { return &functions; }
