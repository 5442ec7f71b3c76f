/* A force-feedback device for haptic_server --device plugin:FILE[:WHICH], from a shared library in C or C++.
 *
 * The library exports one function, haptics_device_plugin(). The server calls what it returns from one thread at a time:
 * once while it starts, to see that the device is there, then from the thread of the device, which is a real-time one.
 *
 * Frame: metres, newtons; x to the right of the user, y away from the user, z up; the origin in the middle of the
 * workspace. A calibration file turns and moves it (--calibration).
 *
 * The device, not the plug-in, has to take its force away when no force was written for 25 ms: the process that the
 * plug-in is in may have died. */
#ifndef HAPTICS_DEVICE_PLUGIN_H
#define HAPTICS_DEVICE_PLUGIN_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTICS_DEVICE_ABI 1u

/* Names as C has them. NOLINTBEGIN(readability-identifier-naming) */

/* What does not change while the device is open. A value of 0 says that it is not known, but for the first two. */
struct haptics_device_info {
  char name[64];      /* For people; ends with 0. */
  double max_force_N; /* Above 0, at most 100: no larger force is written. */
  double max_rate_Hz; /* Above 0: of reads and writes. The server's own rate is no higher. */
  double max_stiffness_N_per_m;
  double max_damping_Ns_per_m;
  double resolution_m; /* Position quantum. */
  double mass_kg;      /* Apparent mass, as at a point, and friction. With the mass the server predicts the hand and */
  double viscous_friction_Ns_per_m; /* limits the stiffness of surfaces to what the device bears; without, neither. */
  double coulomb_friction_N;
  double delay_s;    /* From a position to the motors' force that it led to. */
  uint32_t degrees;  /* Of freedom that it feels: 3 or 6. The server writes no torque yet. */
  uint32_t reserved; /* 0. */
};

/* One position. */
struct haptics_device_state {
  double position_m[3];
  double orientation[4]; /* Unit quaternion w, x, y, z; 1, 0, 0, 0 where there is none. */
  uint32_t age_us;       /* How long ago it was measured. */
  uint32_t buttons;      /* A bit per button, the first eight. */
  uint32_t homed;        /* 0: coordinates are not referenced yet; there is no force before they are. */
  uint32_t reserved;     /* 0. */
};

enum haptics_device_outcome {
  HAPTICS_DEVICE_DONE = 0,    /* read: a new position. write: on its way. */
  HAPTICS_DEVICE_NOTHING = 1, /* read: no new position yet. */
  HAPTICS_DEVICE_GONE = 2     /* It is closed, and opened again later. */
};

struct haptics_device_functions {
  uint32_t abi; /* HAPTICS_DEVICE_ABI. */
  /* Opens the device WHICH names ("" where none is named). Returns NULL and sets *device and *info, or why not, in words
   * that end with 0 and stay until the next call. May take seconds. */
  const char* (*open)(const char* which, void** device, struct haptics_device_info* info);
  /* The newest position that was not read yet; waits for one up to timeout_ns, no longer: the thread that calls is the
   * one that writes forces. */
  int (*read)(void* device, uint64_t timeout_ns, struct haptics_device_state* state);
  /* The force and torque on the hand from now on. Does not wait. */
  int (*write)(void* device, const double force_N[3], const double torque_Nm[3]);
  /* Forces off and everything freed; `device` is not used again. */
  void (*close)(void* device);
};

/* What the library exports. Valid as long as it is loaded, which is to the end of the process. */
const struct haptics_device_functions* haptics_device_plugin(void);

/* NOLINTEND(readability-identifier-naming) */

#ifdef __cplusplus
}
#endif

#endif
