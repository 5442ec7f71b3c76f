/* What the plug-in and the process of the device send each other, on one machine. */
#ifndef UDP_DEVICE_H
#define UDP_DEVICE_H

#include <stdint.h>

#define UDP_DEVICE_PORT 17070

struct udp_force { /* to the device; it answers whoever sent the last one */
  double force_N[3];
};

struct udp_state {      /* from the device, 1,000 times a second */
  uint64_t measured_ns; /* CLOCK_MONOTONIC */
  double position_m[3];
  uint32_t buttons, homed;
};

#endif
