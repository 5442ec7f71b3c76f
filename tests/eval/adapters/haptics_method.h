/* A method of rendering contact with a point, for haptic_eval --method FILE.so, from a shared library in C or C++.
 *
 * The library exports one function, haptics_method(). It runs in a process of its own: a crash, a hang or memory that it
 * spoils is named in its row, and nobody else's. One scene at a time, from one thread. What it prints goes to standard error.
 *
 * Units: metres, newtons, radians. A quaternion is w, x, y, z, of unit length; x_world = rotation * x_body + position. */
#ifndef HAPTICS_METHOD_H
#define HAPTICS_METHOD_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTICS_METHOD_ABI 1u

/* Names as C has them. NOLINTBEGIN(readability-identifier-naming) */

/* What a method can be put under. Scenes that need what it does not declare are "not applicable": neither passed nor failed. */
enum haptics_method_ability {
  HAPTICS_MOVING_BODIES = 1, /* Poses that change from tick to tick. */
  HAPTICS_OPEN_MESHES = 2,   /* Meshes that are not closed: sheets, scans with holes. Felt from both sides. */
  HAPTICS_EDITS = 4,         /* load() under a hand that touches: the scene becomes another one. */
  HAPTICS_FRICTION = 8,
  HAPTICS_SHADING = 16 /* Force shading: one direction of the force over what is rounded. */
};

struct haptics_pose {
  double rotation[4];
  double position[3];
};

struct haptics_body {
  uint32_t vertex_count;
  uint32_t triangle_count;
  uint32_t is_closed; /* 1: every edge joins two triangles that run along it in opposite directions. */
  uint32_t reserved;
  double stiffness_N_per_m;
  double static_friction; /* Coefficients; 0 where the method does not declare friction. */
  double dynamic_friction;
  double crease_rad; /* Of force shading: lines whose faces differ by more stay sharp. 0: the body is not shaded. */
  struct haptics_pose pose;
  const float* vertices;     /* x, y, z of each in the body's frame, m. */
  const uint32_t* triangles; /* Three vertices of each, counter-clockwise seen from outside. */
};

/* Stays where it is, and readable, until the next load(). */
struct haptics_scene {
  uint32_t body_count;
  uint32_t reserved;
  double hip_m[3]; /* Outside of all closed bodies, but in an edit. */
  const struct haptics_body* bodies;
};

enum haptics_answer_flag {
  HAPTICS_TOUCHING = 1,
  HAPTICS_SLIDING = 2,    /* Of friction. */
  HAPTICS_PUT_OUTSIDE = 4 /* Bodies that moved left the IHIP no way in this tick; it was put outside of them. */
};

/* All in the world's frame. */
struct haptics_answer {
  double force_N[3];   /* On the hand; 0 when free. */
  double ihip_m[3];    /* The HIP itself when free. */
  double torque_Nm[3]; /* On the hand, about the HIP. A point has none. */
  uint32_t flags;
  uint32_t triangles; /* Looked at one by one; 0: not counted. */
};

struct haptics_method_functions {
  uint32_t abi; /* HAPTICS_METHOD_ABI. */
  uint32_t abilities;
  const char* name;    /* As tables print it: 1 to 40 letters, digits, '_', '-' and '.'. */
  const char* version; /* Of what it runs, for people. */
  /* Another scene. Returns NULL, or why it cannot be rendered, in words. May take a minute. */
  const char* (*load)(const struct haptics_scene* scene);
  /* The same scene anew, the hand free at another place outside of all closed bodies. */
  void (*place)(const double hip_m[3]);
  /* One tick of 1 ms. `poses` has one for each body. `answer` comes zeroed. May take 5 s. */
  void (*tick)(const struct haptics_pose* poses, const double hip_m[3], struct haptics_answer* answer);
};

/* NULL, or functions of another version: the library is refused with a word. */
__attribute__((visibility("default"))) const struct haptics_method_functions* haptics_method(void);

/* NOLINTEND(readability-identifier-naming) */

#ifdef __cplusplus
}
#endif

#endif
