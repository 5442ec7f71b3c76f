/* A plug-in for haptic_server --device plugin:./libudp_device.so[:PORT], whose device is another process on this machine:
 * a simulator, a robot's controller, or a driver that shall not crash the server. */
#include "udp_device.h"

#include <arpa/inet.h>
#include <errno.h>
#include <haptics/device_plugin.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

struct device {
  int socket;
};

static uint64_t now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static int write_force(void* opened, const double force_N[3], const double torque_Nm[3]) {
  struct udp_force force;
  (void)torque_Nm; /* it feels three degrees of freedom */
  memcpy(force.force_N, force_N, sizeof force.force_N);
  /* A port that nobody has is told at the next call on the socket. */
  if (send(((struct device*)opened)->socket, &force, sizeof force, MSG_DONTWAIT) >= 0) return HAPTICS_DEVICE_DONE;
  return errno == ECONNREFUSED ? HAPTICS_DEVICE_GONE : HAPTICS_DEVICE_NOTHING;
}

static int read_state(void* opened, uint64_t timeout_ns, struct haptics_device_state* state) {
  struct pollfd ready = {((struct device*)opened)->socket, POLLIN, 0};
  const struct timespec timeout = {(time_t)(timeout_ns / 1000000000u), (long)(timeout_ns % 1000000000u)};
  struct udp_state newest, next;
  ssize_t length, found = 0;
  uint64_t now;
  if (ppoll(&ready, 1, &timeout, NULL) <= 0) return HAPTICS_DEVICE_NOTHING;
  while ((length = recv(ready.fd, &next, sizeof next, MSG_DONTWAIT | MSG_TRUNC)) >= 0) {
    found = length;
    newest = next;
  }
  if (found == 0) return errno == ECONNREFUSED ? HAPTICS_DEVICE_GONE : HAPTICS_DEVICE_NOTHING;
  if (found != sizeof newest) return -1; /* no state: the server counts it */
  now = now_ns();
  memset(state, 0, sizeof *state);
  memcpy(state->position_m, newest.position_m, sizeof state->position_m);
  state->orientation[0] = 1;
  state->age_us = newest.measured_ns < now ? (uint32_t)((now - newest.measured_ns) / 1000u) : 0;
  state->buttons = newest.buttons;
  state->homed = newest.homed;
  return HAPTICS_DEVICE_DONE;
}

static void close_device(void* opened) {
  const double none[3] = {0, 0, 0};
  (void)write_force(opened, none, none);
  close(((struct device*)opened)->socket);
  free(opened);
}

static const char* open_device(const char* which, void** opened, struct haptics_device_info* info) {
  const struct haptics_device_info what = {.name = "arm in another process",
                                           .max_force_N = 5,
                                           .max_rate_Hz = 1000,
                                           .max_stiffness_N_per_m = 1000,
                                           .max_damping_Ns_per_m = 5,
                                           .resolution_m = 2e-5,
                                           .mass_kg = 0.1,
                                           .viscous_friction_Ns_per_m = 0.2,
                                           .coulomb_friction_N = 0.1,
                                           .delay_s = 1e-3,
                                           .degrees = 3};
  static char reason[96];
  struct haptics_device_state state;
  struct sockaddr_in address;
  const double none[3] = {0, 0, 0};
  char* end;
  const unsigned long port = which[0] ? strtoul(which, &end, 10) : UDP_DEVICE_PORT;
  struct device* device;
  if ((which[0] && *end) || port == 0 || port > 65535) return "after the second colon a port is wanted, as in :17070";
  device = malloc(sizeof *device);
  if (!device) return "there is no memory";
  device->socket = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  memset(&address, 0, sizeof address);
  address.sin_family = AF_INET;
  address.sin_port = htons((uint16_t)port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (device->socket < 0 || connect(device->socket, (struct sockaddr*)&address, sizeof address) != 0 ||
      write_force(device, none, none) != HAPTICS_DEVICE_DONE ||
      read_state(device, 500000000u, &state) != HAPTICS_DEVICE_DONE) {
    snprintf(reason, sizeof reason, "no device answers at UDP port %lu of this machine: start udp_arm", port);
    if (device->socket >= 0) close(device->socket);
    free(device);
    return reason;
  }
  *opened = device;
  *info = what;
  return NULL;
}

const struct haptics_device_functions* haptics_device_plugin(void) {
  static const struct haptics_device_functions plugin = {HAPTICS_DEVICE_ABI, open_device, read_state, write_force,
                                                         close_device, NULL};
  return &plugin;
}
