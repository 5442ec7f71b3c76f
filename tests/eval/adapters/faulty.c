/* A method that does in its hundredth tick what HAPTICS_FAULT names. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "haptics_method.h"

static const struct haptics_scene* scene;
static int ticks;

static int does(const char* what) {
  const char* const fault = getenv("HAPTICS_FAULT");
  return fault != NULL && strcmp(fault, what) == 0;
}

static const char* load(const struct haptics_scene* given) {
  static struct haptics_scene kept;
  kept = *given;
  scene = &kept;
  ticks = 0;
  return does("refuse") ? "of a bad mood" : NULL;
}

static void place(const double* hip) { (void)hip; }

static void tick(const struct haptics_pose* poses, const double* hip, struct haptics_answer* answer) {
  (void)poses;
  memcpy(answer->ihip_m, hip, sizeof answer->ihip_m);
  if (++ticks != 100) return;
  if (does("crash")) abort();
  if (does("exit")) _exit(7);
  if (does("hang")) pause();
  if (does("nan_force")) answer->force_N[1] = NAN, answer->flags = HAPTICS_TOUCHING;
  if (does("nan_ihip")) answer->ihip_m[2] = INFINITY, answer->flags = HAPTICS_TOUCHING;
  if (does("lie")) answer->force_N[0] = 1;
  if (does("overrun")) memset(answer + 1, 1, 64);
  if (does("spoil")) ((float*)scene->bodies[0].vertices)[0] = 1;
  while (does("allocate")) *(volatile char*)malloc(1 << 26) = 1;
}

static const struct haptics_method_functions functions = {
    HAPTICS_METHOD_ABI, HAPTICS_MOVING_BODIES, "faulty", "", load, place, tick};

const struct haptics_method_functions* haptics_method(void) { return &functions; }
